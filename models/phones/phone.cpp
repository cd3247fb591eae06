// See phone.h.
#include "models/phones/phone.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "runtime/scene/scene.h"

namespace sandglass::host {

namespace {

struct UnitRow {
  std::string_view name;
  double base, per_item;
};
constexpr UnitRow k_rows[] = {
#include "models/phones/unit_instructions.inc"
};

constexpr double k_guessed_instructions = 20'000;

const UnitRow* row_of(std::string_view name) {
  const auto row = std::find_if(std::begin(k_rows), std::end(k_rows), [&](const UnitRow& r) { return r.name == name; });
  return row != std::end(k_rows) ? row : nullptr;
}

}  // namespace

double PhoneCore::middle_ipc() const { return std::sqrt(ipc_low * ipc_high); }

// The upper ends are below what the cores can issue: Arm's software optimisation guides state six instructions a cycle
// and four pipes for 128-bit vectors (X3), four and two (A78), and two, with vectors of 64 bits, in order (A55). The
// lower ends allow for caches that miss. Clocks are those of phones that were sold with these cores.
const std::vector<PhoneCore>& phone_cores() {
  static const std::vector<PhoneCore> cores = {
      {"cortex-x3", 2.9, 2.0, 4.0, "out of order, 6 wide, four 128-bit vector pipes"},
      {"cortex-a78", 2.4, 1.5, 3.0, "out of order, 4 wide, two 128-bit vector pipes"},
      {"cortex-a55", 1.8, 0.5, 1.2, "in order, 2 wide, two 64-bit vector pipes"}};
  return cores;
}

std::vector<std::string> phone_core_names() {
  std::vector<std::string> names;
  for (const PhoneCore& core : phone_cores()) names.emplace_back(core.name);
  return names;
}

const PhoneCore& phone_core(const std::string& name) {
  const std::vector<PhoneCore>& cores = phone_cores();
  return *std::find_if(cores.begin(), cores.end() - 1, [&](const PhoneCore& core) { return name == core.name; });
}

double unit_instructions(const std::string& name, uint32_t items) {
  const UnitRow* row = row_of(name);
  return row != nullptr ? row->base + row->per_item * items : 0.0;
}

sandglass_clock PhoneClock::clock() {
  return {[](void* user) {
            const PhoneClock& self = *static_cast<PhoneClock*>(user);
            return static_cast<uint64_t>(1e6 * self.core_.ms(self.instructions_, self.core_.middle_ipc()));
          },
          this};
}

void PhoneClock::follow(sandglass_scene* scene) {
  scene->governor.observer = {
      [](void* user, const WorkUnit& unit) { static_cast<PhoneClock*>(user)->charge(unit.name, unit.items); }, this};
}

void PhoneClock::charge(const char* name, uint32_t items) {
  const double counted = unit_instructions(name, items);
  if (!(counted > 0)) ++guessed_[name];
  instructions_ += counted > 0 ? counted : k_guessed_instructions;
}

}  // namespace sandglass::host

// What a phone's core would take for a scene, estimated. No phone is timed: every work unit is charged with the NEON
// instructions that units of its kind were counted to execute under emulation (unit_instructions.inc), and a core is a
// clock rate and a range of instructions a cycle. Caches, throttling and other programs are only in that range.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

// A core as stated, not as measured.
struct PhoneCore {
  const char* name;          // as on the command line
  double ghz;                // sustained
  double ipc_low, ipc_high;  // instructions a cycle
  const char* why;           // where clock and range come from

  double middle_ipc() const;  // the geometric mean
  double ms(double instructions, double ipc) const { return instructions / (ipc * ghz * 1e6); }
};

const std::vector<PhoneCore>& phone_cores();
std::vector<std::string> phone_core_names();
const PhoneCore& phone_core(const std::string& name);  // one of those names

// Instructions of a unit of that name and size; 0 where the kind was not counted.
double unit_instructions(const std::string& name, uint32_t items);

// The clock of a scene that runs on such a core: it moves with every work unit, at the middle of the core's range. So
// the governor plans as it would there, and equal scenes give equal plans on every machine.
class PhoneClock {
 public:
  explicit PhoneClock(const PhoneCore& core) : core_(core) {}
  PhoneClock(const PhoneClock&) = delete;
  PhoneClock& operator=(const PhoneClock&) = delete;

  sandglass_clock clock();
  void follow(sandglass_scene* scene);  // charges its work units from now on

  const PhoneCore& core() const { return core_; }
  // Kinds of work unit that were not counted, and how many of their units ran. Each is taken as 20,000 instructions.
  const std::map<std::string, uint64_t>& guessed() const { return guessed_; }

 private:
  void charge(const char* name, uint32_t items);

  const PhoneCore& core_;
  double instructions_ = 0.0;
  std::map<std::string, uint64_t> guessed_;
};

}  // namespace sandglass::host

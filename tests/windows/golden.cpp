// Plays a scene that web_scene wrote, on a virtual clock, through the DLL, and prints its hash:
//     sandglass_golden run demo --frames N --clock virtual --isa NAME --scene FILE [--friction NUMBER]
// It takes the words that the command-line program takes, so tests/golden/golden.sh runs both.
#include <fcntl.h>
#include <io.h>

#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace {

using Json = nlohmann::json;

// Floats from base64 of their bytes.
std::vector<float> floats_of(const std::string& text) {
  constexpr std::string_view k_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<uint8_t> bytes;
  uint32_t bits = 0, count = 0;
  for (const char letter : text) {
    if (letter == '=') break;
    bits = bits << 6 | static_cast<uint32_t>(k_digits.find(letter));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<uint8_t>(bits >> count));
  }
  std::vector<float> floats(bytes.size() / sizeof(float));
  memcpy(floats.data(), bytes.data(), floats.size() * sizeof(float));
  return floats;
}

void check(const sandglass::Status& status) {
  if (!status) throw std::runtime_error(status.reason);
}

sandglass_isa isa_named(const std::string& name) {
  for (sandglass_isa isa = 0; isa < 16; ++isa)
    if (const char* known = sandglass_isa_name(isa); known != nullptr && name == known) return isa;
  throw std::runtime_error("there is no instruction set " + name);
}

void play(std::map<std::string, std::string> options) {
  const Json file = Json::parse(std::ifstream(options.at("--scene")));
  if (!file.at("emitters").empty()) throw std::runtime_error("the scene has emitters: take the demo scene");
  static uint64_t reading = 0, step;
  step = file.at("virtual_step_ns");
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = {[](void*) { return reading += step; }, nullptr};
  desc.isa = isa_named(options.at("--isa"));
  const Json& given = file.at("granular");
  auto& g = desc.granular;
  for (const auto& [name, field] : std::map<std::string, uint32_t*>{{"particle_capacity", &g.particle_capacity},
                                                                    {"grain_capacity", &g.grain_capacity},
                                                                    {"emitter_capacity", &g.emitter_capacity},
                                                                    {"collider_capacity", &g.collider_capacity}})
    *field = given.at(name);
  for (const auto& [name, field] : std::map<std::string, float*>{{"particle_radius", &g.particle_radius},
                                                                 {"grain_radius", &g.grain_radius},
                                                                 {"static_friction", &g.static_friction},
                                                                 {"kinetic_friction", &g.kinetic_friction},
                                                                 {"height_weighting", &g.height_weighting},
                                                                 {"courant", &g.courant},
                                                                 {"substep_max", &g.substep_max},
                                                                 {"substep_min", &g.substep_min},
                                                                 {"list_skin", &g.list_skin},
                                                                 {"sleep_after", &g.sleep_after},
                                                                 {"refine_step", &g.refine_step}})
    *field = given.at(name);
  if (options.contains("--friction")) g.static_friction = std::stof(options["--friction"]);
  file.at("gravity").get_to(desc.gravity);
  sandglass::Scene scene;
  check(scene.create(desc));
  if (sandglass_scene_isa(scene.get()) != desc.isa) throw std::runtime_error("the scene runs on another set");

  const auto array = [&](const char* name) { return floats_of(file.at(name)); };
  const auto particles = array("particles"), particle_velocities = array("particle_velocities");
  const auto grains = array("grains"), grain_velocities = array("grain_velocities");
  const auto points = [](const std::vector<float>& at, const std::vector<float>& velocities) {
    return sandglass_points{at.data(), velocities.data(), static_cast<uint32_t>(at.size() / 3)};
  };
  const sandglass_points of_particles = points(particles, particle_velocities),
                         of_grains = points(grains, grain_velocities);
  const char* reason = nullptr;
  if (sandglass_granular_add(scene.get(), &of_particles, &of_grains, &reason)) throw std::runtime_error(reason);

  std::vector<sandglass_collider> colliders(file.at("colliders").size());
  for (size_t i = 0; i < colliders.size(); ++i) {
    const Json& c = file.at("colliders")[i];
    if (c.contains("field")) throw std::runtime_error("a collider is a mesh: take the demo scene");
    colliders[i].shape = c.at("shape");
    c.at("position").get_to(colliders[i].position);
    c.at("rotation").get_to(colliders[i].rotation);
    c.at("size").get_to(colliders[i].size);
  }
  std::vector<sandglass_grain> drawn(g.grain_capacity);
  const double budget_ms = file.at("budget_ms");
  sandglass_frame_input input = sandglass::frame_input(file.at("frame_step"), static_cast<uint64_t>(1e6 * budget_ms));
  input.colliders = colliders.data(), input.collider_count = static_cast<uint32_t>(colliders.size());
  input.grains = drawn.data(), input.grain_capacity = g.grain_capacity;
  sandglass_frame_report report = sandglass::frame_report();
  for (int left = std::stoi(options.at("--frames")); left > 0; --left) check(scene.frame(input, &report));
  std::printf("%u particles\nhash 0x%016" PRIx64 "\n", report.sand.particles, sandglass_scene_hash(scene.get()));
}

}  // namespace

int main(int count, char** words) try {
  _setmode(1, _O_BINARY);  // lines end as the script expects
  std::map<std::string, std::string> options;
  for (int i = 3; i + 1 < count; i += 2) options[words[i]] = words[i + 1];
  play(options);
  return 0;
} catch (const std::exception& failure) {
  return std::fprintf(stderr, "sandglass_golden: %s\n", failure.what()), 1;
}

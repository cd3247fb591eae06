// Plays the demo scene on a virtual clock, through the DLL, and prints its hash:
//     sandglass_golden run demo --frames N --clock virtual --isa NAME [--friction NUMBER]
// It takes the words that the command-line program takes, so tests/golden/golden.sh runs both.
#include <fcntl.h>
#include <io.h>

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "sandglass/sandglass.hpp"
// After it: of scene_header.py.
#include "demo_scene.h"

namespace {

int failed(const char* why) {
  std::fprintf(stderr, "sandglass_golden: %s\n", why);
  return 1;
}

uint64_t virtual_now(void*) {
  static uint64_t reading = 0;
  return reading += k_virtual_step_ns;
}

sandglass_isa isa_named(const char* name) {
  for (sandglass_isa isa = 0; isa < 16; ++isa)
    if (const char* known = sandglass_isa_name(isa); known != nullptr && strcmp(name, known) == 0) return isa;
  return -1;
}

}  // namespace

int main(int count, char** words) {
  _setmode(1, _O_BINARY);  // lines end as the script expects
  if (count != 9 && count != 11) return failed("the command is not as golden.cpp says");
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = {virtual_now, nullptr};
  desc.isa = isa_named(words[8]);
  memcpy(desc.gravity, k_gravity, sizeof k_gravity);
  describe(&desc.granular);
  if (count == 11) desc.granular.static_friction = static_cast<float>(std::atof(words[10]));
  sandglass::Scene scene;
  sandglass::Status status = scene.create(desc);
  if (!status) return failed(status.reason);
  if (sandglass_scene_isa(scene.get()) != desc.isa) return failed("the scene runs on another instruction set");

  const sandglass_points particles = {k_particles, k_particle_velocities, std::size(k_particles) / 3};
  const sandglass_points grains = {k_grains, k_grain_velocities, std::size(k_grains) / 3};
  status.code = sandglass_scene_add(scene.get(), &particles, &grains, &status.reason);
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);
  sandglass_frame_input input = sandglass::frame_input(k_frame_step, k_budget_ns);
  input.colliders = k_colliders;
  input.collider_count = std::size(k_colliders);
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;
  sandglass_frame_report report = sandglass::frame_report();
  for (int left = std::atoi(words[4]); status && left > 0; --left) status = scene.frame(input, &report);
  if (!status) return failed(status.reason);
  std::printf("%u particles\nhash 0x%016" PRIx64 "\n", report.sand.particles, sandglass_scene_hash(scene.get()));
  return 0;
}

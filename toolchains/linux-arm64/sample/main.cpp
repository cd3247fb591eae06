// Pours a block of sand onto the floor for one second of simulated time, with a budget of 4 ms a frame, and says which
// kernels ran. The hash is the same on every machine if the plan is the same. Here it is: no clock is handed over, so
// every frame runs all its work.
#include <cinttypes>
#include <cstdio>
#include <vector>

#include "sandglass/sandglass.hpp"

int main() {
  std::vector<float> particles;
  const float r = 0.01f;
  for (int y = 0; y < 8; ++y)
    for (int z = 0; z < 6; ++z)
      for (int x = 0; x < 6; ++x)
        for (int cell : {x, y + 1, z}) particles.push_back(2.0f * r * static_cast<float>(cell));

  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_radius = r;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.collider_capacity = 1;

  sandglass::Scene scene;
  sandglass::Status status = scene.create(desc);
  if (status) status = scene.add(particles);

  const sandglass_collider floor = sandglass::floor_at(0.0f);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  input.budget_ns = 4'000'000;
  input.colliders = &floor;
  input.collider_count = 1;
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; status && frame < 60; ++frame) status = scene.frame(input, &report);
  if (!status) {
    std::fprintf(stderr, "%s: %s\n", status.name(), status.reason);
    return 1;
  }

  std::printf("%u particles, %s kernels, %.2f s, fastest %.3f m/s\nhash 0x%016" PRIx64 "\n", report.sand.particles,
              sandglass_isa_name(scene.isa()), report.time.simulated, static_cast<double>(report.sand.speed_max),
              scene.hash());
  return report.sand.particles == particles.size() / 3 && report.sand.quarantined == 0 ? 0 : 1;
}

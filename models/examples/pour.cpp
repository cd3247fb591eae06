// A nozzle pours sand onto a moving hand and the floor: 4 ms a frame for four seconds.
#include <cmath>
#include <cstdio>
#include <vector>

#include "sandglass/sandglass.hpp"

int main() {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_radius = 0.01f;    // metres
  desc.granular.particle_capacity = 3000;   // collide with each other
  desc.granular.grain_capacity = 8 * 3000;  // are drawn
  desc.granular.emitter_capacity = 1;
  sandglass::Scene scene;
  sandglass::Status status = scene.create(desc);  // the only allocation

  // Half a metre above the floor: radius 4 cm, 0.5 m/s, 8 grains with every particle.
  const sandglass_emitter nozzle = sandglass::emitter(0.0f, 0.5f, 0.0f, 0.04f, 0.5f, 8);
  sandglass_collider colliders[] = {sandglass::floor_at(0.0f), sandglass::sphere(0.0f, 0.25f, 0.0f, 0.06f)};
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);  // an app hands over its mapped GPU buffer
  sandglass_frame_input input = sandglass::frame_input(1.0f / 60.0f, 4'000'000);
  input.emitters = &nozzle;
  input.emitter_count = 1;
  input.colliders = colliders;
  input.collider_count = 2;
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; status && frame < 240; ++frame) {
    const float t = 2.0f * input.time_step * static_cast<float>(frame);
    colliders[1].position[0] = 0.1f * std::sin(t);
    colliders[1].linear_velocity[0] = 0.2f * std::cos(t);
    status = scene.frame(input, &report);
  }
  if (!status) return std::fprintf(stderr, "%s: %s\n", status.name(), status.reason), 1;
  std::printf("%u particles, %u grains, %s kernels: last frame %.2f of 4 ms, quality level %s, time debt %.3f s\n",
              report.sand.particles, report.sand.grains, sandglass_isa_name(scene.isa()),
              1e-6 * static_cast<double>(report.time.elapsed_ns), sandglass_level_name(report.level), report.time.debt);
}

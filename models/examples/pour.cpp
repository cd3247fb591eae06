// A nozzle pours sand onto a moving hand and the floor: 4 ms a frame for four seconds.
#include <cmath>
#include <cstdio>
#include <vector>

#include "sandglass/sandglass.hpp"

int main() {
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_capacity = 3000;
  desc.granular.emitter_capacity = 1;
  sandglass::Scene scene;
  sandglass::Skin skin;                           // what is drawn: the sand's surface, as a mesh
  sandglass::Status status = scene.create(desc);  // these two allocate, and nothing else
  if (status) status = skin.create(sandglass::skin_desc(desc.granular));
  const sandglass_emitter nozzle = sandglass::emitter(0.0f, 0.5f, 0.0f, 0.04f, 0.5f);  // 4 cm wide, 0.5 m/s
  sandglass_collider colliders[] = {sandglass::floor_at(0.0f), sandglass::sphere(0.0f, 0.25f, 0.0f, 0.06f)};
  sandglass_frame_input input = sandglass::frame_input(1.0f / 60.0f, 4'000'000);
  input.emitters = &nozzle;
  input.emitter_count = 1;
  input.colliders = colliders;
  input.collider_count = 2;
  input.skin = skin.get();
  sandglass_frame_report report = sandglass::frame_report();
  std::vector<uint32_t> shown;  // versions of the mesh's chunks: an app uploads what is new, and draws all
  for (int frame = 0; status && frame < 240; ++frame) {
    const float t = 2.0f * input.time_step * static_cast<float>(frame);
    colliders[1].position[0] = 0.1f * std::sin(t);
    colliders[1].linear_velocity[0] = 0.2f * std::cos(t);
    status = scene.frame(input, &report);
    shown.resize(skin.mesh().chunk_count);
    for (size_t i = 0; i < shown.size(); ++i) shown[i] = skin.mesh().chunks[i].version;
  }
  if (!status) std::fprintf(stderr, "%s: %s\n", status.name(), status.reason);
  std::printf("%u particles under %u vertices in %zu chunks, quality level %s, time debt %.3f s\n",
              report.sand.particles, skin.mesh().vertex_count, shown.size(), sandglass_level_name(report.level),
              report.time.debt);
  return status ? 0 : 1;
}

// A pile as a phone would pour it, frame by frame; what an app uploads is counted as it would upload it.
#include <algorithm>
#include <limits>
#include <string>

#include "models/files/failure.h"
#include "models/simulation/simulation.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/shot/look_rows.h"

namespace sandglass::host {

std::vector<Verdict> handed_over(uint32_t particles) {
  std::vector<Verdict> rows;
  constexpr float k_radius = 0.006f, k_step = 1.0f / 60.0f;
  constexpr uint32_t k_last_frames = 60;
  sandglass_scene_desc desc = cpp::scene_desc();
  desc.granular.particle_radius = k_radius;
  desc.granular.particle_capacity = particles;
  desc.granular.emitter_capacity = 1;
  Simulation simulation(desc);
  cpp::Skin skin;
  if (const cpp::Status made = skin.create(cpp::skin_desc(desc.granular)); !made)
    throw cannot("make", "skin", made.reason);
  const sandglass_emitter nozzle = cpp::emitter(0.0f, 0.35f, 0.0f, 4 * k_radius, 0.8f);
  const sandglass_collider floor = cpp::floor_at(0.0f);
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = k_step;
  input.budget_ns = UINT64_MAX;
  input.colliders = &floor;
  input.collider_count = 1;
  input.emitters = &nozzle;
  input.emitter_count = 1;
  input.skin = skin.get();
  std::vector<uint32_t> versions;
  std::vector<double> bytes;
  sandglass_skin_mesh mesh = {};
  uint32_t version = 0;
  const auto frame = [&] {
    const sandglass_frame_report report = simulation.frame(input);
    mesh = skin.mesh();
    versions.resize(mesh.chunk_count);
    double sum = mesh.version != version ? 32.0 * (mesh.flying_count + mesh.lying_count) : 0.0;
    version = mesh.version;
    for (uint32_t i = 0; i < mesh.chunk_count; ++i) {
      const sandglass_skin_chunk& chunk = mesh.chunks[i];
      if (versions[i] != chunk.version) sum += 24.0 * chunk.vertex_count + 2.0 * chunk.index_count;
      versions[i] = chunk.version;
    }
    bytes.push_back(sum);
    return report;
  };
  const auto tell = [&](const char* what, double value, const char* unit) {
    rows.push_back({"handed over", std::to_string(particles) + " particles, " + what, unit, 0.0, value,
                    std::numeric_limits<double>::infinity(), true, false});
  };
  while (frame().sand.particle_numbers < particles) {
  }
  double sum = 0.0;
  for (size_t i = bytes.size() - std::min<size_t>(k_last_frames, bytes.size()); i < bytes.size(); ++i) sum += bytes[i];
  tell("bytes a frame, poured", sum / k_last_frames, "bytes");
  tell("loose particles, poured", mesh.flying_count + mesh.lying_count, "");
  input.emitter_count = 0;
  for (int i = 0; i < 1500 && frame().sand.awake != 0; ++i) {
  }
  frame();
  frame();
  uint32_t drawn = 0;
  for (uint32_t i = 0; i < mesh.chunk_count; ++i) drawn += mesh.chunks[i].index_count != 0 ? 1 : 0;
  tell("bytes a frame, asleep", bytes.back(), "bytes");
  tell("draw calls", drawn + (mesh.lying_count != 0 ? 1 : 0), "");
  tell("vertices", mesh.vertex_count, "");
  tell("triangles", mesh.index_count / 3, "");
  return rows;
}

}  // namespace sandglass::host

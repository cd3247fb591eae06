// A saved scene with a right checksum and wrong content: it is refused, or it runs, and then the scalar kernels and
// others agree to the bit, nothing leaves the world, and what is saved again is restored.
#include <cstring>
#include <map>

#include "runtime/core/hash.h"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/granular/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.003f;  // short: the fuzzer runs thousands
constexpr size_t k_header_bytes = 64, k_bytes_at = 8, k_checksum_at = 16;

sandglass_scene_desc describe_world(sandglass_isa isa) {
  sandglass_scene_desc desc = description(64, 128, 16);
  desc.granular.body_capacity = 2;
  desc.granular.body_particle_capacity = 20;
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
  desc.isa = isa;
  return desc;
}

sandglass_frame_report run_frame(GranularScene* scene) {
  const sandglass_collider floor = sandglass::floor_at(0.0f), sink = sandglass::floor_at(-0.5f);
  const sandglass_emitter emitter = sandglass::emitter(-0.2f, 0.4f, 0.0f, 0.012f, 0.8f, 4);
  sandglass_frame_input input = scene->input(k_frame);
  input.grains = nullptr;
  input.grain_capacity = 0;
  input.colliders = &floor;
  input.collider_count = 1;
  input.emitters = &emitter;
  input.emitter_count = 1;
  input.sinks = &sink;
  input.sink_count = 1;
  return scene->run(input);
}

std::vector<uint8_t> saved(GranularScene* scene) {
  std::vector<std::byte> bytes;
  accept(scene->scene.save(&bytes));
  std::vector<uint8_t> data(bytes.size());
  std::memcpy(data.data(), bytes.data(), bytes.size());
  return data;
}

// Sand, grains, a body, a boundary and an emitter, after some frames.
std::vector<uint8_t> base_file() {
  GranularScene scene(describe_world(SANDGLASS_ISA_SCALAR));
  const std::vector<float> block = lattice(2, 2, 2, 2.02f * k_radius, k_radius);
  std::vector<float> grains, body = lattice(2, 2, 1, 2.01f * k_radius, k_radius);
  for (size_t i = 0; i < block.size(); ++i)
    for (const float offset : {-0.004f, 0.004f}) grains.push_back(block[i] + offset);
  for (size_t i = 0; i < body.size(); i += 3) body[i + 1] += 0.1f;
  scene.add(block, {}, grains);
  scene.add_body(body, 2.0f);
  const std::vector<float> wall = {-0.1f, k_radius, 0.0f, -0.1f, k_radius, 0.03f};
  accept(scene.scene.set_boundary(wall));
  for (int i = 0; i < 4; ++i) run_frame(&scene);
  return saved(&scene);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  static const std::vector<uint8_t> base = base_file();
  static GranularScene scalar(describe_world(SANDGLASS_ISA_SCALAR));
  static std::map<sandglass_isa, GranularScene> scenes;
  const sandglass_isa isa = fuzz::other_kernels(data, size);
  GranularScene& other = scenes.try_emplace(isa, describe_world(isa)).first->second;
  std::vector<uint8_t> file = base;
  fuzz::apply_edits(data, size, &file);
  // Now and then its head is wrong as well.
  if (size % 8 != 7 && file.size() >= k_header_bytes) {
    std::memcpy(file.data(), base.data(), k_bytes_at);  // kind and version
    fuzz::put(&file, k_bytes_at, static_cast<uint64_t>(file.size()));
    fuzz::put(&file, k_checksum_at, hash_bytes(file.data() + k_header_bytes, file.size() - k_header_bytes));
  }
  const bool taken = static_cast<bool>(scalar.scene.restore(file.data(), file.size()));
  fuzz::expect(static_cast<bool>(other.scene.restore(file.data(), file.size())) == taken);
  fuzz::expect(taken || size >= fuzz::k_edit_bytes);
  if (!taken) return 0;
  for (int i = 0; i < 2; ++i) {
    const sandglass_frame_report a = run_frame(&scalar), b = run_frame(&other);
    fuzz::expect(a.sand.particles == b.sand.particles && a.sand.awake == b.sand.awake);
    fuzz::expect(scalar.hash() == other.hash());
    scalar.particle_count = a.sand.particle_numbers;
    for (const float x : scalar.positions()) fuzz::expect(std::fabs(x) <= 4000.0f || x == SANDGLASS_REMOVED_Y);
  }
  std::vector<std::byte> again;
  accept(scalar.scene.save(&again));
  fuzz::expect(static_cast<bool>(other.scene.restore(again)) && other.hash() == scalar.hash());
  return 0;
}

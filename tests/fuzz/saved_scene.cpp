// A saved scene with a right checksum and wrong content: it is refused, or it runs, and then the scalar kernels and
// others agree to the bit, nothing leaves the world, and what is saved again is restored.
#include <cstring>
#include <map>

#include "runtime/math/hash.h"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_frame = 0.003f;  // short: the fuzzer runs thousands
constexpr size_t k_header_bytes = 64, k_bytes_at = 8, k_checksum_at = 16;

struct World : GranularScene {
  explicit World(sandglass_isa isa)
      : GranularScene([&] {
          sandglass_scene_desc desc = description(64, 128, 16);
          desc.granular.body_capacity = 2;
          desc.granular.body_particle_capacity = 20;
          desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
          desc.isa = isa;
          return desc;
        }()) {
    add_floor();
    sinks = {sandglass::floor_at(-0.5f)};
    emitters = {sandglass::emitter(-0.2f, 0.4f, 0.0f, 0.012f, 0.8f, 4)};
    draws = false;
  }
};

std::vector<uint8_t> saved(GranularScene* scene) {
  std::vector<std::byte> bytes;
  accept(scene->scene.save(&bytes));
  std::vector<uint8_t> data(bytes.size());
  std::memcpy(data.data(), bytes.data(), bytes.size());
  return data;
}

// Sand, grains, a body, a boundary and an emitter, after some frames.
std::vector<uint8_t> base_file() {
  World scene(SANDGLASS_ISA_SCALAR);
  const std::vector<float> block = lattice(2, 2, 2, 2.02f * k_radius, k_radius);
  std::vector<float> grains;
  for (size_t i = 0; i < block.size(); ++i)
    for (const float offset : {-0.004f, 0.004f}) grains.push_back(block[i] + offset);
  scene.add(block, {}, grains);
  scene.add_body(shifted(lattice(2, 2, 1, 2.01f * k_radius, k_radius), 0.0f, 0.1f, 0.0f), 2.0f);
  const std::vector<float> wall = {-0.1f, k_radius, 0.0f, -0.1f, k_radius, 0.03f};
  accept(scene.scene.set_boundary(wall));
  for (int i = 0; i < 4; ++i) scene.frame(k_frame);
  return saved(&scene);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  static const std::vector<uint8_t> base = base_file();
  static World scalar(SANDGLASS_ISA_SCALAR);
  static std::map<sandglass_isa, World> scenes;
  const sandglass_isa isa = fuzz::other_kernels(data, size);
  World& other = scenes.try_emplace(isa, isa).first->second;
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
    const sandglass_frame_report a = scalar.frame(k_frame), b = other.frame(k_frame);
    fuzz::expect(a.sand.particles == b.sand.particles && a.sand.awake == b.sand.awake);
    fuzz::expect(scalar.hash() == other.hash());
    for (const float x : scalar.positions()) fuzz::expect(std::fabs(x) <= 4000.0f || x == SANDGLASS_REMOVED_Y);
  }
  std::vector<std::byte> again;
  accept(scalar.scene.save(&again));
  fuzz::expect(static_cast<bool>(other.scene.restore(again)) && other.hash() == scalar.hash());
  return 0;
}

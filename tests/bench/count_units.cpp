// What each work unit of a scene costs on ARM: a pile that collapses, with its shadow, an object's shadow, the lighting
// network and the room, all work in every frame. Prints one line for each unit that ran, in order: its items and its name;
// "0 frame" for what a frame costs outside of units. count_plugin writes the instructions of each line into its laps.
//   count_units SHADOW_FILE LIGHT_FILE
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "runtime/scene/scene.h"
#include "sandglass/estimate.h"
#include "sandglass/room.h"
#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

namespace {

constexpr int k_settling_frames = 4, k_counted_frames = 24;
constexpr uint32_t k_width = 640, k_height = 480;

struct Lap {
  const char* name;
  uint32_t items;
};

struct Asset {
  std::vector<uint64_t> words = std::vector<uint64_t>(1u << 20);  // aligned to 8 bytes
  size_t bytes = 0;
  explicit Asset(const char* path) {
    std::FILE* file = std::fopen(path, "rb");
    if (file == nullptr) return;
    bytes = std::fread(words.data(), 1, words.size() * sizeof(uint64_t), file);
    std::fclose(file);
  }
};

void fill(std::vector<float>* particles, std::vector<float>* grains) {
  const float r = 0.01f, edge = 0.0068f;
  const sandglass::Box box{{-0.10f, r, -0.10f}, {0.10f, 0.21f, 0.10f}};
  const sandglass::Status made = sandglass::sample_lattice(
      box, 2.02f * r, [](const float*) { return true; }, particles);
  if (!made) std::fprintf(stderr, "%s\n", made.reason);
  CountingRandom random;
  for (float y = r; y < 0.21f; y += edge)
    for (float z = -0.1f; z < 0.1f; z += edge)
      for (float x = -0.1f; x < 0.1f; x += edge)
        for (const float at : {x, y, z}) grains->push_back(at + 0.5f * edge * random());
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count < 3) return std::fprintf(stderr, "count_units SHADOW_FILE LIGHT_FILE\n"), 2;
  const Asset of_shadow(arguments[1]), of_light(arguments[2]);
  std::vector<float> particles, grains;
  fill(&particles, &grains);
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_radius = 0.01f;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  desc.granular.collider_capacity = 2;
  sandglass::Scene scene;
  sandglass_pile_shadow_desc pile_desc = sandglass::pile_shadow_desc();
  pile_desc.sky_texels = 64;
  sandglass::PileShadow pile;
  sandglass_shadow_desc shadow_desc = sandglass::shadow_desc();
  shadow_desc.asset = of_shadow.words.data();
  shadow_desc.asset_bytes = of_shadow.bytes;
  sandglass::Shadow shadow;
  sandglass_estimator_desc light_desc;
  sandglass_estimator_desc_default(&light_desc);
  light_desc.asset = of_light.words.data();
  light_desc.asset_bytes = of_light.bytes;
  sandglass::Estimator light;
  sandglass::cpp::Room room;
  if (!scene.create(desc) || !scene.add(particles, grains) || !pile.create(pile_desc) || !shadow.create(shadow_desc) ||
      !light.create(light_desc) || !room.create())
    return std::fprintf(stderr, "count_units: cannot create the scene\n"), 2;

  std::vector<uint8_t> bytes(size_t{k_width} * k_height * 3 / 2, 120);
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  image.format = SANDGLASS_CAMERA_NV12;
  image.width = k_width;
  image.height = k_height;
  image.planes[0] = bytes.data();
  image.planes[1] = bytes.data() + size_t{k_width} * k_height;
  image.strides[0] = image.strides[1] = k_width;
  image.focal_x = image.focal_y = 520.0f;
  image.centre_x = 319.5f;
  image.centre_y = 239.5f;

  sandglass_collider colliders[2] = {sandglass::floor_at(0.0f), sandglass::floor_at(0.0f)};
  colliders[1].shape = SANDGLASS_SHAPE_BOX;
  colliders[1].position[0] = 0.2f;
  for (float& side : colliders[1].size) side = 0.08f;
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);
  sandglass_shadow* shadows[] = {shadow.get()};
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60;
  input.budget_ns = ~0ull;
  input.colliders = colliders;
  input.collider_count = 2;
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;
  input.shadows = shadows;
  input.shadow_count = 1;
  input.pile_shadow = pile.get();
  input.estimator = light.get();
  input.room = room.get();
  input.camera = &image;

  std::vector<Lap> laps;
  laps.reserve(1u << 18);
  scene.get()->governor.observer = {[](void* user, const sandglass::WorkUnit& unit) {
                                      static_cast<std::vector<Lap>*>(user)->push_back({unit.name, unit.items});
                                      counting_laps();
                                    },
                                    &laps};
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; frame < k_settling_frames + k_counted_frames; ++frame) {
    const float turn = 0.02f * static_cast<float>(frame);
    image.timestamp_ns = 1 + 200'000'000ull * static_cast<uint64_t>(frame);
    if (!pile.set_light({0.5f + turn, 0.7f, 0.2f}) || !shadow.set_light({0.3f + turn, 1.0f, 0.2f})) return 2;
    laps.push_back({"app", 0});
    counting_laps();
    if (!scene.frame(input, &report)) return 2;
    laps.push_back({"frame", 0});
    counting_laps();
  }
  for (const Lap& lap : laps) std::printf("%u %s\n", lap.items, lap.name);
  return 0;
}

// What each work unit of a scene costs on ARM: a pile that collapses, with its shadow, an object's shadow, the lighting
// network and the room, all work in every frame; and a bucket of sand that is carried without time for it, and a ball that goes
// through it. Prints one line for each unit that ran, in order: its items and its name; "0 frame" for what a frame costs
// outside of units. count_plugin writes the instructions of each line into its laps.
//   count_units SHADOW_FILE LIGHT_FILE
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "runtime/scene/scene.h"
#include "runtime/skin/skin.h"
#include "sandglass/estimator.h"
#include "sandglass/room.h"
#include "tests/bench/counted_sand.h"
#include "tests/camera_picture.h"

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

// A waved sheet of 1,800 triangles.
struct Grid {
  static constexpr uint32_t k_side = 31;
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  sandglass_cast_mesh mesh = sandglass::cast_mesh();
  Grid() {
    for (uint32_t i = 0; i < k_side * k_side; ++i) {
      const float x = static_cast<float>(i % k_side) / 30 - 0.5f, z = static_cast<float>(i / k_side) / 30 - 0.5f;
      positions.insert(positions.end(), {0.4f * x, 0.2f + x * z, 0.4f * z});
      if (i % k_side + 1 == k_side || i / k_side + 1 == k_side) continue;
      indices.insert(indices.end(), {i, i + k_side, i + 1, i + 1, i + k_side, i + k_side + 1});
    }
    mesh.positions = positions.data();
    mesh.vertex_count = k_side * k_side;
    mesh.indices = indices.data();
    mesh.triangle_count = static_cast<uint32_t>(indices.size() / 3);
  }
};

// A bucket of five boxes that goes up and aside, then a ball that goes through its sand, with a budget that is over at once.
bool count_carry(std::vector<Lap>* laps) {
  constexpr float k_radius = 0.006f, k_wide = 0.06f, k_wall = 0.006f, k_high = 0.07f;
  const float sides[5][6] = {{0, 0, 0, k_wide, k_wall, k_wide},
                             {k_wide, k_high, 0, k_wall, k_high, k_wide},
                             {-k_wide, k_high, 0, k_wall, k_high, k_wide},
                             {0, k_high, k_wide, k_wide, k_high, k_wall},
                             {0, k_high, -k_wide, k_wide, k_high, k_wall}};
  std::vector<float> particles, grains;
  const float in = k_wide - k_wall - k_radius;
  const auto everywhere = [](const float*) { return true; };
  const sandglass::Box inside{{-in, 0.012f, -in}, {in, 0.1f, in}};
  sandglass_scene_desc desc = sandglass::scene_desc();
  sandglass::Scene scene;
  desc.granular.particle_radius = k_radius;
  desc.granular.particle_capacity = 2000;
  desc.clock = {[](void*) {
                  static uint64_t now;
                  return now += 1'000'000;
                },
                nullptr};
  desc.granular.grain_capacity = 20000;
  if (!sandglass::sample_lattice(inside, 2.02f * k_radius, everywhere, &particles) ||
      !sandglass::sample_lattice(inside, k_radius, everywhere, &grains) || !scene.create(desc) ||
      !scene.add(particles, grains))
    return false;
  scene.get()->governor.observer = {
      [](void* user, const sandglass::WorkUnit& unit) {
        const bool carries = std::strstr(unit.name, ".carry") != nullptr || std::strstr(unit.name, ".push") != nullptr;
        static_cast<std::vector<Lap>*>(user)->push_back({carries ? unit.name : "app", unit.items});
        counting_laps();
      },
      laps};
  sandglass_collider colliders[5];
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60;
  input.colliders = colliders;
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;
  for (int frame = 0; frame < k_settling_frames + 2 * k_counted_frames; ++frame) {
    const int moved = std::max(frame - k_settling_frames, 0);
    const float path = 0.005f * static_cast<float>(std::min(moved, k_counted_frames)), speed = moved != 0 ? 0.3f : 0.0f;
    const float through = 0.005f * static_cast<float>(moved) - path;
    for (int i = 0; i < 5; ++i) {
      const float* s = sides[i];
      colliders[i] = sandglass::box(s[0] + path, s[1] + path, s[2], s[3], s[4], s[5]);
      colliders[i].linear_velocity[0] = colliders[i].linear_velocity[1] = speed;
    }
    if (moved > k_counted_frames) {
      colliders[0] = sandglass::floor_at(path);
      colliders[1] = sandglass::sphere(path + through - 0.06f, path + 0.04f, 0.0f, 0.03f);
      colliders[1].linear_velocity[0] = speed;
    }
    input.collider_count = moved > k_counted_frames ? 2 : 5;
    input.budget_ns = frame < k_settling_frames ? ~0ull : 1;
    if (!scene.frame(input)) return false;
  }
  return true;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count < 3) return wrong("count_units SHADOW_FILE LIGHT_FILE");
  const Asset of_shadow(arguments[1]), of_light(arguments[2]);
  CountedSand sand;
  sandglass_pile_shadow_desc pile_desc = sandglass::pile_shadow_desc();
  pile_desc.sky_texels = 64;
  sandglass::PileShadow pile;
  sandglass::Skin skin;
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
  sandglass_room_desc room_desc = sandglass::cpp::room_desc();
  room_desc.reflections = 1;
  if (!sand.status || !pile.create(pile_desc) || !skin.create(sandglass::skin_desc(sand.scene.get()->desc.granular)) ||
      !shadow.create(shadow_desc) || !light.create(light_desc) || !room.create(room_desc))
    return wrong("count_units: cannot create the scene");

  std::vector<uint8_t> bytes(size_t{k_width} * k_height * 3 / 2, 120);
  sandglass_camera_image image =
      sandglass::tests::camera_picture(bytes.data(), k_width, k_height, 520.0f, SANDGLASS_CAMERA_NV12);

  const Grid leaf;
  sandglass::Cast cast;
  if (!cast.create(sandglass::cast_desc()) || !cast.set_meshes(&leaf.mesh, 1)) return 2;

  sandglass_cast* casts[] = {cast.get()};
  sandglass_shadow* shadows[] = {shadow.get()};
  sandglass_frame_input& input = sand.input;
  input.time_step = 1.0f / 60;
  input.shadows = shadows;
  input.shadow_count = 1;
  input.casts = casts;
  input.cast_count = 1;
  input.estimator = light.get();
  input.room = room.get();
  input.camera = &image;

  struct {
    std::vector<Lap> laps;
    sandglass_skin* skin;
  } counted = {{}, skin.get()};
  std::vector<Lap>& laps = counted.laps;
  laps.reserve(1u << 18);
  sand.scene.get()->governor.observer = {[](void* user, const sandglass::WorkUnit& unit) {
                                           auto* to = static_cast<decltype(counted)*>(user);
                                           to->laps.push_back({unit.name, unit.items});
                                           // As if skins were late: the one before is carried along.
                                           if (std::strcmp(unit.name, "skin.loose") == 0)
                                             to->skin->skin.shown.frame = 0;
                                           counting_laps();
                                         },
                                         &counted};
  for (int frame = 0; frame < k_settling_frames + k_counted_frames; ++frame) {
    const float turn = 0.02f * static_cast<float>(frame);
    image.timestamp_ns = 1 + 200'000'000ull * static_cast<uint64_t>(frame);
    if (!pile.set_light({0.5f + turn, 0.7f, 0.2f}) || !shadow.set_light({0.3f + turn, 1.0f, 0.2f}) ||
        !cast.set_light({0.3f + turn, 1.0f, 0.2f}))
      return 2;
    // By turns: over a skin the sand's shadow is cheaper than over spheres.
    input.skin = frame % 2 == 0 ? nullptr : skin.get();
    input.pile_shadow = frame % 2 == 0 ? pile.get() : nullptr;
    laps.push_back({"app", 0});
    counting_laps();
    if (!sand.scene.frame(input, &sand.report)) return 2;
    laps.push_back({"frame", 0});
    counting_laps();
  }
  if (!count_carry(&laps)) return 2;
  for (const Lap& lap : laps) std::printf("%u %s\n", lap.items, lap.name);
  return 0;
}

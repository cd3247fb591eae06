// Sand whose skin is late: it is seen from the first frame on, and goes with what holds it.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>

#include "runtime/skin/skin.h"
#include "tests/skin/skin_scene.h"

namespace {

// A clock on which the skin's own units are dear and all others cheap: sand has all the time that it needs, and a skin takes
// many frames. The carry is no unit of a skin.
struct Starving {
  uint64_t now = 0, skin_unit_ns = 0;
  void use(sandglass_scene_desc* desc) {
    desc->clock = {[](void* user) { return static_cast<Starving*>(user)->now += 1000; }, this};
    desc->trace.user = this;
    desc->trace.begin = [](void*, const char*) {};
    desc->trace.end = [](void* user, const char* name) {
      auto* self = static_cast<Starving*>(user);
      if (std::strncmp(name, "skin.", 5) == 0 && std::strcmp(name, "skin.carry") != 0) self->now += self->skin_unit_ns;
    };
  }
};

constexpr float k_small = 0.004f, k_wide = 0.05f, k_high = 0.1f;
constexpr uint64_t k_budget = 8'000'000;

// A closed glass: a cylinder that is solid outside.
float free_in_glass(const float* p) { return std::min(k_wide - std::hypot(p[0], p[2]), k_high - std::fabs(p[1])); }

struct Glass {
  explicit Glass(uint64_t skin_unit_ns, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC) {
    const sandglass::Box box = {{-0.07f, -0.12f, -0.07f}, {0.07f, 0.12f, 0.07f}};
    accept(field.from_function(box, k_small, SANDGLASS_SOLID_OUTSIDE, free_in_glass));
    sandglass_scene_desc desc = rough(1300);
    desc.isa = isa;
    desc.granular.particle_radius = k_small;
    clock.skin_unit_ns = skin_unit_ns;
    clock.use(&desc);
    sand = std::make_unique<Sand>(desc, 1);
    for (float y = -k_high + 1.1f * k_small; places.size() < 3600; y += 2.1f * k_small)
      for (float z = -k_wide; z < k_wide; z += 2.1f * k_small)
        for (float x = -k_wide; x < k_wide; x += 2.1f * k_small) {
          const float p[3] = {x, y, z};
          if (free_in_glass(p) > 1.05f * k_small && places.size() < 3600) places.insert(places.end(), p, p + 3);
        }
    sand->scene.add(places);
    sand->scene.colliders.push_back(sandglass::field_at(field, 0, 0, 0));
    sand->scene.colliders[0].id = 1;
  }
  // To an angle about z and a height, with velocities by differences.
  sandglass_frame_report frame(const std::array<float, 2>& to, const sandglass_plan* plan = nullptr) {
    sandglass_collider& glass = sand->scene.colliders[0];
    glass.linear_velocity[1] = (to[1] - glass.position[1]) * 60;
    glass.angular_velocity[2] = (to[0] - turned) * 60;
    glass.position[1] = to[1];
    glass.rotation[2] = std::sin(to[0] / 2);
    glass.rotation[3] = std::cos(to[0] / 2);
    turned = to[0];
    sandglass_frame_input input = sand->scene.input(1 / 60.0f, k_budget, plan);
    input.skin = sand->skin.get();
    return sand->scene.run(input);
  }
  bool is_beyond(const float* p, float limit) const {
    const float c = std::cos(turned), s = std::sin(turned), x = p[0], y = p[1] - sand->scene.colliders[0].position[1];
    const float local[3] = {c * x + s * y, c * y - s * x, p[2]};
    return free_in_glass(local) < -limit;
  }
  uint32_t beyond(const sandglass_skin_chunk* chunks, uint32_t count) const {
    uint32_t sum = 0;
    for (uint32_t c = 0; c < count; ++c)
      for (uint32_t v = 0; v < chunks[c].vertex_count; ++v)
        sum += is_beyond(chunks[c].vertices[v].position, 2 * k_small) ? 1 : 0;
    return sum;
  }

  sandglass::Field field;
  Starving clock;
  std::unique_ptr<Sand> sand;
  std::vector<float> places;
  float turned = 0;
};

using Motion = std::array<float, 2> (*)(float);
std::array<float, 2> rests(float) { return {0, 0}; }
std::array<float, 2> turns(float t) {
  const float s = std::clamp(t / 1.2f, 0.0f, 1.0f);
  return {std::numbers::pi_v<float> * s * s * s * (10 + s * (6 * s - 15)), 0};
}
std::array<float, 2> shakes(float t) { return {0, 0.025f * (1 - std::cos(4 * std::numbers::pi_v<float> * t))}; }

// Half a turn while sand falls inside, and shaken: no vertex is beyond the glass as it is drawn, however late the mesh is.
// Control: the mesh as it was made is.
TEST(SkinCarry, NoVertexIsBeyondTheGlass) {
  for (const uint64_t ns : {500'000u, 1'500'000u})
    for (const Motion motion : {turns, shakes}) {
      Glass glass(ns);
      uint32_t beyond = 0, as_made = 0, behind = 0;
      for (int i = 0; i < 90; ++i) {
        glass.frame(motion(static_cast<float>(i + 1) / 60));
        const sandglass_skin_mesh mesh = glass.sand->skin.mesh();
        beyond += glass.beyond(mesh.chunks, mesh.chunk_count);
        as_made += glass.beyond(glass.sand->skin.get()->skin.meshes.front.chunks, mesh.chunk_count);
        behind = std::max(behind, mesh.frames_behind);
        const std::vector<float> at = glass.sand->scene.positions();
        for (size_t p = 0; p < at.size(); p += 3) ASSERT_FALSE(glass.is_beyond(&at[p], k_small));
      }
      EXPECT_EQ(beyond, 0u) << ns;
      EXPECT_GT(as_made, 100u) << ns;
      EXPECT_GE(behind, 5u) << ns;
    }
}

// Sand is seen in every frame, as loose points until there is a mesh; and a glass that moves has its first mesh hardly later
// than one that stands: at half of what a skin needs, within 5 frames.
TEST(SkinCarry, SandIsSeenFromTheFirstFrame) {
  uint32_t units = 0;
  {
    Glass all(0);
    units = all.frame({0, 0}).stages[SANDGLASS_STAGE_SKIN].units;
  }
  for (const uint32_t part : {2u, 8u, 32u}) {
    int first[2];
    for (const bool moves : {false, true}) {
      Glass glass(part * k_budget / units);
      int i = 0;
      for (; i < 200; ++i) {
        const uint32_t particles = glass.frame((moves ? shakes : rests)(static_cast<float>(i + 1) / 60)).sand.particles;
        const sandglass_skin_mesh mesh = glass.sand->skin.mesh();
        ASSERT_EQ(mesh.valid, 1u);
        if (mesh.index_count != 0) break;
        ASSERT_EQ(mesh.flying_count + mesh.lying_count, particles);
      }
      first[moves ? 1 : 0] = i;
    }
    if (part == 2) {
      EXPECT_LE(first[0], 5);
    }
    EXPECT_LE(first[1], first[0] + 3) << part;
  }
}

// A mesh whose sand has fallen to the other end of a glass that was turned hangs there no more: all sand is loose. One whose
// glass is shaken a little stays.
TEST(SkinCarry, NoMeshHangsWhereItsSandHasLeft) {
  for (const Motion motion : {turns, shakes}) {
    Glass glass(2'000'000);
    while (glass.sand->skin.mesh().index_count == 0) glass.frame({0, 0});
    glass.clock.skin_unit_ns = 1'000'000'000;  // one unit in a frame
    uint32_t without = 0;
    for (int i = 0; i < 100; ++i) {
      const uint32_t particles = glass.frame(motion(static_cast<float>(i + 1) / 60)).sand.particles;
      const sandglass_skin_mesh mesh = glass.sand->skin.mesh();
      if (mesh.index_count != 0) continue;
      ++without;
      EXPECT_EQ(mesh.flying_count + mesh.lying_count, particles);
    }
    EXPECT_EQ(without > 5, motion == turns) << without;
  }
}

// Sand that comes after the mesh was gathered is loose at once, each particle once and where it is; also under the number
// of one that has left.
TEST(SkinCarry, NewSandIsLoose) {
  for (const bool reused : {false, true}) {
    Glass glass(2'000'000);
    while (glass.sand->skin.mesh().index_count == 0) glass.frame({0, 0});
    const float out[3] = {0, -k_high, 0};
    if (reused) accept(glass.sand->scene.scene.remove(sandglass::sphere(out[0], out[1], out[2], 0.03f)));
    std::vector<float> fresh;
    for (uint32_t i = 0; i < 5; ++i) fresh.insert(fresh.end(), {0.01f * static_cast<float>(i), 0.08f, 0});
    glass.sand->scene.add(fresh);
    const sandglass_skin_mesh before = glass.sand->skin.mesh();
    glass.frame({0, 0});
    const sandglass_skin_mesh mesh = glass.sand->skin.mesh();
    ASSERT_GT(mesh.frames_behind, 0u);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < mesh.flying_count + mesh.lying_count; ++i)
      seen += mesh.loose[i].position[1] > 0.07f && mesh.loose[i].weight == 1 ? 1 : 0;
    EXPECT_EQ(seen, 5u) << reused;
    EXPECT_NE(mesh.version, before.version);
  }
}

// A plan that was recorded while skins are late gives the same mesh in every frame, on another instruction set.
TEST(SkinCarry, PlansReplay) {
  Glass recorded(1'500'000), again(0, SANDGLASS_ISA_SCALAR);
  for (int i = 0; i < 60; ++i) {
    const std::array<float, 2> to = turns(static_cast<float>(i + 1) / 60);
    const sandglass_frame_report report = recorded.frame(to);
    again.frame(to, &report.plan);
    ASSERT_EQ(recorded.sand->skin.hash(), again.sand->skin.hash()) << i;
  }
}

// A field that is destroyed while a skin of it is under way is not read any more: its memory is gone.
TEST(SkinCarry, AFieldMayBeGoneMeanwhile) {
  Glass glass(4'000'000);
  for (int i = 0; i < 20; ++i) glass.frame({0, 0});
  auto other = std::make_unique<sandglass::Field>();
  const auto ball = [](const float* p) { return std::hypot(p[0], p[1], p[2]) - 0.02f; };
  accept(other->from_function({{-0.03f, -0.03f, -0.03f}, {0.03f, 0.03f, 0.03f}}, 0.004f, SANDGLASS_SOLID_INSIDE, ball));
  glass.sand->scene.colliders.push_back(sandglass::field_at(*other, 0, -0.05f, 0));
  for (int i = 0; i < 3; ++i) glass.frame({0, 0});
  glass.sand->scene.colliders.pop_back();
  other.reset();
  for (int i = 0; i < 20; ++i) glass.frame({0, 0});
  glass.clock.skin_unit_ns = 0;
  for (int i = 0; i < 20; ++i) glass.frame({0, 0});
  EXPECT_EQ(glass.sand->skin.mesh().frames_behind, 0u);
}

}  // namespace

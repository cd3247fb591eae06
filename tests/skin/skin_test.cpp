// The surface of the sand as a mesh: closed, turned outward, as large as the sand, on any floor and for any gravity;
// nothing at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/guarded_block.h"
#include "tests/skin/skin_mesh.h"

namespace {

TEST(Skin, IsClosedAndHoldsTheSand) {
  const struct {
    const char* what;
    uint32_t x, y, z;
    double within;
  } heaps[] = {{"a heap", 10, 16, 10, 0.06}, {"a layer of two", 24, 2, 24, 0.06}, {"little", 4, 5, 4, 0.1}};
  for (const auto& heap : heaps) {
    Sand sand(rough(heap.x * heap.y * heap.z));
    sand.lie(block(heap.x, heap.y, heap.z));
    sand.until_rested();
    const Mesh mesh = mesh_of(sand.skin);
    const double volume = sand_in(mesh);
    const double all = k_particle * heap.x * heap.y * heap.z;
    EXPECT_NEAR(volume / all, 1, heap.within) << heap.what;
    EXPECT_EQ(sand.skin.mesh().left_out, 0u);
    EXPECT_EQ(sand.skin.mesh().frames_behind, 0u);
    // No particle looks out of it by more than its radius: its top is below the highest vertex near it, or it is loose.
    const std::vector<float> at = sand.scene.positions();
    const sandglass_skin_mesh now = sand.skin.mesh();
    uint32_t outside = 0;
    for (size_t p = 0; p < at.size(); p += 3) {
      float top = -1;
      for (const sandglass_skin_vertex& v : mesh.vertices)
        if (std::hypot(v.position[0] - at[p], v.position[2] - at[p + 2]) < 2 * k_radius)
          top = std::max(top, v.position[1]);
      for (uint32_t i = 0; i < now.lying_count; ++i)
        if (now.loose[now.flying_count + i].number == p / 3) top = at[p + 1];
      outside += at[p + 1] > top ? 1 : 0;
    }
    EXPECT_LE(outside, at.size() / 3 / 50) << heap.what;
  }
}

// While sand is poured, too, mesh and loose sand together are as large as the sand.
TEST(Skin, HoldsTheSandWhileItIsPoured) {
  sandglass_scene_desc desc = rough(1600);
  desc.granular.emitter_capacity = 1;
  Sand sand(desc);
  sand.scene.add_floor();
  sand.scene.emitters = {sandglass::emitter(0, 0.5f, 0, 4 * k_radius, 0.8f)};
  sand.throw_shadow();
  for (int i = 0; i < 100; ++i) {
    const uint32_t particles = sand.frame(1 / 60.0f).sand.particles;
    if (i < 40 || i % 10 != 0) continue;
    const Mesh mesh = mesh_of(sand.skin);
    const double volume = sand_in(mesh);
    EXPECT_NEAR(volume / (k_particle * particles), 1, 0.06) << i;
    // The columns of the pile's shadow are those of one skin, though skins follow each other while they are made: no
    // holes.
    const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_HEIGHTS);
    const uint32_t n = sky.side;
    uint32_t holes = 0;
    for (uint32_t at = n + 1; at < n * n - n - 1; ++at) {
      const uint8_t* h = sky.bytes + at;
      holes += h[0] == 0 && std::min({h[-1], h[1], *(h - n), h[n]}) > 40 ? 1 : 0;
    }
    EXPECT_EQ(holes, 0u) << i;
  }
}

// Sand in a box, as behind glass: a closed mesh has no open edge anywhere, and reaches into floor and walls by 0.3
// nodes.
TEST(Skin, IsClosedBehindGlass) {
  for (const uint32_t closed : {0u, 1u}) {
    Sand sand(rough(1000), closed);
    sand.scene.add_floor();
    sand.scene.add_walls({-0.1f, -0.1f}, {0.1f, 0.1f});
    sand.scene.add(block(9, 10, 9));
    sand.until_rested();
    uint32_t faults = 0;
    const double all = volume_over(mesh_of(sand.skin), {0, 1, 0}, &faults, 1.0f);  // far over the plane: all of it
    EXPECT_EQ(faults == 0, closed == 1);
    const double deep = 0.3 * 1.5 * k_radius, side = 0.2 + 2 * deep, height = 810 * k_particle / (0.2 * 0.2) + deep;
    if (closed == 1) {
      EXPECT_NEAR(all / (side * side * height), 1, 0.12);  // edges are round by two nodes, 7 %
    }
  }
}

// Gravity along each axis, and a floor across it; and a floor that gravity leans on by 25 degrees.
TEST(Skin, FollowsGravityAndFloor) {
  double first = 0;
  for (const Point& up :
       {Point{0, 1, 0}, Point{0, -1, 0}, Point{1, 0, 0}, Point{0, 0, -1}, Point{0.4226f, 0.9063f, 0}}) {
    sandglass_scene_desc desc = rough(800);
    for (size_t k = 0; k < 3; ++k) desc.gravity[k] = -9.81f * up[k];
    Sand sand(desc);
    sandglass_collider floor = sandglass::floor_at(0);
    const float axis[3] = {up[2], 0, -up[0]}, other[3] = {1, 0, 0};
    const bool turned = std::hypot(up[0], up[2]) > 0.1f;
    ASSERT_EQ(sandglass_rotation_about(turned ? axis : other, std::acos(up[1]), floor.rotation), 1);
    sand.scene.colliders.push_back(floor);
    std::vector<float> points = block(10, 8, 10);
    for (size_t i = 0; i < points.size(); i += 3) {  // its y becomes up
      const Point side = turned ? Point{up[1], -up[0], 0} : Point{1, 0, 0},
                  along = turned && up[2] != 0 ? Point{1, 0, 0} : side;
      const Point third = {along[1] * up[2] - along[2] * up[1], along[2] * up[0] - along[0] * up[2],
                           along[0] * up[1] - along[1] * up[0]};
      const Point p = {points[i], points[i + 1], points[i + 2]};
      for (size_t k = 0; k < 3; ++k) points[i + k] = p[0] * along[k] + p[1] * up[k] + p[2] * third[k];
    }
    sand.scene.add(points);
    sand.until_rested();
    const Mesh mesh = mesh_of(sand.skin);
    const double volume = sand_in(mesh, up);
    EXPECT_NEAR(volume / (800 * k_particle), 1, 0.08) << up[0] << " " << up[1] << " " << up[2];
    if (first == 0) first = volume;
    EXPECT_NEAR(volume / first, 1, 0.05);
    for (const sandglass_skin_vertex& v : mesh.vertices) {
      // `over` is the height over the floor, to a quarter of a millimetre: the distances that it is made of are held in
      // 1/48 of a node, which is 15 mm.
      const double over = std::clamp(1e6 * dot(place(v), up), -32768.0, 32767.0);
      if (over < 25000) {
        EXPECT_NEAR(v.over, over, 350);
      }
      Point normal;
      for (size_t k = 0; k < 3; ++k) normal[k] = static_cast<float>(v.normal[k]) / 127;
      EXPECT_NEAR(std::sqrt(dot(normal, normal)), 1, 0.02);
    }
  }
}

// Triangles are counter-clockwise from outside: vertices' normals look as they do.
TEST(Skin, NormalsLookAsTrianglesDo) {
  Sand sand(rough(1000));
  sand.lie(block(10, 10, 10));
  for (int i = 0; i < 30; ++i) sand.frame();
  const Mesh mesh = mesh_of(sand.skin);
  uint32_t against = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const sandglass_skin_vertex* v[3];
    for (size_t k = 0; k < 3; ++k) v[k] = &mesh.vertices[mesh.triangles[t + k]];
    Point face, normal;
    for (size_t k = 0; k < 3; ++k) {
      const size_t a = (k + 1) % 3, b = (k + 2) % 3;
      face[k] = (v[1]->position[a] - v[0]->position[a]) * (v[2]->position[b] - v[0]->position[b]) -
                (v[1]->position[b] - v[0]->position[b]) * (v[2]->position[a] - v[0]->position[a]);
      normal[k] = static_cast<float>(v[0]->normal[k] + v[1]->normal[k] + v[2]->normal[k]);
    }
    against += dot(face, normal) < 0 ? 1 : 0;
  }
  EXPECT_LE(against, mesh.triangles.size() / 3 / 50);
}

TEST(Skin, AtRestNothingRunsAndNothingChanges) {
  Sand sand(rough(400));
  sand.lie(block(10, 4, 10));
  sand.until_rested();
  const uint32_t version = sand.skin.mesh().version;
  const uint64_t hash = sand.skin.hash();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(sand.frame().stages[SANDGLASS_STAGE_SKIN].units, 0u);
  EXPECT_EQ(sand.skin.mesh().version, version);
  EXPECT_EQ(sand.skin.hash(), hash);
  // A wall that comes far away changes nothing; one that comes into the sand makes it anew beside it.
  sand.scene.colliders.push_back(sandglass::sphere(3, 0.1f, 0, 0.1f));
  for (int i = 0; i < 3; ++i) sand.frame(0);
  EXPECT_EQ(sand.skin.hash(), hash);
}

TEST(Skin, HoldsForSandThatHardlyIsAny) {
  for (const uint32_t count : {0u, 1u, 64u}) {
    Sand sand(rough(64));
    sand.scene.add_floor();
    std::vector<float> points;
    for (uint32_t i = 0; i < count; ++i) points.insert(points.end(), {0.1f, k_radius, 0.1f});  // all in one place
    if (count != 0) sand.scene.add(points);
    for (int i = 0; i < 5; ++i) sand.frame(0);
    const sandglass_skin_mesh now = sand.skin.mesh();
    const Mesh mesh = mesh_of(sand.skin);
    EXPECT_EQ(now.valid, 1u);
    EXPECT_EQ(now.frames_behind, 0u);
    uint32_t faults = 0;
    EXPECT_TRUE(std::isfinite(volume_over(mesh, {0, 1, 0}, &faults)));
    EXPECT_EQ(faults, 0u);
    if (count == 0) {
      EXPECT_EQ(mesh.vertices.size() + now.lying_count + now.flying_count, 0u);
    }
    if (count == 1) {
      ASSERT_EQ(now.lying_count, 1u);
      EXPECT_EQ(now.loose[0].weight, 1.0f);
      EXPECT_GT(now.loose[0].vector[1], 0.5f);
    }
  }
}

// Thinly strewn sand has no room in the lattice: it is loose, and counted, and nothing is written beyond the block.
TEST(Skin, LeavesOutWhatHasNoRoom) {
  const sandglass_scene_desc desc = rough(400);
  const sandglass_skin_desc of = sandglass::skin_desc(desc.granular);
  uint64_t bytes = 0;
  ASSERT_EQ(sandglass_skin_bytes(&of, &bytes, nullptr), SANDGLASS_OK);
  sandglass::test::GuardedBlock memory(bytes);
  sandglass_skin* skin = nullptr;
  ASSERT_EQ(sandglass_skin_create(&of, memory.data(), bytes, &skin, nullptr), SANDGLASS_OK);
  GranularScene scene(desc);
  scene.add_floor();
  std::vector<float> points;
  for (int i = 0; i < 400; ++i)
    points.insert(points.end(),
                  {0.3f * static_cast<float>(i % 20), k_radius, 0.3f * static_cast<float>(i - i % 20) / 20});
  scene.add(points);
  sandglass_frame_input input = scene.input(0.02f);
  input.skin = skin;
  for (int i = 0; i < 5; ++i) scene.run(input);
  sandglass_skin_mesh mesh = {};
  mesh.struct_size = sizeof mesh;
  sandglass_skin_get_mesh(skin, &mesh);
  EXPECT_GT(mesh.left_out, 0u);
  EXPECT_EQ(mesh.lying_count, 400u);
  EXPECT_TRUE(memory.guards_intact());
}

}  // namespace

// The surface of the sand as a mesh: closed, turned outward, as large as the sand, where the sand is, on any floor and for
// any gravity; the same on every instruction set; nothing at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <vector>

#include "runtime/math/random.h"
#include "runtime/skin/skin.h"
#include "tests/guarded_block.h"
#include "tests/skin/skin_scene.h"

namespace {

using Point = std::array<float, 3>;
// What a particle takes in a pile: its volume over a packing of 0.6 (Scott 1960: 0.60 loose, 0.64 close).
constexpr double k_particle = 4.0 / 3 * std::numbers::pi * k_radius * k_radius * k_radius / 0.6;

struct Mesh {
  std::vector<sandglass_skin_vertex> vertices;
  std::vector<uint32_t> triangles;  // three vertices each
  double loose = 0;                 // particles
};

Mesh mesh_of(const sandglass::Skin& skin) {
  const sandglass_skin_mesh now = skin.mesh();
  Mesh mesh;
  for (uint32_t c = 0; c < now.chunk_count; ++c) {
    const sandglass_skin_chunk& chunk = now.chunks[c];
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), chunk.vertices, chunk.vertices + chunk.vertex_count);
    for (uint32_t i = 0; i < chunk.index_count; ++i) {
      EXPECT_LT(chunk.indices[i], chunk.vertex_count);
      mesh.triangles.push_back(first + chunk.indices[i]);
    }
  }
  EXPECT_EQ(mesh.vertices.size(), now.vertex_count);
  EXPECT_EQ(mesh.triangles.size(), now.index_count);
  for (uint32_t i = 0; i < now.flying_count + now.lying_count; ++i)
    mesh.loose += static_cast<double>(now.loose[i].weight);
  return mesh;
}

double dot(const Point& a, const Point& b) {
  double sum = 0;
  for (size_t k = 0; k < 3; ++k) sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  return sum;
}

Point place(const sandglass_skin_vertex& v) { return {v.position[0], v.position[1], v.position[2]}; }

// What of the mesh lies over the plane through the origin, after it was lifted: the sum of the prisms between triangles and plane. `faults`: edges
// over it that have not two triangles turned one way.
double volume_over(const Mesh& mesh, const Point& up, uint32_t* faults, float lifted = 0) {
  std::map<std::pair<Point, Point>, int> edges;
  double volume = 0;
  *faults = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Point p[3];
    for (size_t k = 0; k < 3; ++k) {
      p[k] = place(mesh.vertices[mesh.triangles[t + k]]);
      for (size_t m = 0; m < 3; ++m) p[k][m] += lifted * up[m];
    }
    const auto cross = [&](size_t k) {
      const size_t a = (k + 1) % 3, b = (k + 2) % 3;
      return static_cast<double>(p[1][a] - p[0][a]) * static_cast<double>(p[2][b] - p[0][b]) -
             static_cast<double>(p[1][b] - p[0][b]) * static_cast<double>(p[2][a] - p[0][a]);
    };
    double facing = 0, height = 0;
    for (size_t k = 0; k < 3; ++k) {
      facing += 0.5 * cross(k) * static_cast<double>(up[k]);
      height += std::max(dot(p[k], up), 0.0) / 3;
      const Point &a = p[k], &b = p[(k + 1) % 3];
      if (std::max(dot(a, up), dot(b, up)) > 0) edges[std::minmax(a, b)] += a < b ? 1 : -1;
    }
    volume += facing * height;
  }
  for (const auto& [edge, sum] : edges) *faults += sum != 0 ? 1 : 0;
  return volume;
}

TEST(Skin, IsClosedAndHoldsTheSand) {
  const struct {
    const char* what;
    uint32_t x, y, z;
    double within;
  } heaps[] = {{"a heap", 10, 16, 10, 0.06}, {"a layer of two", 24, 2, 24, 0.06}, {"little", 4, 5, 4, 0.1}};
  for (const auto& heap : heaps) {
    Sand sand(rough(heap.x * heap.y * heap.z));
    sand.scene.add_floor();
    sand.scene.add(lattice(heap.x, heap.y, heap.z, 2.05f * k_radius, k_radius));
    sand.until_rested();
    const Mesh mesh = mesh_of(sand.skin);
    uint32_t faults = 0;
    const double volume = volume_over(mesh, {0, 1, 0}, &faults) + mesh.loose * k_particle;
    const double all = k_particle * heap.x * heap.y * heap.z;
    EXPECT_EQ(faults, 0u) << heap.what;
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
    uint32_t faults = 0;
    const double volume = volume_over(mesh, {0, 1, 0}, &faults) + mesh.loose * k_particle;
    EXPECT_EQ(faults, 0u);
    EXPECT_NEAR(volume / (k_particle * particles), 1, 0.06) << i;
    // The columns of the pile's shadow are those of one skin, though skins follow each other while they are made: no holes.
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

// Sand in a box, as behind glass: a closed mesh has no open edge anywhere, and reaches into floor and walls by 0.3 nodes.
TEST(Skin, IsClosedBehindGlass) {
  for (const uint32_t closed : {0u, 1u}) {
    Sand sand(rough(1000), closed);
    sand.scene.add_floor();
    sand.scene.add_walls({-0.1f, -0.1f}, {0.1f, 0.1f});
    sand.scene.add(lattice(9, 10, 9, 2.05f * k_radius, k_radius));
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
    std::vector<float> block = lattice(10, 8, 10, 2.05f * k_radius, k_radius);
    for (size_t i = 0; i < block.size(); i += 3) {  // its y becomes up
      const Point side = turned ? Point{up[1], -up[0], 0} : Point{1, 0, 0},
                  along = turned && up[2] != 0 ? Point{1, 0, 0} : side;
      const Point third = {along[1] * up[2] - along[2] * up[1], along[2] * up[0] - along[0] * up[2],
                           along[0] * up[1] - along[1] * up[0]};
      const Point p = {block[i], block[i + 1], block[i + 2]};
      for (size_t k = 0; k < 3; ++k) block[i + k] = p[0] * along[k] + p[1] * up[k] + p[2] * third[k];
    }
    sand.scene.add(block);
    sand.until_rested();
    const Mesh mesh = mesh_of(sand.skin);
    uint32_t faults = 0;
    const double volume = volume_over(mesh, up, &faults) + mesh.loose * k_particle;
    EXPECT_EQ(faults, 0u) << up[0] << " " << up[1] << " " << up[2];
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
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 10, 10, 2.05f * k_radius, k_radius));
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
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 4, 10, 2.05f * k_radius, k_radius));
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

// What is made bit by bit while sand moves is what is made of it at once, but for what a particle may move before it counts.
TEST(Skin, MadeBitByBitIsMadeAtOnce) {
  Sand sand(rough(1000));
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 10, 10, 2.05f * k_radius, k_radius));
  // How far all but one in fifty vertices of one are from those of the other at most.
  const auto apart = [](const Mesh& from, const Mesh& to) {
    std::vector<double> distances;
    for (const sandglass_skin_vertex& v : from.vertices) {
      double least = 1e9;
      for (const sandglass_skin_vertex& w : to.vertices) {
        const Point d = {v.position[0] - w.position[0], v.position[1] - w.position[1], v.position[2] - w.position[2]};
        least = std::min(least, dot(d, d));
      }
      distances.push_back(std::sqrt(least));
    }
    std::sort(distances.begin(), distances.end());
    return distances[distances.size() * 49 / 50];
  };
  Mesh before;
  for (int i = 0; i < 60; ++i) {
    sand.frame();
    if (i % 20 == 10) before = mesh_of(sand.skin);
    if (i % 20 != 19) continue;
    sandglass::Skin fresh;
    accept(fresh.create(sandglass::skin_desc(rough(1000).granular)));
    sandglass_frame_input input = sand.scene.input(0);
    input.skin = fresh.get();
    sand.scene.run(input);
    const Mesh now = mesh_of(sand.skin), once = mesh_of(fresh);
    EXPECT_LT(apart(now, once), 0.1 * k_radius);
    EXPECT_LT(apart(once, now), 0.1 * k_radius);
    if (i == 19) {
      EXPECT_GT(apart(before, once), 0.3 * k_radius) << "the sand does not move: the test could not fail";
    }
    sand.skin.refresh();
    sand.frame(0);
    EXPECT_EQ(sand.skin.hash(), fresh.hash()) << "made whole it must be that of a new skin";
  }
}

// Where eight chunks meet, some hold vertices of which only others have triangles: these stay as they were when the others
// are made anew. A triangle with a vertex of elsewhere would be long.
TEST(Skin, StaysWholeWhereChunksMeet) {
  for (int i = 0; i < 64; ++i) {
    const auto at = [&](int digit) { return 0.004f * static_cast<float>(i >> 2 * digit & 3); };
    Sand sand(rough(200));
    const auto add = [&](float x, float y, float z) {
      sand.scene.add(shifted(lattice(4, 4, 4, 2.05f * k_radius, k_radius), x, y, z));
      sand.frame(0);
    };
    add(at(0), at(1), at(2));
    add(0.2f, 0.1f, 0.2f);
    add(0.2f, 0.3f, 0.1f);
    const Mesh mesh = mesh_of(sand.skin);
    float longest = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Point a = place(mesh.vertices[mesh.triangles[t]]);
      const Point b = place(mesh.vertices[mesh.triangles[t % 3 == 2 ? t - 2 : t + 1]]);
      longest = std::max(longest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    EXPECT_LT(longest, 2 * std::sqrt(3.0f) * 1.5f * k_radius) << i;  // the diagonal of two cells
    uint32_t faults = 0;
    volume_over(mesh, {0, 1, 0}, &faults);
    EXPECT_EQ(faults, 0u) << i;
  }
}

TEST(Skin, ItsGrainsMoveWithTheSand) {
  Sand sand(rough(400));
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 4, 10, 2.05f * k_radius, k_radius));
  sand.until_rested();
  sand.skin.refresh();  // a patch that has had its block from a farther particle takes the nearest
  for (int i = 0; i < 3; ++i) sand.frame();
  const Mesh before = mesh_of(sand.skin);
  // Two nodes aside: the mesh is the same one, two nodes on.
  const std::array<float, 4> still = {0, 0, 0, 1};
  const Point shift = {2 * 1.5f * k_radius, 0, 0};
  accept(sand.scene.scene.move(still, shift));
  sand.skin.refresh();
  for (int i = 0; i < 3; ++i) sand.frame();
  const Mesh after = mesh_of(sand.skin);
  uint32_t same = 0, moved = 0;
  const double side = 0.0084;
  for (const sandglass_skin_vertex& v : before.vertices)
    for (const sandglass_skin_vertex& w : after.vertices) {
      if (std::hypot(v.position[0] + shift[0] - w.position[0], v.position[1] - w.position[1],
                     v.position[2] - w.position[2]) > 1e-3f)
        continue;
      ++moved;
      // Where both look the block up, apart from whole blocks: at x / side - origin / 65536.
      const double apart = (static_cast<double>(w.position[0]) - static_cast<double>(v.position[0])) / side -
                           static_cast<double>(static_cast<uint16_t>(w.origin[0] - v.origin[0])) / 65536;
      same += std::fabs(apart - std::round(apart)) < 0.02 && w.origin[1] == v.origin[1] ? 1 : 0;
    }
  EXPECT_GT(moved, before.vertices.size() * 9 / 10);
  EXPECT_GT(same, moved * 8 / 10) << "of " << moved;
}

// While a hand pushes, few patches take their block from another particle: a vertex counts that is nearest to one of the
// frame before, and has another anchor. Control: a mesh that forgets its anchors.
TEST(Skin, APushExchangesFewPatches) {
  struct Anchored {
    Point at;
    uint32_t anchor;
  };
  double shares[2];
  for (const bool forgets : {false, true}) {
    Sand sand(rough(1200));
    sand.scene.add_floor();
    sand.scene.add(lattice(10, 12, 10, 2.05f * k_radius, k_radius));
    sand.until_rested();
    sandglass_collider hand = sandglass::sphere(-0.3f, 0.05f, 0, 0.05f);
    hand.linear_velocity[0] = 0.2f;
    sand.scene.colliders.push_back(hand);
    std::vector<Anchored> before;
    uint32_t seen = 0, exchanged = 0;
    for (int i = 0; i < 120; ++i) {
      sand.scene.colliders.back().position[0] = -0.3f + 0.2f * static_cast<float>(i) / 60;
      sandglass::SkinMesh& mesh = sand.skin.get()->skin.meshes.front;
      if (forgets) std::fill_n(mesh.anchors, mesh.vertex_count, sandglass::k_none);
      sand.frame(1 / 60.0f);
      std::vector<Anchored> now;
      for (uint32_t c = 0; c < sand.skin.get()->skin.bricks.chunks.capacity; ++c)
        for (uint32_t v = 0; v < mesh.chunks[c].vertex_count; ++v) {
          const auto at = static_cast<size_t>(mesh.chunks[c].vertices - mesh.vertices) + v;
          now.push_back({place(mesh.vertices[at]), mesh.anchors[at]});
        }
      for (const Anchored& one : now) {
        if (i < 30) break;
        const Anchored* nearest = nullptr;
        float least = 0.5f * 1.5f * k_radius;
        for (const Anchored& other : before) {
          const float away = std::hypot(one.at[0] - other.at[0], one.at[1] - other.at[1], one.at[2] - other.at[2]);
          if (away < least) {
            least = away;
            nearest = &other;
          }
        }
        if (nearest == nullptr || least < 1e-6f) continue;  // what stands still is exchanged by none
        ++seen;
        exchanged += nearest->anchor != one.anchor ? 1 : 0;
      }
      before = now;
    }
    shares[forgets ? 1 : 0] = static_cast<double>(exchanged) / seen;
  }
  EXPECT_LE(shares[0], 0.08);
  EXPECT_GT(shares[1], 1.5 * shares[0]);
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
  sandglass::test::GuardedBlock block(bytes);
  sandglass_skin* skin = nullptr;
  ASSERT_EQ(sandglass_skin_create(&of, block.data(), bytes, &skin, nullptr), SANDGLASS_OK);
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
  EXPECT_TRUE(block.guards_intact());
}

// A budget that is too small: the skin is late, says so, and the one before stays whole.
TEST(Skin, ALateSkinLeavesTheOneBefore) {
  uint64_t now = 0;
  sandglass_scene_desc desc = rough(1000);
  desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user) += 20'000; }, &now};
  Sand sand(desc);
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 10, 10, 2.05f * k_radius, k_radius));
  for (int i = 0; i < 3; ++i) sand.frame(0.02f, 1'000'000'000);
  ASSERT_EQ(sand.skin.mesh().valid, 1u);
  uint32_t late = 0, versions = 0, before = sand.skin.mesh().version;
  uint64_t hash = sand.skin.hash();
  for (int i = 0; i < 200; ++i) {
    sand.frame(0.02f, 0);
    const sandglass_skin_mesh mesh = sand.skin.mesh();
    late += mesh.frames_behind > 0 ? 1 : 0;
    if (mesh.version == before) {
      EXPECT_EQ(sand.skin.hash(), hash);
    }
    versions += mesh.version != before ? 1 : 0;
    before = mesh.version;
    hash = sand.skin.hash();
    uint32_t faults = 0;
    volume_over(mesh_of(sand.skin), {0, 1, 0}, &faults);
    EXPECT_EQ(faults, 0u);
  }
  EXPECT_GT(late, 150u);
  EXPECT_GE(versions, 1u) << "one unit every second frame must be enough to complete a skin";
}

// Between two late skins the mesh goes on with its particles. Here all go one way, so every vertex goes as far as they do in
// the frame, and keeps its place in the block of grains.
TEST(Skin, ALateSkinIsCarriedAlong) {
  uint64_t now = 0;
  sandglass_scene_desc desc = rough(1000);
  desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user) += 20'000; }, &now};
  for (float& g : desc.gravity) g = 0;
  Sand sand(desc);
  const std::vector<float> places = lattice(10, 10, 10, 2.05f * k_radius, 0.0f);
  const float velocity[3] = {0.10f, 0.04f, -0.02f};
  std::vector<float> velocities;
  for (size_t i = 0; i < places.size(); ++i) velocities.push_back(velocity[i % 3]);
  sand.scene.add(places, velocities);
  const sandglass::SkinState& s = sand.skin.get()->skin;
  const auto lookup = [&](const sandglass_skin_vertex& v, int k) {
    return static_cast<double>(v.position[k]) / static_cast<double>(s.desc.block_side) - v.origin[k] / 65536.0;
  };
  Mesh before;
  double simulated = 0;
  bool was_now = false;
  uint32_t carried = 0, stood = 0, front = 0, version = 0;
  for (int i = 0; i < 60; ++i) {
    const sandglass_frame_report report = sand.frame(1.0f / 60, i == 0 ? 1'000'000'000 : 1'000'000);
    const double seconds = report.time.simulated - simulated;
    const bool is_now = s.shown.frame == s.frame, same = i > 2 && was_now && is_now && s.front_version == front;
    stood += i > 2 && s.shown.version == version ? 1 : 0;
    simulated = report.time.simulated;
    front = s.front_version;
    version = s.shown.version;
    was_now = is_now;
    const Mesh mesh = mesh_of(sand.skin);
    for (size_t v = 0; same && v < mesh.vertices.size(); ++v)
      for (int k = 0; k < 3; ++k) {
        const sandglass_skin_vertex &a = before.vertices[v], &b = mesh.vertices[v];
        const double way = static_cast<double>(b.position[k]) - static_cast<double>(a.position[k]);
        ASSERT_NEAR(way, static_cast<double>(velocity[k]) * seconds, 1e-5) << i;
        const double turns = lookup(b, k) - lookup(a, k);
        ASSERT_NEAR(turns, std::round(turns), 4.0 / 65536) << i;
      }
    carried += same ? 1 : 0;
    before = mesh;
  }
  EXPECT_EQ(stood, 0u);
  EXPECT_GE(carried, 20u) << "no skin was late: the test could not fail";
}

// The heights that the pile's shadow is made of are those of the mesh, under each texel's middle; and at rest it costs nothing.
TEST(Skin, ThePileShadowIsOfWhatIsDrawn) {
  Sand sand(rough(1600));
  sand.scene.add_floor();
  sand.scene.add(lattice(10, 16, 10, 2.05f * k_radius, k_radius));
  sand.throw_shadow();
  sand.until_rested();
  const Mesh mesh = mesh_of(sand.skin);
  const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_HEIGHTS);
  const sandglass_skin_mesh now = sand.skin.mesh();
  const uint32_t n = sky.side;
  const float texel = sky.along[0] / static_cast<float>(n);
  std::vector<float> truth(n * n, 0.0f);
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Point p[3];
    for (size_t k = 0; k < 3; ++k) p[k] = place(mesh.vertices[mesh.triangles[t + k]]);
    const auto first = static_cast<uint32_t>((p[0][2] - 0.05f - sky.corner[2]) / texel);  // rows near it
    for (uint32_t at = first * n; at < n * n && at < (first + n / 8) * n; ++at) {
      const uint32_t column = at % n, row = at / n;
      const float x = sky.corner[0] + (static_cast<float>(column) + 0.5f) * texel;
      const float z = sky.corner[2] + (static_cast<float>(row) + 0.5f) * texel;
      const auto side = [&](size_t k) {
        const Point &a = p[k], &b = p[(k + 1) % 3];
        return (b[2] - a[2]) * (x - a[0]) - (b[0] - a[0]) * (z - a[2]);
      };
      const float w[3] = {side(1), side(2), side(0)}, sum = w[0] + w[1] + w[2];
      if (sum > 0 && w[0] >= 0 && w[1] >= 0 && w[2] >= 0)
        truth[at] = std::max(truth[at], (w[0] * p[0][1] + w[1] * p[1][1] + w[2] * p[2][1]) / sum);
    }
  }
  uint32_t wrong = 0, high = 0;
  for (uint32_t at = 0; at < n * n; ++at) {
    high += truth[at] > 0.05f ? 1 : 0;
    wrong += std::abs(static_cast<float>(sky.bytes[at]) * sky.scale / 255 - truth[at]) > sky.scale / 255 ? 1 : 0;
  }
  EXPECT_GT(high, 100u);
  EXPECT_LE(wrong, now.flying_count + now.lying_count);  // loose sand has a column each
}

// Sand on a seat leaves the floor below it the light from beside: all but the form factor of a square of 0.13 m to the seat's
// 0.2, as low as a brick below the seat or the seat, 0.28 to 0.05; the texture's own error is 0.02. Sand on the floor, in the
// same chunk, leaves none.
TEST(Skin, BelowASeatTheFloorIsLit) {
  Sand sand(rough(400));
  sand.scene.add_floor();
  sand.scene.colliders.push_back(sandglass::box(0.12f, 0.30f, 0.12f, 0.1f, 0.01f, 0.1f));  // the seat
  sand.scene.add(shifted(lattice(6, 2, 6, 2.05f * k_radius, k_radius), 0.12f, 0.31f, 0.12f));
  sand.scene.add(shifted(lattice(6, 5, 6, 2.05f * k_radius, k_radius), 0.36f, 0.0f, 0.3f));
  sand.throw_shadow();
  sand.until_rested();
  const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR);
  const auto left = [&](float x, float z) {
    const auto texel = [&](float from, float extent) {
      return static_cast<uint32_t>(from / extent * static_cast<float>(sky.side));
    };
    return sky.bytes[texel(z - sky.corner[2], sky.across[2]) * sky.side + texel(x - sky.corner[0], sky.along[0])] /
           255.0;
  };
  EXPECT_GT(left(0.12f, 0.12f), 0.70);
  EXPECT_LT(left(0.12f, 0.12f), 0.95);
  EXPECT_LT(left(0.36f, 0.3f), 0.1);
}

// Two particles fall, one over a heap at rest, one over the floor. Each takes from the light what its share of its outline
// takes, k_loose of pi r^2 / sine of the elevation; and does so where its ray ends, on the heap or on the floor.
TEST(Skin, SandInTheAirThrowsItsOwnShadow) {
  constexpr float k_loose = 0.3f;  // pile_shadow.h: three tenths of a particle's outline
  Sand sand(rough(1600));
  sand.scene.add_floor();
  sand.scene.add(shifted(lattice(8, 9, 8, 2.05f * k_radius, k_radius), -0.25f, 0, 0));
  sand.throw_shadow();
  accept(sand.pile.set_light({0.36f, 0.8f, 0.48f}, 0.02f));
  const uint32_t n = sandglass::pile_shadow_desc().texels;
  const float texel = 1.0f / static_cast<float>(n);
  const auto textures = [&] {
    const uint8_t *floor = sand.pile.texture().bytes, *upper = sand.pile.texture(SANDGLASS_PILE_SHADOW_SAND).bytes;
    std::vector<int> all(floor, floor + n * n);
    all.insert(all.end(), upper, upper + n * n);
    return all;
  };
  sand.until_rested();
  const std::vector<int> before = textures();
  sand.scene.add({-0.115f, 0.42f, 0.18f, 0.25f, 0.42f, -0.1f});
  for (int i = 0; i < 6; ++i) sand.frame();
  for (int i = 0; i < 3; ++i) sand.frame(0);
  const std::vector<int> after = textures();
  const sandglass_skin_mesh mesh = sand.skin.mesh();
  ASSERT_EQ(mesh.flying_count, 2u);
  for (uint32_t k = 0; k < 2; ++k) {
    const sandglass_skin_loose& one = mesh.loose[k];
    const bool on_heap = one.position[0] < 0;
    double sum = 0, x = 0, z = 0;
    for (uint32_t i = 0; i < n * n; ++i) {  // of the texture that is drawn there
      if ((static_cast<float>(i % n) < 0.5f * static_cast<float>(n)) != on_heap) continue;
      const uint32_t at = on_heap ? n * n + i : i;
      const double passed = (255.0 - after[at]) / (255.0 - before[at]);
      if (before[at] > 128) continue;
      sum += 1 - passed;
      x += (1 - passed) * (i % n + 0.5);
      z += (1 - passed) * (i / n + 0.5);
    }
    const double outline = k_loose * M_PI * k_radius * k_radius / 0.8 / (texel * texel);
    EXPECT_NEAR(sum, static_cast<double>(one.weight) * outline, 0.06 * outline) << on_heap;
    // How far its shadow fell, by where it is: down to the heap, or to the floor.
    const double fell_x = (one.position[0] - (x / sum * texel - 0.5)) / (0.36 / 0.8);
    const double fell_z = (one.position[2] - (z / sum * texel - 0.5)) / (0.48 / 0.8);
    EXPECT_NEAR(fell_x, fell_z, 1.5 * texel);
    const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_HEIGHTS);
    const auto at = static_cast<uint32_t>(x / sum) + n * static_cast<uint32_t>(z / sum);
    const double top = static_cast<double>(sky.bytes[at]) * static_cast<double>(sky.scale) / 255;
    EXPECT_EQ(top > 0.03, on_heap);
    EXPECT_NEAR(fell_z, one.position[1] - top, (on_heap ? 1.5 : 0.5) * texel);
  }
}

}  // namespace

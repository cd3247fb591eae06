// The skin of sand that moves: made bit by bit it is whole, its grains go with the sand, and a late one is carried
// along.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "runtime/skin/skin.h"
#include "tests/skin/skin_mesh.h"

namespace {

// What is made bit by bit while sand moves is what is made of it at once, but for what a particle may move before it
// counts.
TEST(Skin, MadeBitByBitIsMadeAtOnce) {
  Sand sand(rough(1000));
  sand.lie(block(10, 10, 10));
  // How far all but one in fifty vertices of one are from those of the other at most.
  const auto distance = [](const Mesh& from, const Mesh& to) {
    std::vector<double> distances;
    for (const sandglass_skin_vertex& v : from.vertices) {
      double squared_min = 1e9;
      for (const sandglass_skin_vertex& w : to.vertices) {
        const Point d = {v.position[0] - w.position[0], v.position[1] - w.position[1], v.position[2] - w.position[2]};
        squared_min = std::min(squared_min, dot(d, d));
      }
      distances.push_back(std::sqrt(squared_min));
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
    EXPECT_LT(distance(now, once), 0.1 * k_radius);
    EXPECT_LT(distance(once, now), 0.1 * k_radius);
    if (i == 19) {
      EXPECT_GT(distance(before, once), 0.3 * k_radius) << "the sand does not move: the test could not fail";
    }
    sand.skin.refresh();
    sand.frame(0);
    EXPECT_EQ(sand.skin.hash(), fresh.hash()) << "made whole it must be that of a new skin";
  }
}

// Where eight chunks meet, some hold vertices of which only others have triangles: these stay as they were when the
// others are made anew. A triangle with a vertex of elsewhere would be long.
TEST(Skin, StaysWholeWhereChunksMeet) {
  for (int i = 0; i < 64; ++i) {
    const auto at = [&](int digit) { return 0.004f * static_cast<float>(i >> 2 * digit & 3); };
    Sand sand(rough(200));
    const auto add = [&](float x, float y, float z) {
      sand.scene.add(shifted(block(4, 4, 4), x, y, z));
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
    EXPECT_TRUE(is_closed(mesh)) << i;
  }
}

TEST(Skin, ItsGrainsMoveWithTheSand) {
  Sand sand(rough(400));
  sand.lie(block(10, 4, 10));
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
      const double offset = (static_cast<double>(w.position[0]) - static_cast<double>(v.position[0])) / side -
                            static_cast<double>(static_cast<uint16_t>(w.origin[0] - v.origin[0])) / 65536;
      same += std::fabs(offset - std::round(offset)) < 0.02 && w.origin[1] == v.origin[1] ? 1 : 0;
    }
  EXPECT_GT(moved, before.vertices.size() * 9 / 10);
  EXPECT_GT(same, moved * 8 / 10) << "of " << moved;
}

// While a hand pushes, few patches take their block from another particle: a vertex counts that is nearest to one of
// the frame before, and has another anchor. Control: a mesh that forgets its anchors.
TEST(Skin, APushExchangesFewPatches) {
  struct Anchored {
    Point at;
    uint32_t anchor;
  };
  double shares[2];
  for (const bool forgets : {false, true}) {
    Sand sand(rough(1200));
    sand.lie(block(10, 12, 10));
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
      for (const Anchored& own : now) {
        if (i < 30) break;
        const Anchored* nearest = nullptr;
        float distance_min = 0.5f * 1.5f * k_radius;
        for (const Anchored& other : before) {
          const float away = std::hypot(own.at[0] - other.at[0], own.at[1] - other.at[1], own.at[2] - other.at[2]);
          if (away < distance_min) {
            distance_min = away;
            nearest = &other;
          }
        }
        if (nearest == nullptr || distance_min < 1e-6f) continue;  // what stands still is exchanged by none
        ++seen;
        exchanged += nearest->anchor != own.anchor ? 1 : 0;
      }
      before = now;
    }
    shares[forgets ? 1 : 0] = static_cast<double>(exchanged) / seen;
  }
  EXPECT_LE(shares[0], 0.08);
  EXPECT_GT(shares[1], 1.5 * shares[0]);
}

// A budget that is too small: the skin is late, says so, and the one before stays whole.
TEST(Skin, ALateSkinLeavesTheOneBefore) {
  uint64_t now = 0;
  sandglass_scene_desc desc = rough(1000);
  desc.clock = {[](void* user) { return *static_cast<uint64_t*>(user) += 20'000; }, &now};
  Sand sand(desc);
  sand.lie(block(10, 10, 10));
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
    EXPECT_TRUE(is_closed(mesh_of(sand.skin)));
  }
  EXPECT_GT(late, 150u);
  EXPECT_GE(versions, 1u) << "one unit every second frame must be enough to complete a skin";
}

// Between two late skins the mesh goes on with its particles. Here all go one way, so every vertex goes as far as they
// do in the frame, and keeps its place in the block of grains.
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
        const double displacement = static_cast<double>(b.position[k]) - static_cast<double>(a.position[k]);
        ASSERT_NEAR(displacement, static_cast<double>(velocity[k]) * seconds, 1e-5) << i;
        const double turns = lookup(b, k) - lookup(a, k);
        ASSERT_NEAR(turns, std::round(turns), 4.0 / 65536) << i;
      }
    carried += same ? 1 : 0;
    before = mesh;
  }
  EXPECT_EQ(stood, 0u);
  EXPECT_GE(carried, 20u) << "no skin was late: the test could not fail";
}

}  // namespace

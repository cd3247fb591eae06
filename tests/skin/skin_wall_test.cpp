// The surface of sand in what holds it: nothing beyond walls and below floors, and all of it where the vessel goes.
#include <algorithm>
#include <cmath>

#include "tests/skin/skin_scene.h"

namespace {

constexpr float k_half = 0.085f, k_rim = 0.16f;  // of a bucket, inside

// Five boxes; the middle of its bottom's upper face at (0, height, 0), turned about y.
std::vector<sandglass_collider> bucket(float wall, float height, float turn, float velocity = 0) {
  const float e = wall / 2, h = k_rim / 2, a = k_half,
              sides[5][6] = {{0, -e, 0, a + wall, e, a + wall},
                             {a + e, h, 0, e, h, a + wall},
                             {-a - e, h, 0, e, h, a + wall},
                             {0, h, a + e, a + wall, h, e},
                             {0, h, -a - e, a + wall, h, e}};
  const float up[3] = {0, 1, 0}, c = std::cos(turn), s = std::sin(turn);
  std::vector<sandglass_collider> boxes;
  for (const auto& b : sides) {
    boxes.push_back(sandglass::box(c * b[0] + s * b[2], b[1] + height, c * b[2] - s * b[0], b[3], b[4], b[5]));
    EXPECT_EQ(sandglass_rotation_about(up, turn, boxes.back().rotation), 1);
    boxes.back().id = static_cast<uint32_t>(boxes.size());
    boxes.back().linear_velocity[1] = velocity;
  }
  return boxes;
}

std::vector<float> in_bucket(float height, float turn) {
  std::vector<float> points = lattice(7, 8, 7, 2.05f * k_radius, k_radius + height + 0.001f);
  const float middle = 3.25f * 2.05f * k_radius, c = std::cos(turn), s = std::sin(turn);
  for (size_t i = 0; i < points.size(); i += 3) {
    const float x = points[i] - middle, z = points[i + 2] - middle;
    points[i] = c * x + s * z;
    points[i + 2] = c * z - s * x;
  }
  return points;
}

template <class Visit>
void each_vertex(const Sand& sand, Visit visit) {
  const sandglass_skin_mesh mesh = sand.skin.mesh();
  for (uint32_t c = 0; c < mesh.chunk_count; ++c)
    for (uint32_t v = 0; v < mesh.chunks[c].vertex_count; ++v) visit(mesh.chunks[c].vertices[v].position);
}

// How far vertices are beyond the bucket at most, of those below its rim.
float beyond_bucket(const Sand& sand, float wall, float height, float turn) {
  float beyond_max = -1;
  const float c = std::cos(turn), s = std::sin(turn);
  each_vertex(sand, [&](const float* p) {
    if (p[1] > height + k_rim) return;
    beyond_max = std::max({beyond_max, std::fabs(c * p[0] - s * p[2]) - k_half - wall,
                           std::fabs(s * p[0] + c * p[2]) - k_half - wall, height - wall - p[1]});
  });
  return beyond_max;
}

// A wall of one spacing of nodes, 1.5 radii, lets nothing through, a thinner one no more than a radius; whatever it is made
// of, and however it stands. Sand is up to the walls: within one and a half nodes.
TEST(SkinWalls, NothingStandsOutside) {
  for (const float wall : {0.002f, 0.01f, 0.015f, 0.03f})
    for (const float turn : {0.0f, 0.5f})
      for (const bool field : {false, true}) {
        if (field && (turn != 0 || wall < 0.01f)) continue;
        Sand sand(rough(400));
        const float height = wall;
        sandglass::Field shell;
        const auto distance = [&](const float* p) {
          const float side = std::max(std::fabs(p[0]), std::fabs(p[2]));
          return std::max(std::min(k_half - side, p[1]), std::max({side - k_half - wall, -wall - p[1], p[1] - k_rim}));
        };
        const float reach = k_half + wall + 0.02f;
        accept(shell.from_function({{-reach, -wall - 0.02f, -reach}, {reach, k_rim + 0.02f, reach}}, 0.005f,
                                   SANDGLASS_SOLID_INSIDE, distance));
        if (field) sand.scene.colliders = {sandglass::field_at(shell, 0, height, 0)};
        else sand.scene.colliders = bucket(wall, height, turn);
        sand.scene.add_floor();
        sand.scene.add(in_bucket(height, turn));
        sand.until_rested();
        const float beyond = beyond_bucket(sand, wall, height, turn);
        EXPECT_LE(beyond, wall >= 1.5f * k_radius ? 0.0f : k_radius) << wall << " " << turn << " " << field;
        EXPECT_GT(beyond, -wall - 1.5f * 1.5f * k_radius);
      }
}

// Sand against one wall that leans, as against a dam.
TEST(SkinWalls, NothingStandsBehindADam) {
  for (const float wall : {0.002f, 0.02f}) {
    Sand sand(rough(600));
    sand.scene.add_floor();
    sandglass_collider dam = sandglass::box(0, 0.2f, 0, wall / 2, 0.4f, 0.6f);
    const float axis[3] = {0, 0, 1};
    ASSERT_EQ(sandglass_rotation_about(axis, 0.35f, dam.rotation), 1);
    sand.scene.colliders.push_back(dam);
    sand.scene.add(shifted(block(8, 8, 9), 0.1f, 0, -0.1f));
    sand.until_rested();
    float lowest = 1;
    each_vertex(sand, [&](const float* p) {
      lowest = std::min(lowest, std::cos(0.35f) * p[0] + std::sin(0.35f) * (p[1] - 0.2f) + wall / 2);
    });
    EXPECT_GE(lowest, wall >= 1.5f * k_radius ? 0.0f : -k_radius) << wall;
    EXPECT_LT(lowest, 0.05f);  // it is there
  }
}

// Below a floor a third of a node at most; and sand that is all loose has no mesh.
TEST(SkinWalls, NothingLiesBelowTheFloor) {
  for (const bool strewn : {false, true}) {
    Sand sand(rough(900));
    sand.scene.add_floor();
    std::vector<float> points = block(9, 10, 9);
    if (strewn) points = lattice(30, 1, 30, 2.6f * k_radius, k_radius);  // gaps of 0.6 radii
    sand.scene.add(points);
    sand.until_rested();
    float low = 1;
    each_vertex(sand, [&](const float* p) { low = std::min(low, p[1]); });
    EXPECT_GE(low, -1.5f * k_radius / 3);
    const sandglass_skin_mesh mesh = sand.skin.mesh();
    EXPECT_EQ(mesh.index_count == 0, strewn);
    if (strewn) {
      EXPECT_EQ(mesh.lying_count, 900u);
    }
  }
}

// In a bucket that is lowered sand lies as still as in one that stands: its mesh stays, and none flies. Control: sand that
// falls as fast beside it.
TEST(SkinWalls, ALoweredBucketKeepsItsSkin) {
  for (const float speed : {0.3f, 0.8f, 1.5f}) {
    Sand sand(rough(500));
    sand.scene.colliders = bucket(0.02f, 0, 0);
    sand.scene.add(in_bucket(0, 0));
    sand.until_rested();
    const uint32_t rested = sand.skin.mesh().index_count;
    float height = 0, velocity = 0;
    for (int i = 0; i < 60; ++i) {
      velocity = std::max(-speed, velocity - 3.0f / 60);
      height += velocity / 60;
      sand.scene.colliders = bucket(0.02f, height, 0, velocity);
      sand.frame(1 / 60.0f);
      EXPECT_GT(sand.skin.mesh().index_count, rested * 8 / 10) << speed << " " << i;
      EXPECT_LE(sand.skin.mesh().flying_count, 4u) << speed << " " << i;
    }
    const std::vector<float> drops = shifted(block(3, 3, 3), 0.3f, height + 0.5f, 0);
    std::vector<float> falling;
    for (size_t i = 0; i < drops.size(); ++i) falling.push_back(i % 3 == 1 ? -1.0f : 0.0f);
    sand.scene.add(drops, falling);
    sand.frame(0);
    EXPECT_GE(sand.skin.mesh().flying_count, 27u);
  }
}

// A hand over sand that sleeps costs nothing where no node of the sand feels it: from 2.6 nodes on. Control: one that is nearer.
TEST(SkinWalls, AHandInTheAirCostsNothing) {
  for (const bool near : {false, true}) {
    Sand sand(rough(500));
    sand.lie(block(10, 3, 10));
    sand.scene.colliders.push_back(sandglass::sphere(0.1f, near ? 0.1f : 0.17f, 0.1f, 0.01f));
    sand.until_rested();
    uint32_t units = 0;
    for (int i = 0; i < 20; ++i) {
      sand.scene.colliders.back().position[0] += i < 10 ? 0.005f : -0.005f;
      const sandglass_frame_report report = sand.frame();
      EXPECT_EQ(report.sand.awake, 0u);
      units += report.stages[SANDGLASS_STAGE_SKIN].units;
    }
    EXPECT_EQ(units == 0, !near);
  }
}

}  // namespace

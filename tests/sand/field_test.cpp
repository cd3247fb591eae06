// Signed-distance fields: their distances from meshes and functions against closed forms, what is refused, and what a
// field holds as a collider. The limits of the error follow from the grid's spacing and the surface's curvature alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "models/mesh/generated.h"
#include "platform/virtual_clock.h"
#include "tests/guarded_block.h"
#include "tests/sand/granular_scene.h"
#include "tests/sand/mesh_collider.h"

namespace {

using sandglass::host::make_icosphere;
using sandglass::host::make_torus;
using sandglass::host::Mesh;

// Points spread through a box, without a random number generator: an additive recurrence.
template <class Visit>
void for_points(const sandglass::Box& box, int count, const Visit& visit) {
  const double step[3] = {0.8191725134, 0.6710436067, 0.5497004779};
  for (int i = 1; i <= count; ++i) {
    float p[3];
    for (int k = 0; k < 3; ++k) {
      const double t = step[k] * i - std::floor(step[k] * i), low = box.min[k], extent = box.max[k] - box.min[k];
      p[k] = static_cast<float>(low + t * extent);
    }
    visit(p);
  }
}

double length(const float* p) { return std::hypot(p[0], p[1], p[2]); }

TEST(Field, OfASphereHasItsDistanceAndNormal) {
  constexpr double k_spacing = 0.01, k_band = 0.04;
  const MeshCollider sphere(make_icosphere(0.1f, 4), SANDGLASS_SOLID_INSIDE, 0.01f, 0.04f, 0.05f);
  // Trilinear interpolation of a function with two curvatures of 1/rho errs by at most h^2/4rho. The chords of the
  // icosphere (its edge is e = 0.1 * 1.26 / 2^4) lie at most e^2/2R below the sphere.
  const double edge = 0.1 * 1.26 / 16.0, chord = edge * edge / (2.0 * 0.1);
  double worst = 0.0;
  for_points(sphere.box, 5000, [&](const float* p) {
    const double rho = length(p), truth = rho - 0.1;
    if (std::fabs(truth) > k_band - 2 * k_spacing) return;
    float normal[3];
    const double distance = static_cast<double>(sandglass_field_distance(sphere.field.get(), p, normal));
    worst = std::max(worst, std::fabs(distance - truth));
    EXPECT_NEAR(distance, truth, k_spacing * k_spacing / (4 * (rho - k_spacing)) + chord + 1e-6);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(normal[k], static_cast<double>(p[k]) / rho, 0.12);
  });
  EXPECT_GT(worst, 0.0);
}

TEST(Field, FarFromTheSurfaceItIsAtMostThirteenPercentTooLong) {
  const MeshCollider torus(make_torus(0.1f, 0.04f, 96, 48), SANDGLASS_SOLID_INSIDE, 0.01f, 0.02f, 0.1f);
  for_points(torus.box, 5000, [&](const float* p) {
    const double ring = std::hypot(p[0], p[2]) - 0.1, truth = std::hypot(ring, p[1]) - 0.04;
    const double distance = static_cast<double>(torus.field.distance(p));
    EXPECT_TRUE(std::fabs(truth) <= 1.5e-3 || (distance > 0) == (truth > 0));
    // Interpolation (h^2/4rho at the tube, rho >= 2 cm beyond the ridge) and the mesh's chords come on top.
    EXPECT_LE(std::fabs(distance), 1.13 * std::fabs(truth) + 2.5e-3);
    EXPECT_TRUE(truth <= 0 || distance >= truth - 2.5e-3);
  });
}

TEST(Field, TwoSidesDifferInSignAndBeyondTheGrid) {
  const Mesh ball = make_icosphere(0.1f, 4);
  const MeshCollider solid(ball, SANDGLASS_SOLID_INSIDE, 0.01f, 0.03f, 0.03f),
      room(ball, SANDGLASS_SOLID_OUTSIDE, 0.01f, 0.03f, 0.03f);
  for_points(solid.box, 2000, [&](const float* p) { EXPECT_EQ(solid.field.distance(p), -room.field.distance(p)); });
  const float far[3] = {3.0f, 0.0f, 0.0f};
  float normal[3];
  EXPECT_NEAR(sandglass_field_distance(solid.field.get(), far, normal), 3.0 - 0.13, 0.02);
  EXPECT_EQ(normal[0], 1.0f);
  EXPECT_LT(sandglass_field_distance(room.field.get(), far, normal), -2.8f);
  EXPECT_EQ(normal[0], -1.0f);

  const float beyond_all[3] = {-3e38f, 0.0f, 0.0f}, no_point[3] = {0.0f, INFINITY, 0.0f};
  EXPECT_NEAR(sandglass_field_distance(solid.field.get(), beyond_all, normal), 1e6f, 1.0f);
  EXPECT_EQ(normal[0], -1.0f);
  EXPECT_EQ(sandglass_field_distance(solid.field.get(), no_point, normal), 0.0f);
  EXPECT_EQ(normal[1], 1.0f);
}

float ball_distance(void* user, const float p[3]) { return static_cast<float>(length(p)) - *static_cast<float*>(user); }
float no_distance(void*, const float*) { return NAN; }

TEST(Field, RefusesWhatMakesNoSense) {
  sandglass_field_desc ball = sandglass::field_desc();
  for (float& edge : ball.bounds_min) edge = -0.15f;
  for (float& edge : ball.bounds_max) edge = 0.15f;
  ball.spacing = 0.01f;
  ball.distance = ball_distance;
  uint64_t bytes = 0;
  ASSERT_EQ(sandglass_field_bytes(&ball, &bytes, nullptr), SANDGLASS_OK);
  sandglass::test::GuardedBlock block(bytes);
  // What is made. By default it is a ball.
  struct Made {
    sandglass_status expected = SANDGLASS_ERROR_INVALID_ARGUMENT;
    float spacing = 0.01f, radius = 0.1f;
    sandglass_solid solid = SANDGLASS_SOLID_INSIDE;
    sandglass_distance_function distance = ball_distance;
    bool turned = false;
  };
  const Made cases[] = {{.expected = SANDGLASS_OK},
                        {.distance = no_distance},
                        {.solid = 7},
                        {.turned = true},
                        {.spacing = NAN},
                        {.spacing = 1e-5f},  // 2^24 nodes
                        {.radius = 0.2f}};   // leaves the box
  for (const Made& c : cases) {
    sandglass_field* field = nullptr;
    const char* reason = nullptr;
    float radius = c.radius;
    sandglass_field_desc desc = ball;
    desc.spacing = c.spacing;
    desc.solid = c.solid;
    desc.distance = c.distance;
    desc.distance_user = &radius;
    if (c.turned) std::swap(desc.bounds_min, desc.bounds_max);
    EXPECT_EQ(sandglass_field_create(&desc, block.data(), bytes, &field, &reason), c.expected) << "case " << &c - cases;
    EXPECT_EQ(reason == nullptr, c.expected == SANDGLASS_OK);
    EXPECT_TRUE(block.guards_intact());
  }
  // A collider without a field is left out.
  GranularScene scene(description(1));
  scene.add({0.0f, 1.0f, 0.0f});
  scene.colliders.push_back(sandglass::field_at({}, 0.0f, 0.0f, 0.0f));
  EXPECT_EQ(scene.frame(0.02f).sand.ignored_colliders, 1u);
}

using Distance = std::function<double(const float*)>;

// A field made from a function, over the box -x..x, -y..y, -z..z.
struct FunctionField {
  FunctionField(const Distance& distance, float x, float y, float z, double spacing, sandglass_solid solid)
      : box{{-x, -y, -z}, {x, y, z}} {
    made = field.from_function(box, static_cast<float>(spacing), solid,
                               [&](const float* p) { return static_cast<float>(distance(p)); });
  }
  sandglass_collider collider() const { return sandglass::field_at(field, 0.0f, 0.0f, 0.0f); }
  double distance(const float* p) const { return static_cast<double>(field.distance(p)); }

  sandglass::Box box;
  sandglass::Field field;
  sandglass::Status made;
};

Distance box_distance(double x, double y, double z) {
  return [=](const float* p) {
    const double q[3] = {std::fabs(static_cast<double>(p[0])) - x, std::fabs(static_cast<double>(p[1])) - y,
                         std::fabs(static_cast<double>(p[2])) - z};
    const double out = std::hypot(std::max(q[0], 0.0), std::max(q[1], 0.0), std::max(q[2], 0.0));
    return out + std::min(std::max({q[0], q[1], q[2]}), 0.0);
  };
}

// Beside a flat face nothing is lost. Across an edge, the slope of the function is at most 1, so interpolation errs by
// at most sqrt(3)/2 spacings, the weighted distance of a cell's corners.
TEST(Field, OfABoxAreExactAtFacesAndBelowACellAtEdges) {
  const Distance truth = box_distance(0.1, 0.06, 0.08);
  const double h = 0.007;
  const FunctionField made(truth, 0.15f, 0.11f, 0.13f, h, SANDGLASS_SOLID_INSIDE);
  double edge = 0.0;
  int faces = 0;
  for_points(made.box, 40000, [&](const float* p) {
    const double distance = made.distance(p), d = truth(p);
    ASSERT_NEAR(distance, d, std::sqrt(3.0) / 2 * h);
    edge = std::max(edge, std::fabs(distance - d));
    // Only points above the top face count, and no other face may be within the reach of the cell.
    const double x = std::fabs(static_cast<double>(p[0])), z = std::fabs(static_cast<double>(p[2]));
    if (x > 0.1 - 3 * h || z > 0.08 - 3 * h || static_cast<double>(p[1]) < 0.06 - h) return;
    ++faces;
    ASSERT_NEAR(distance, d, 1e-6);
  });
  EXPECT_GT(faces, 1000);
  EXPECT_GT(edge, 0.05 * h) << "the edges were visited";
}

// On the middle plane of a flat wall the interpolant is at most h/2 - thickness/2. The reason is that
// sum_i w_i |n.(p - p_i)| <= h/2, since the weights' variance along each axis is at most h^2/4. So a wall that is
// thicker than a spacing has no holes at any angle.
TEST(Field, AWallThickerThanASpacingHasNoHoles) {
  constexpr double k_spacing = 0.01;
  const double normals[3][3] = {
      {0, 1, 0}, {0.36, 0.48, 0.8}, {0.577350269189626, 0.577350269189626, 0.577350269189626}};
  for (const auto& n : normals) {
    const auto along = [&](const float* p) {
      return n[0] * static_cast<double>(p[0]) + n[1] * static_cast<double>(p[1]) + n[2] * static_cast<double>(p[2]) -
             0.0043;  // off the nodes
    };
    const auto holes = [&](double thickness) {
      const Distance ball_of_wall = [&](const float* p) {
        const double away = std::hypot(p[0], p[1], p[2]) - 0.12;  // a round plate, away from the faces
        return std::max(std::fabs(along(p)) - thickness / 2, away);
      };
      const FunctionField made(ball_of_wall, 0.15f, 0.15f, 0.15f, k_spacing, SANDGLASS_SOLID_INSIDE);
      int found = 0;
      for_points(made.box, 5000, [&](const float* p) {
        float q[3];
        for (int k = 0; k < 3; ++k) q[k] = p[k] - static_cast<float>(along(p) * n[k]);
        if (std::hypot(q[0], q[1], q[2]) > 0.09f) return;
        const double distance = made.distance(q);
        EXPECT_LT(distance, 0.5 * (k_spacing - thickness) + 1e-6);
        found += distance > 0.0 ? 1 : 0;
      });
      return found;
    };
    EXPECT_EQ(holes(1.01 * k_spacing), 0) << "normal " << n[0] << " " << n[1] << " " << n[2];
    if (n[0] > 0) {
      EXPECT_GT(holes(0.3 * k_spacing), 0) << "a tilted wall of a third of a spacing is a sieve";
    }
  }
}

// A wall of 1 mm between the nodes of a grid of 1 cm would be a collider that nothing touches.
TEST(Field, AWallThatNoNodeMeetsIsRefused) {
  for (const double sign : {1.0, -1.0}) {
    for (const double half : {0.0005, 0.006}) {
      const Distance sheet = [&](const float* p) {
        const double x = std::max(std::fabs(static_cast<double>(p[0])), std::fabs(static_cast<double>(p[2]))) - 0.1;
        return sign * std::max(std::fabs(static_cast<double>(p[1]) + 0.0043) - half, x);
      };
      const FunctionField field(sheet, 0.2f, 0.1f, 0.2f, 0.01,
                                sign > 0 ? SANDGLASS_SOLID_INSIDE : SANDGLASS_SOLID_OUTSIDE);
      EXPECT_EQ(field.made.code, half > 0.005 ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT) << half << " " << sign;
      if (half > 0.005) continue;
      EXPECT_NE(std::string(field.made.reason).find("spacing"), std::string::npos) << field.made.reason;
    }
  }
}

// A particle lies on a block that turns and travels. The field of a box carries it to the same place as the analytic
// box does.
TEST(Field, AMovingFieldCarriesAsTheAnalyticBoxDoes) {
  const FunctionField made(box_distance(0.2, 0.05, 0.2), 0.25f, 0.1f, 0.25f, 0.01, SANDGLASS_SOLID_INSIDE);
  std::vector<float> ends[2];
  for (int analytic = 0; analytic < 2; ++analytic) {
    GranularScene scene(description(1));
    scene.add({0.05f, 0.0601f, 0.02f});
    sandglass_collider block = analytic != 0 ? sandglass::box(0, 0, 0, 0.2f, 0.05f, 0.2f) : made.collider();
    block.linear_velocity[0] = 0.2f;
    block.linear_velocity[1] = 0.1f;
    block.angular_velocity[1] = 0.8f;
    scene.colliders.push_back(block);
    for (int frame = 1; frame <= 50; ++frame) {
      const double t = 0.02 * frame, half = 0.5 * 0.8 * t;
      sandglass_collider& c = scene.colliders[0];
      c.position[0] = static_cast<float>(0.2 * t);
      c.position[1] = static_cast<float>(0.1 * t);
      c.rotation[1] = static_cast<float>(std::sin(half));
      c.rotation[3] = static_cast<float>(std::cos(half));
      scene.frame(0.02f);
    }
    ends[analytic] = scene.positions();
  }
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[0][k], ends[1][k], 2e-5) << "axis " << k;
  EXPECT_GT(ends[0][0], 0.1f) << "it was carried";
  EXPECT_NEAR(ends[0][1], 0.16, 1e-3);
}

// Grains and particles fall at `speed` on a lid at y = 0. The result says how many end below it.
struct Leak {
  uint32_t grains = 0, particles = 0;
};
Leak shoot(const FunctionField& lid, float speed, uint32_t frames) {
  std::vector<float> particles, grains, velocities;
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 8; ++i) {
      // The heights are staggered over a grain's step, so that some are about to touch when a step begins.
      const float x = 0.05f * static_cast<float>(i - 4), z = 0.05f * static_cast<float>(j - 4);
      const float y = 0.06f + 0.0005f * static_cast<float>(8 * j + i);
      particles.insert(particles.end(), {x, y, z});
      velocities.insert(velocities.end(), {0.0f, -speed, 0.0f});
      // Between four particles and out of their reach of 3 r, so the grain is in free flight.
      grains.insert(grains.end(), {x + 0.025f, y, z + 0.025f});
    }
  }
  GranularScene scene(description(64, 64));
  scene.add(particles, velocities, grains, velocities);
  scene.colliders.push_back(lid.collider());
  for (uint32_t frame = 0; frame < frames; ++frame) scene.frame(0.02f);
  Leak leak;
  const std::vector<float> p = scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) leak.particles += p[i] < 0.0f ? 1 : 0;
  for (const sandglass_grain& g : scene.grains) leak.grains += g.position[1] < 0.0f ? 1 : 0;
  return leak;
}

TEST(Field, GrainsDoNotPassAWallOfTwoStepsThickness) {
  sandglass_scene_desc defaults;
  sandglass_scene_desc_default(&defaults);
  for (const float speed : {1.0f, 3.0f}) {
    // The limit that sandglass_collider states, with a little more speed for gravity on the way down.
    const double limit = 2.0 * static_cast<double>(defaults.granular.refine_step) * (static_cast<double>(speed) + 0.5);
    const FunctionField wall(box_distance(0.4, limit / 2, 0.4), 0.5f, 0.15f, 0.5f, 0.005, SANDGLASS_SOLID_INSIDE);
    const Leak none = shoot(wall, speed, 12);
    EXPECT_EQ(none.grains, 0u) << "wall of " << limit << " m, " << speed << " m/s";
    EXPECT_EQ(none.particles, 0u);
    const FunctionField thin(box_distance(0.4, limit / 8, 0.4), 0.5f, 0.15f, 0.5f, 0.005, SANDGLASS_SOLID_INSIDE);
    EXPECT_GT(shoot(thin, speed, 12).grains, 0u) << "a quarter of the limit does not hold: the documented one is real";
  }
}

// The same lid as the wall of a container. Everything below it is solid, and even the fastest grain comes back.
TEST(Field, NothingPassesAContainersWallAtAnySpeed) {
  const Distance room = box_distance(0.4, 0.4, 0.4);
  const FunctionField wall([&](const float* p) { return -room(p); }, 0.5f, 0.5f, 0.5f, 0.02, SANDGLASS_SOLID_OUTSIDE);
  for (const float speed : {3.0f, 30.0f, 300.0f}) {
    std::vector<float> grains, velocities;
    for (int i = 0; i < 64; ++i) {
      grains.insert(grains.end(), {0.01f * static_cast<float>(i - 32), 0.005f * static_cast<float>(i), 0.1f});
      velocities.insert(velocities.end(), {0.3f * speed, -speed, 0.7f * speed});
    }
    GranularScene scene(description(64, 64));
    scene.add(grains, velocities, grains, velocities);
    scene.colliders.push_back(wall.collider());
    for (int frame = 0; frame < 100; ++frame) {
      scene.frame(0.02f);
      for (const sandglass_grain& g : scene.grains) ASSERT_GT(room(g.position), -0.5) << "is a number";
      if (frame < 2) continue;
      const std::vector<float> p = scene.positions();
      for (size_t i = 0; i < p.size(); i += 3) ASSERT_LT(room(&p[i]), 0.0) << "a particle, " << speed << " m/s";
      for (const sandglass_grain& g : scene.grains) ASSERT_LT(room(g.position), 1e-3) << "a grain, " << speed << " m/s";
    }
  }
}

// In a corner nodes are equally deep: no gradient leads out. Sand comes there when a room's pose was lost for a while.
// The control is a room that is gone.
TEST(Field, SandComesBackFromACornerOfAContainer) {
  const Distance room = box_distance(0.1, 0.1, 0.1);
  const FunctionField walls([&](const float* p) { return -room(p); }, 0.12f, 0.12f, 0.12f, 0.01,
                            SANDGLASS_SOLID_OUTSIDE);
  for (const bool there : {true, false}) {
    GranularScene scene(description(1));
    accept(scene.scene.set_gravity({-3.2f, 7.2f, 5.8f}));  // into the corner
    scene.add({-0.17f, 0.19f, 0.18f});
    if (there) scene.colliders.push_back(walls.collider());
    for (int frame = 0; frame < 500; ++frame) scene.frame(0.02f);
    EXPECT_EQ(room(scene.positions().data()) < 0.0, there) << room(scene.positions().data());
  }
}

struct alignas(64) Line {
  uint8_t bytes[64];
};

// A table of `height`, made in the given memory.
const sandglass_field* table_in(std::vector<Line>* memory, float height) {
  sandglass_field_desc desc = sandglass::field_desc();
  for (float& edge : desc.bounds_min) edge = -0.3f;
  for (float& edge : desc.bounds_max) edge = 0.3f;
  desc.spacing = 0.02f;
  desc.distance_user = &height;
  desc.distance = [](void* user, const float* p) {
    return std::fmax(std::fmax(std::fabs(p[0]) - 0.25f, std::fabs(p[2]) - 0.25f),
                     std::fabs(p[1] + 0.12f) - (0.12f + *static_cast<float*>(user)));
  };
  uint64_t bytes = 0;
  accept({sandglass_field_bytes(&desc, &bytes, nullptr), nullptr});
  memory->assign(bytes / sizeof(Line) + 1, {});
  sandglass_field* field = nullptr;
  EXPECT_EQ(sandglass_field_create(&desc, memory->data(), bytes, &field, nullptr), SANDGLASS_OK);
  return field;
}

sandglass_collider collider_of(const sandglass_field* field) {
  sandglass_collider c = sandglass::collider(SANDGLASS_SHAPE_FIELD, 0, 0, 0);
  c.field = field;
  return c;
}

// So it may be made in a worker, or kept in a file: it holds no address.
TEST(Field, ACopyOfItsBytesIsTheField) {
  std::vector<Line> memory;
  const sandglass_field* made = table_in(&memory, 0.0f);
  std::vector<float> distances;
  for_points({{-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f}}, 1000,
             [&](const float* p) { distances.push_back(sandglass_field_distance(made, p, nullptr)); });
  std::vector<Line> copy = memory;
  Line other;
  std::fill_n(other.bytes, sizeof other, uint8_t{0xff});
  std::fill(memory.begin(), memory.end(), other);
  size_t next = 0;
  for_points({{-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f}}, 1000, [&](const float* p) {
    EXPECT_EQ(sandglass_field_distance(reinterpret_cast<sandglass_field*>(copy.data()), p, nullptr), distances[next++]);
  });
}

// Pointers are the same: what a field holds decides.
TEST(Field, RebuiltInTheSameMemoryWakesWhatRestedOnIt) {
  for (const bool lower : {false, true}) {
    std::vector<Line> memory;
    GranularScene scene(description(200));
    scene.add(lattice(4, 3, 4, 0.0202f, 0.01f));
    scene.colliders.push_back(collider_of(table_in(&memory, 0.0f)));
    for (int frame = 0; frame < 400; ++frame) scene.frame(1.0f / 60.0f);
    ASSERT_EQ(scene.frame(1.0f / 60.0f).sand.awake, 0u);
    const double before = static_cast<double>(scene.positions()[1]);
    scene.colliders[0] = collider_of(table_in(&memory, lower ? -0.1f : 0.0f));
    for (int frame = 0; frame < 60; ++frame) scene.frame(1.0f / 60.0f);
    EXPECT_NEAR(before - static_cast<double>(scene.positions()[1]), lower ? 0.1 : 0.0, 0.01);
  }
}

// It is valid during the frames in which it is passed. One that ends in the middle of a step leaves nothing behind that
// reads it: what stands in its memory then would throw the sand, and the sanitizer tells the rest.
TEST(Field, IsNotReadOnceItIsNoLongerPassed) {
  sandglass::VirtualClock clock{.step_ns = 1000};
  sandglass_scene_desc desc = description(400, 1600);
  desc.clock = sandglass::virtual_clock(&clock);
  desc.unit_items = 64;
  std::vector<Line> memory;
  GranularScene scene(desc);
  const std::vector<float> sand = lattice(6, 5, 6, 0.0202f, 0.01f);
  scene.add(sand, {}, grains_about(sand, 0.004f));
  uint32_t starved = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const bool there = frame % 2 == 0;
    scene.colliders.assign(there ? 1 : 0, there ? collider_of(table_in(&memory, 0.0f)) : sandglass_collider{});
    starved += scene.frame(1.0f / 60.0f, 30'000 + 1'000 * static_cast<uint64_t>(frame)).time.debt > 0.0 ? 1 : 0;
    memory = {};
    const std::vector<float> p = scene.positions();
    for (const float x : p) ASSERT_LT(std::fabs(x), 100.0f) << frame;
  }
  EXPECT_GT(starved, 50u) << "frames end in the middle of steps";
}

}  // namespace

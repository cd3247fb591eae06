// The error limits of a field collider follow from the grid's spacing and the surface's curvature alone. The tests
// check them, and how thin a wall may be before fast grains pass it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "models/mesh/generated.h"
#include "tests/granular/box_points.h"
#include "tests/granular/granular_scene.h"

namespace {

using Distance = std::function<double(const float*)>;

float ask(void* user, const float p[3]) { return static_cast<float>((*static_cast<const Distance*>(user))(p)); }

// A field made from a function, over the box -reach..reach.
struct FunctionField {
  FunctionField(Distance distance, const float reach[3], float spacing, sandglass_solid solid) {
    const char* reason = nullptr;
    uint64_t bytes = 0;
    for (int k = 0; k < 3; ++k) low[k] = -reach[k], high[k] = reach[k];
    EXPECT_EQ(sandglass_field_bytes(low, high, spacing, &bytes, &reason), SANDGLASS_OK) << reason;
    block = sandglass::cpp::allocate_block(bytes);
    EXPECT_EQ(
        sandglass_field_from_function(low, high, spacing, solid, ask, &distance, block.get(), bytes, &field, &reason),
        SANDGLASS_OK)
        << reason;
  }
  sandglass_collider collider() const {
    sandglass_collider c = {};
    c.shape = SANDGLASS_SHAPE_FIELD;
    c.rotation[3] = 1.0f;
    c.field = field;
    return c;
  }
  float low[3], high[3];
  sandglass::cpp::Block block;
  sandglass_field* field = nullptr;
};

Distance box(double x, double y, double z) {
  return [=](const float* p) {
    const double q[3] = {std::fabs(static_cast<double>(p[0])) - x, std::fabs(static_cast<double>(p[1])) - y,
                         std::fabs(static_cast<double>(p[2])) - z};
    const double out = std::hypot(std::max(q[0], 0.0), std::max(q[1], 0.0), std::max(q[2], 0.0));
    return out + std::min(std::max({q[0], q[1], q[2]}), 0.0);
  };
}

// The distance from a torus has the curvatures 1/rho and cos/(distance from the axis), where rho is the distance from
// the ring. Trilinear interpolation errs by at most spacing^2/8 times their sum. Its gradient errs by at most the
// cell's diagonal times the Hessian's norm, and by twice that once normalised. Both take the worst place within the
// cell.
TEST(FieldBounds, OfATorusFollowFromSpacingAndCurvature) {
  constexpr double k_major = 0.1, k_minor = 0.04;
  const Distance torus = [](const float* p) { return std::hypot(std::hypot(p[0], p[2]) - k_major, p[1]) - k_minor; };
  const float reach[3] = {0.2f, 0.1f, 0.2f};
  double last = 0.0;
  for (const float spacing : {0.01f, 0.005f, 0.0025f}) {
    const FunctionField made(torus, reach, spacing, SANDGLASS_SOLID_INSIDE);
    const double h = static_cast<double>(spacing), diagonal = std::sqrt(3.0) * h;
    double worst = 0.0, worst_normal = 0.0;
    for_points(made.low, made.high, 20000, [&](const float* p) {
      const double truth = torus(p), axis = std::hypot(p[0], p[2]), rho = truth + k_minor;
      if (std::fabs(truth) > 0.015 || axis < 0.03) return;
      const double around = 1 / (rho - diagonal), along = 1 / (axis - diagonal);
      float normal[3];
      const double distance = static_cast<double>(sandglass_field_distance(made.field, p, normal));
      ASSERT_NEAR(distance, truth, h * h / 8 * (around + along) + 1e-6);
      const double ring = (axis - k_major) / rho / axis;
      const double n[3] = {ring * static_cast<double>(p[0]), static_cast<double>(p[1]) / rho,
                           ring * static_cast<double>(p[2])};
      const double error = std::hypot(static_cast<double>(normal[0]) - n[0], static_cast<double>(normal[1]) - n[1],
                                      static_cast<double>(normal[2]) - n[2]);
      ASSERT_LT(error, 2 * diagonal * std::hypot(around, along) + 1e-4);
      worst = std::max(worst, std::fabs(distance - truth)), worst_normal = std::max(worst_normal, error);
    });
    RecordProperty("distance_" + std::to_string(spacing), std::to_string(worst));
    RecordProperty("normal_" + std::to_string(spacing), std::to_string(worst_normal));
    if (last > 0.0) {
      EXPECT_NEAR(last / worst, 4.0, 1.0) << "second order";
    }
    last = worst;
  }
}

// Beside a flat face nothing is lost. Across an edge, the slope of the function is at most 1, so interpolation errs by
// at most sqrt(3)/2 spacings, the weighted distance of a cell's corners.
TEST(FieldBounds, OfABoxAreExactAtFacesAndBelowACellAtEdges) {
  const Distance truth = box(0.1, 0.06, 0.08);
  const float reach[3] = {0.15f, 0.11f, 0.13f};
  const double h = 0.007;
  const FunctionField made(truth, reach, static_cast<float>(h), SANDGLASS_SOLID_INSIDE);
  double edge = 0.0;
  int faces = 0;
  for_points(made.low, made.high, 40000, [&](const float* p) {
    const double distance = static_cast<double>(sandglass_field_distance(made.field, p, nullptr)), d = truth(p);
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
  RecordProperty("edge_in_spacings", std::to_string(edge / h));
}

// On the middle plane of a flat wall the interpolant is at most h/2 - thickness/2. The reason is that
// sum_i w_i |n.(p - p_i)| <= h/2, since the weights' variance along each axis is at most h^2/4. So a wall that is
// thicker than a spacing has no holes at any angle.
TEST(FieldBounds, AWallThickerThanASpacingHasNoHoles) {
  constexpr double k_spacing = 0.01;
  const float reach[3] = {0.15f, 0.15f, 0.15f};
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
      const FunctionField made(ball_of_wall, reach, static_cast<float>(k_spacing), SANDGLASS_SOLID_INSIDE);
      int found = 0;
      for_points(made.low, made.high, 5000, [&](const float* p) {
        float q[3];
        for (int k = 0; k < 3; ++k) q[k] = p[k] - static_cast<float>(along(p) * n[k]);
        if (std::hypot(q[0], q[1], q[2]) > 0.09f) return;
        const double distance = static_cast<double>(sandglass_field_distance(made.field, q, nullptr));
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
TEST(FieldBounds, AWallThatNoNodeMeetsIsRefused) {
  const float low[3] = {-0.2f, -0.1f, -0.2f}, high[3] = {0.2f, 0.1f, 0.2f};
  uint64_t bytes = 0;
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_field_bytes(low, high, 0.01f, &bytes, &reason), SANDGLASS_OK);
  const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes);
  sandglass_field* field = nullptr;
  for (const double sign : {1.0, -1.0}) {
    const sandglass_solid solid = sign > 0 ? SANDGLASS_SOLID_INSIDE : SANDGLASS_SOLID_OUTSIDE;
    for (const double half : {0.0005, 0.006}) {
      Distance sheet = [&](const float* p) {
        const double x = std::max(std::fabs(static_cast<double>(p[0])), std::fabs(static_cast<double>(p[2]))) - 0.1;
        return sign * std::max(std::fabs(static_cast<double>(p[1]) + 0.0043) - half, x);
      };
      const sandglass_status status =
          sandglass_field_from_function(low, high, 0.01f, solid, ask, &sheet, block.get(), bytes, &field, &reason);
      EXPECT_EQ(status, half > 0.005 ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT) << half << " " << sign;
      if (status != SANDGLASS_OK) {
        EXPECT_NE(std::string(reason).find("spacing"), std::string::npos) << reason;
      }
    }
  }
}

// A particle lies on a block that turns and travels. The field of a box carries it to the same place as the analytic
// box does.
TEST(FieldBounds, AMovingFieldCarriesAsTheAnalyticBoxDoes) {
  const float reach[3] = {0.25f, 0.1f, 0.25f};
  const FunctionField made(box(0.2, 0.05, 0.2), reach, 0.01f, SANDGLASS_SOLID_INSIDE);
  std::vector<float> ends[2];
  for (int analytic = 0; analytic < 2; ++analytic) {
    GranularScene scene(description(1));
    scene.add({0.05f, 0.0601f, 0.02f});
    sandglass_collider block = made.collider();
    if (analytic != 0) {
      block.shape = SANDGLASS_SHAPE_BOX;
      block.size[0] = block.size[2] = 0.2f, block.size[1] = 0.05f;
    }
    block.linear_velocity[0] = 0.2f, block.linear_velocity[1] = 0.1f, block.angular_velocity[1] = 0.8f;
    scene.colliders.push_back(block);
    for (int frame = 1; frame <= 50; ++frame) {
      const double t = 0.02 * frame, half = 0.5 * 0.8 * t;
      sandglass_collider& c = scene.colliders[0];
      c.position[0] = static_cast<float>(0.2 * t), c.position[1] = static_cast<float>(0.1 * t);
      c.rotation[1] = static_cast<float>(std::sin(half)), c.rotation[3] = static_cast<float>(std::cos(half));
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

TEST(FieldBounds, GrainsDoNotPassAWallOfTwoStepsThickness) {
  sandglass_scene_desc defaults;
  sandglass_scene_desc_default(&defaults);
  const float reach[3] = {0.5f, 0.15f, 0.5f};
  for (const float speed : {1.0f, 3.0f}) {
    // The limit that sandglass_collider states, with a little more speed for gravity on the way down.
    const double limit = 2.0 * static_cast<double>(defaults.granular.refine_step) * (static_cast<double>(speed) + 0.5);
    const FunctionField wall(box(0.4, limit / 2, 0.4), reach, 0.005f, SANDGLASS_SOLID_INSIDE);
    const Leak none = shoot(wall, speed, 12);
    EXPECT_EQ(none.grains, 0u) << "wall of " << limit << " m, " << speed << " m/s";
    EXPECT_EQ(none.particles, 0u);
    const FunctionField thin(box(0.4, limit / 8, 0.4), reach, 0.005f, SANDGLASS_SOLID_INSIDE);
    EXPECT_GT(shoot(thin, speed, 12).grains, 0u) << "a quarter of the limit does not hold: the documented one is real";
  }
}

TEST(FieldBounds, ParticlesDoNotPassAWallOfTheirOwnRadius) {
  const float reach[3] = {0.5f, 0.05f, 0.5f};
  const FunctionField wall(box(0.4, 0.005, 0.4), reach, 0.005f, SANDGLASS_SOLID_INSIDE);
  EXPECT_EQ(shoot(wall, 3.0f, 12).particles, 0u);
  EXPECT_EQ(shoot(wall, 8.0f, 12).particles, 0u);
}

// The same lid as the wall of a container. Everything below it is solid, and even the fastest grain comes back.
TEST(FieldBounds, NothingPassesAContainersWallAtAnySpeed) {
  const float reach[3] = {0.5f, 0.5f, 0.5f};
  const Distance room = box(0.4, 0.4, 0.4);
  const FunctionField wall([&](const float* p) { return -room(p); }, reach, 0.02f, SANDGLASS_SOLID_OUTSIDE);
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

}  // namespace

// The room tracer against closed forms of light transport: the form factor of a rectangle, the integrating sphere, the
// sun's irradiance. Equal seeds give equal bits on any number of threads.
#include "models/rooms/room_render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/rooms/room_builder.h"

namespace sandglass::host {
namespace {

constexpr double k_pi = std::numbers::pi;

// The form factor from a small face to a parallel rectangle of a x b at distance h, with a corner above the face.
double corner_form_factor(double a, double b, double h) {
  const double x = a / h, y = b / h, sx = std::sqrt(1 + x * x), sy = std::sqrt(1 + y * y);
  return (x / sx * std::atan(y / sx) + y / sy * std::atan(x / sy)) / (2 * k_pi);
}

// A floor of reflectance 1/2, seen from 1 m above its middle, and nothing else.
RoomBuilder bare_floor() {
  RoomBuilder b(1);
  b.room.size = {4, 3, 4};
  b.room.eye = {2, 1, 2};
  b.quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}, b.material({{0.5, 0.5, 0.5}}));
  return b;
}

// A square window in the ceiling lets the sky light it.
RoomBuilder floor_below_window(Vec3 corner, double side) {
  RoomBuilder b = bare_floor();
  Emitter window;
  window.kind = Emitter::Kind::window;
  window.corner = corner;
  window.edge_a = {side, 0, 0};
  window.edge_b = {0, 0, side};
  b.room.emitters.push_back(window);
  return b;
}

Vec3 straight_down(const Room& room, int samples) {
  RoomRenderOptions options;
  options.width = 32;
  options.samples = samples;
  const RadianceMap map = trace_room(room, options).radiance;
  Vec3 mean;
  for (int u = 0; u < map.width; ++u) mean = mean + map.colour(u, map.height - 1) * (1.0 / map.width);
  return mean;
}

TEST(RoomTracer, PanelOverFloor) {
  RoomBuilder b = bare_floor();
  b.quad_emitter({1.6, 2.5, 1.7}, {0.8, 0, 0}, {0, 0, 0.6}, {1000, 500, 250});  // shines down, above the eye
  const double expected = 0.5 * 1000 * 4 * corner_form_factor(0.4, 0.3, 2.5);
  const Vec3 found = straight_down(b.room, 256);
  EXPECT_NEAR(found.x, expected, 0.01 * expected);
  EXPECT_NEAR(found.y, 0.5 * found.x, 1e-3 * expected);
}

TEST(RoomTracer, WindowInTheCeilingUnderAnEvenSky) {
  RoomBuilder b = floor_below_window({1.5, 3, 1.5}, 1);
  b.room.sky.zenith = b.room.sky.horizon = b.room.sky.skyline = {200, 200, 200};
  const double expected = 0.5 * 200 * 4 * corner_form_factor(0.5, 0.5, 3.0);
  EXPECT_NEAR(straight_down(b.room, 256).x, expected, 0.01 * expected);
}

TEST(RoomTracer, SunThroughAWindow) {
  RoomBuilder b = floor_below_window({0, 3, 0}, 4);
  b.room.sky.sun_direction = normalised(Vec3{0.3, 0.8, -0.1});
  b.room.sky.sun_radiance = {1e6, 1e6, 1e6};
  const double solid_angle = 2 * k_pi * (1 - k_sun_cosine);
  const double expected = 0.5 / k_pi * 1e6 * solid_angle * b.room.sky.sun_direction.y;
  EXPECT_NEAR(straight_down(b.room, 64).x, expected, 0.01 * expected);
}

TEST(RoomTracer, IntegratingSphere) {
  RoomBuilder b(1);
  b.room.size = {4, 4, 4};
  b.room.eye = {2, 2.8, 2};
  const double reflectance = 0.5, lamp = 0.2, wall = 2.0;
  b.sphere({2, 2, 2}, wall, b.material({{reflectance, reflectance, reflectance}}));
  b.sphere_emitter({2, 2, 2}, lamp, {1000, 1000, 1000});
  RoomRenderOptions options;
  options.width = 32;
  options.samples = 256;
  const RadianceMap map = trace_room(b.room, options).radiance;
  // Above the eye is the wall: flux / area, reflected again and again, less the part that the lamp absorbs.
  const double flux = k_pi * 1000 * 4 * k_pi * lamp * lamp, area = 4 * k_pi * wall * wall;
  const double swallowed = lamp * lamp / (wall * wall);
  const double expected = reflectance * flux / (k_pi * area * (1 - reflectance * (1 - swallowed)));
  double mean = 0;
  for (int u = 0; u < map.width; ++u) mean += luminance(map.colour(u, 0)) / map.width;
  EXPECT_NEAR(mean, expected, 0.04 * expected);  // both spheres are polyhedra of 10 bands
}

TEST(RoomTracer, DepthIsThatOfTheRoomAndRightIsMinusX) {
  RoomBuilder b(1);
  b.room.size = {4, 3, 5};
  b.room.eye = {1, 1, 2};
  b.box({2, 0, 2.5}, {4, 3, 5}, 0.0, b.material({}));
  b.sphere_emitter({0.3, 1, 2}, 0.1, {50, 50, 50});  // at -x of the eye
  RoomRenderOptions options;
  options.width = 64;
  options.samples = 16;
  const RoomPanorama made = trace_room(b.room, options);
  const auto depth_at = [&](Vec3 direction) {
    const PanoramaPlace place = panorama_place(direction, 64, 32);
    return made.depth[static_cast<size_t>(std::lround(place.v)) * 64 + static_cast<size_t>(std::lround(place.u)) % 64];
  };
  EXPECT_NEAR(depth_at({0, 0, 1}), 3.0, 0.02);
  EXPECT_NEAR(depth_at({1, 0, 0}), 3.0, 0.02);
  EXPECT_NEAR(depth_at({0, 0, -1}), 2.0, 0.02);
  EXPECT_NEAR(depth_at({0.01, -1, 0}), 1.0, 0.02);
  int brightest = 0;
  for (int u = 0; u < 64; ++u)
    if (luminance(made.radiance.colour(u, 16)) > luminance(made.radiance.colour(brightest, 16))) brightest = u;
  EXPECT_NEAR(brightest, 48, 4);  // a quarter of the panorama right of its centre
}

TEST(Rooms, SameSeedSameBitsOnAnyNumberOfThreads) {
  for (const uint64_t seed : {3u, 5u}) {
    RoomRenderOptions options;
    options.width = 32;
    options.samples = 4;
    const RoomPanorama one_thread = trace_room(make_room(seed), options);
    options.threads = 3;
    const RoomPanorama three_threads = trace_room(make_room(seed), options);
    EXPECT_EQ(one_thread.radiance.rgb, three_threads.radiance.rgb);
    EXPECT_EQ(one_thread.depth, three_threads.depth);
  }
}

// Random numbers are drawn in one order, whatever the compiler. What is drawn first decides how often is drawn later.
TEST(Rooms, OneSeedIsOneRoomWithEveryCompiler) {
  size_t triangles = 0, materials = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Room room = make_room(seed);
    triangles += room.triangles.size();
    materials += room.materials.size();
  }
  EXPECT_EQ(triangles, 55154u);  // as g++ and clang++ make them
  EXPECT_EQ(materials, 1223u);
}

TEST(Rooms, AreClosedLitAndDiffer) {
  RoomRenderOptions options;
  options.width = 32;
  options.samples = 4;
  double last_width = 0.0;
  for (uint64_t seed = 100; seed < 140; ++seed) {
    const Room room = make_room(seed);
    EXPECT_NE(room.size.x, last_width);
    last_width = room.size.x;
    RoomPanorama made = trace_room(room, options);
    expose(&made.radiance, room.key);
    const double diagonal = length(room.size);
    for (const float depth : made.depth) ASSERT_LE(depth, diagonal) << "seed " << seed << " leaks";
    double mean = 0.0;
    for (const float value : made.radiance.rgb) {
      ASSERT_TRUE(std::isfinite(value) && value >= 0.0f) << seed;
      mean += value / static_cast<double>(made.radiance.rgb.size());
    }
    EXPECT_GT(mean, 0.5 * room.key) << seed;
  }
}

TEST(Exposure, LogarithmicMeanBecomesTheKey) {
  RadianceMap map(16, 8);
  for (int v = 0; v < 8; ++v)
    for (int u = 0; u < 16; ++u) map.set(u, v, Vec3{3, 2, 1} * (u < 8 ? 1.0 : 4.0));
  expose(&map, 0.25);
  double logarithm = 0.0, area = 0.0;
  for (int v = 0; v < 8; ++v)
    for (int u = 0; u < 16; ++u) {
      logarithm += std::log(luminance(map.colour(u, v))) * pixel_solid_angle(v, 16, 8);
      area += pixel_solid_angle(v, 16, 8);
    }
  EXPECT_NEAR(std::exp(logarithm / area), 0.25, 1e-4);
  EXPECT_NEAR(map.colour(0, 0).x / map.colour(0, 0).z, std::sqrt(3.0), 1e-5);  // half of the colour cast is left
}

}  // namespace
}  // namespace sandglass::host

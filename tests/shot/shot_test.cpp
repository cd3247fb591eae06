// The shot's pictures against closed forms: where things appear, what an even room must give, and whose side shadows
// are on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "models/host/mesh/generated.h"
#include "models/host/mesh/ray_caster.h"
#include "models/shot/shot.h"
#include "models/shot/shot_camera.h"
#include "models/shot/shot_picture.h"
#include "models/shot/surroundings.h"

namespace {

using namespace sandglass::host;

constexpr double k_pi = std::numbers::pi;

Camera camera() {
  Camera c;
  c.eye = {0, 1.5, 2}, c.target = {0, 0.2, 0}, c.fov_deg = 45;
  return c;
}

// A cube of half a metre on the floor.
Mesh cube() {
  const float size[3] = {0.5f, 0.5f, 0.5f};
  Mesh mesh = make_box(size);
  float low = 1e9f;
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) low = std::min(low, mesh.vertices[i]);
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) mesh.vertices[i] -= low;
  return mesh;
}

// An even panorama with one bright patch of 10 degrees at a direction.
RadianceMap lamp_room(Vec3 towards, double bright) {
  RadianceMap map(256, 128);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) {
      const double cosine = dot(panorama_direction(u, v, map.width, map.height), normalised(towards));
      map.set(u, v, cosine > std::cos(10 * k_pi / 180) ? Vec3{bright, bright, bright} : Vec3{0.2, 0.2, 0.2});
    }
  return map;
}

TEST(ShotCamera, TurnsWithoutMovingAndKeepsItsAxes) {
  ShotTrack track;
  track.turn_deg = 90, track.sway_deg = 1;
  const ShotCamera rest = resting_camera(camera());
  for (int frame = 0; frame <= 100; ++frame) {
    const ShotCamera held = held_camera(camera(), track, 0.02 * frame, frame / 100.0);
    EXPECT_NEAR(length(held.eye - rest.eye), 0, 1e-12);
    EXPECT_NEAR(dot(held.right, held.up), 0, 1e-12);
    EXPECT_NEAR(length(cross(held.right, held.forward) - held.up), 0, 1e-12) << "right-handed, y up";
    // What the camera is told in its own axes is the world's, whichever way it looks: a light stands still.
    const Vec3 light = normalised(Vec3{0.3, 0.8, -0.4});
    EXPECT_NEAR(length(held.to_scene(held.to_camera(light)) - light), 0, 1e-12);
  }
  const ShotCamera first = held_camera(camera(), track, 0, 0), last = held_camera(camera(), track, 2, 1);
  EXPECT_NEAR(std::acos(dot(normalised(Vec3{first.forward.x, 0, first.forward.z}),
                            normalised(Vec3{last.forward.x, 0, last.forward.z}))) *
                  180 / k_pi,
              90, 2.5);
  // A lamp on the right has camera x > 0, one above y < 0.
  EXPECT_GT(rest.to_camera(rest.right).x, 0.99);
  EXPECT_LT(rest.to_camera({0, 1, 0}).y, -0.5);
}

TEST(Surroundings, AzimuthIsWhereTheCameraLooks) {
  // A patch at azimuth 200 degrees of the panorama: looked at, it is in the middle of the picture.
  const double azimuth = 200 * k_pi / 180;
  const Camera c = [] {
    Camera level;
    level.eye = {0, 1.5, 2}, level.target = {0, 1.5, 0};
    return level;
  }();
  const Surroundings room =
      panorama_surroundings(lamp_room({std::cos(azimuth), 0, std::sin(azimuth)}, 50), "lamp", c, 200, {0, 0, 0}, 0.8);
  const ShotCamera rest = resting_camera(c);
  EXPECT_GT(room.seen(rest, rest.forward).x, 0.5);
  EXPECT_LT(room.seen(rest, rest.forward + rest.right).x, 0.3);
  EXPECT_LT(room.seen(rest, rest.forward * -1.0).x, 0.3);
}

TEST(Surroundings, LabelsPointAtTheLampAndAreWhatTheFloorReceives) {
  const Vec3 lamp = normalised(Vec3{1, 1.2, 0.3});
  const Surroundings room = panorama_surroundings(lamp_room(lamp, 50), "lamp", camera(), -90, {0, 0, 0}, 0.0);
  const ShotLight light = labelled_light(room);
  EXPECT_GT(dot(light.towards, lamp), std::cos(2 * k_pi / 180));
  // Directional share of the level floor's irradiance.
  const double direct = luminance(light.light) * light.towards.y, all = direct + luminance(light.ambient);
  EXPECT_NEAR(direct / all, std::min(light.contrast, 0.95), 1e-6);
}

#ifdef SANDGLASS_HAVE_EMBREE

double mean_of(const RadianceMap& map, int x0, int y0, int x1, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += luminance(map.colour(x, y));
  return sum / ((x1 - x0) * (y1 - y0));
}

// In a room of equal radiance everywhere a convex object of reflectance rho far from the floor's influence looks rho as
// bright, and the floor far from it as bright as the room.
TEST(ShotTruth, AnEvenRoomStaysEven) {
  RadianceMap even(64, 32);
  for (float& value : even.rgb) value = 0.5f;
  const Surroundings room = panorama_surroundings(even, "even", camera(), -90, {0, 0, 0}, 0.8);
  const ShotPicture picture(cube(), {}, 0.001f);
  ShotPictureOptions o;
  o.width = 80, o.height = 60, o.paths = 64;
  const RadianceMap truth = picture.truth(room, resting_camera(camera()), o);
  const double white = tone_mapped_luminance(0.5, 0.5);  // of the room itself
  EXPECT_NEAR(mean_of(truth, 0, 0, 80, 8), white, 1e-3) << "the wall behind";
  EXPECT_NEAR(mean_of(truth, 0, 24, 6, 34), white, 0.05) << "the floor beside";
  // The top of the cube sees nothing but the room: radiance rho * 0.5.
  const ShotCamera rest = resting_camera(camera());
  const Vec3 to = Vec3{0, 0.5, 0} - rest.eye;
  const double depth = dot(to, rest.forward);
  const int x = static_cast<int>(40 + 60 * rest.focal * dot(to, rest.right) / depth);
  const int y = static_cast<int>(30 - 60 * rest.focal * dot(to, rest.up) / depth);
  const Vec3 top = tone_mapped(Vec3{0.60, 0.44, 0.30} * 0.5, 0.5);
  EXPECT_NEAR(mean_of(truth, x - 3, y - 1, x + 4, y + 2), luminance(top), 0.05 * luminance(top));
}

TEST(ShotTruth, ShadowsFallAwayFromTheLampInBothPictures) {
  for (const double side : {-1.0, 1.0}) {
    const Surroundings room =
        panorama_surroundings(lamp_room({side, 1, 0}, 200), "lamp", camera(), -90, {0, 0, 0}, 0.0);
    const ShotPicture picture(cube(), {}, 0.001f);
    ShotPictureOptions o;
    o.width = 64, o.height = 48, o.paths = 32;
    const ShotCamera rest = resting_camera(camera());
    const RadianceMap truth = picture.truth(room, rest, o);
    const RadianceMap hard = picture.composite(room, rest, labelled_light(room), {}, CastShadow::hard, o);
    for (const RadianceMap* map : {&truth, &hard}) {
      const double left = mean_of(*map, 12, 22, 20, 32), right = mean_of(*map, 44, 22, 52, 32);
      if (side > 0) EXPECT_LT(left, 0.8 * right);
      else EXPECT_LT(right, 0.8 * left);
    }
  }
}

#endif

}  // namespace

// The shot's pictures against closed forms: where things appear, what an even room must give, on which side shadows
// fall and how dark they are. A shadow stays where it is while the camera turns.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <span>

#include "models/compositing/shot.h"
#include "models/compositing/shot_camera.h"
#include "models/compositing/shot_picture.h"
#include "models/compositing/surroundings.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/lighting/room_light.h"
#include "models/mesh/generated.h"
#include "models/mesh/ply.h"
#include "models/rooms/panorama_file.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"
#include "tests/temporary_folder.h"

namespace {

using namespace sandglass::host;
using Folder = sandglass::tests::TemporaryFolder;

constexpr double k_pi = std::numbers::pi;

Camera camera() {
  Camera c;
  c.eye = {0, 1.5, 2}, c.target = {0, 0.2, 0}, c.fov_deg = 45;
  return c;
}

// An even panorama with one bright patch of 10 degrees in the given direction.
RadianceMap lamp_room(Vec3 towards, double bright, double even = 0.2) {
  RadianceMap map(256, 128);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) {
      const double cosine = dot(panorama_direction(u, v, map.width, map.height), normalised(towards));
      map.set(u, v, cosine > std::cos(10 * k_pi / 180) ? Vec3{bright, bright, bright} : Vec3{even, even, even});
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
    // A light that is turned into the camera's axes and back is the same, whichever way the camera looks.
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
  // A camera that looks at a patch at azimuth 200 degrees has it in the middle of the picture.
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
  // The directional share of the level floor's irradiance.
  const double direct = luminance(light.light) * light.towards.y, all = direct + luminance(light.ambient);
  // The mean direction of a round patch of 10 degrees has the length (1 + cos 10) / 2.
  EXPECT_NEAR(light.contrast, direct / all * 0.5 * (1 + std::cos(10 * k_pi / 180)), 2e-3);
}

// Two equal lamps, 40 degrees from the zenith on opposite sides. The estimated direction is up, and only the part of
// their light that a lamp there would give casts a shadow.
TEST(Surroundings, LampsOnTwoSidesCastAWeakerShadow) {
  const double polar = 40 * k_pi / 180;
  RadianceMap map = lamp_room({std::sin(polar), std::cos(polar), 0}, 50);
  const RadianceMap other = lamp_room({-std::sin(polar), std::cos(polar), 0}, 50);
  for (size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = std::max(map.rgb[i], other.rgb[i]);
  const ShotLight light = labelled_light(panorama_surroundings(std::move(map), "lamps", camera(), -90, {0, 0, 0}, 0.0));
  EXPECT_GT(light.towards.y, 0.999);
  const double bright = luminance(light.light) * light.towards.y, all = bright + luminance(light.ambient);
  const double spread = 0.5 * (1 + std::cos(10 * k_pi / 180)) * std::cos(polar);
  EXPECT_NEAR(light.contrast, bright / all * spread, 5e-3);
}

TEST(Surroundings, ToneCurveHasAnInverse) {
  for (const double white : {0.3, 1.0, 20.0, 5e4})
    for (double l = 1e-6; l < white; l *= 1.7) {
      EXPECT_NEAR(radiance_of_luminance(tone_mapped_luminance(l, white), white), l, 1e-9 * l + 1e-15) << white;
      const Vec3 colour = {1.3 * l, 0.9 * l, 0.4 * l}, back = radiance_of(tone_mapped(colour, white), white);
      EXPECT_NEAR(length(back - colour), 0, 1e-9 * l);
    }
  EXPECT_EQ(length(radiance_of({}, 5)), 0);
}

// In each colour, the opacity is the irradiance of the level floor by the light, divided by all of its irradiance.
TEST(Surroundings, OpacityIsTheLightsShareOfEachColour) {
  ShotLight light;
  light.contrast = 0.6;
  light.light = {3, 2, 1}, light.ambient = {0.1, 0.2, 0.5};
  const Vec3 o = shadow_opacity(light);
  // Irradiances with luminances in the ratio 0.6 to 0.4.
  const Vec3 direct = light.light * (0.6 / luminance(light.light)),
             rest = light.ambient * (0.4 / luminance(light.ambient));
  EXPECT_NEAR(o.x, direct.x / (direct.x + rest.x), 1e-12);
  EXPECT_NEAR(o.y, direct.y / (direct.y + rest.y), 1e-12);
  EXPECT_NEAR(o.z, direct.z / (direct.z + rest.z), 1e-12);
  EXPECT_NEAR(luminance(product(direct + rest, o)), 0.6, 1e-12) << "over all colours it must be the contrast";
  EXPECT_GT(o.x, o.z + 0.3) << "the shadow of a warm light must be bluer";
  light.ambient = light.light * 0.2;
  EXPECT_NEAR(length(shadow_opacity(light) - Vec3{0.6, 0.6, 0.6}), 0, 1e-12)
      << "light of one hue must have one opacity";
  light.contrast = 0;
  EXPECT_EQ(length(shadow_opacity(light)), 0);
  light.contrast = 1;
  EXPECT_NEAR(length(shadow_opacity(light) - Vec3{1, 1, 1}), 0, 1e-12);
}

// A photograph of 100 rows, red above and blue below, appears with its horizon where its field of view puts it. A wide
// one is shown in full height, a high one in full width.
TEST(Surroundings, PhotographsKeepTheirFieldOfView) {
  const Folder folder;
  for (const int width : {133, 220, 60}) {
    Picture photo(width, 100, {0, 0, 200});
    fill_rectangle(&photo, 0, 0, width, 30, {200, 0, 0});
    write_png(folder / "photo.png", photo);
    Camera c = camera();
    const double fov_deg = 70;
    const Surroundings room = photo_surroundings(folder / "photo.png", fov_deg, &c);
    EXPECT_FALSE(room.has_truth());
    const double focal = 0.5 * std::hypot(width, 100) / std::tan(fov_deg * k_pi / 360);
    EXPECT_NEAR(2 * std::atan(0.5 * std::min(100.0, 0.75 * width) / focal), c.fov_deg * k_pi / 180, 1e-9) << width;
    const ShotCamera rest = resting_camera(c);
    // The border between the colours is 20 pixels above the middle.
    for (const double off : {-2.0, 2.0}) {
      const Vec3 seen = room.seen(rest, rest.forward * focal + rest.up * (20 + off));
      EXPECT_GT(off > 0 ? seen.x - seen.z : seen.z - seen.x, 0.5) << width;
    }
    // The picture's upper edge is within the photograph.
    const double edge = 0.5 * std::min(100.0, 0.75 * width);
    EXPECT_LE(edge, 50.0);
    const Vec3 top = room.seen(rest, rest.ray(80, 0.01, 160, 120));
    EXPECT_GT(edge > 20 ? top.x - top.z : top.z - top.x, 0.5) << width;
  }
}

SceneFile shot_scene() { return load_scene("shot"); }

// A camera turns by 90 degrees. The light in its own axes turns with it; the shadow in the world must not.
TEST(Shot, TheShadowDoesNotSwimWhileTheCameraTurns) {
  const Folder folder;
  const Vec3 lamp = normalised(Vec3{0.5, 1.0, 0.4});
  write_hdr(folder / "lamp.hdr", lamp_room(lamp, 50));
  SceneFile scene = shot_scene();
  scene.shot->turn_deg = 90, scene.shot->sway_deg = 1, scene.frames = 40;
  ShotOptions options;
  options.panorama = folder / "lamp.hdr", options.light = LightSource::labels;
  Shot shot(scene, options);
  const auto textures_of = [&](Vec3 towards) {
    StandingShadows standing(scene, SANDGLASS_ISA_AUTOMATIC);
    standing.set_light(scene, 0, towards);
    sandglass_shadow_run(standing.handles().data(), static_cast<uint32_t>(standing.handles().size()), ~0u);
    return standing.drawn(colliders_over_frame(scene, 0));
  };
  const auto same = [](const FloorShadow& a, const FloorShadow& b) {
    return a.coverage == b.coverage && std::equal(a.low, a.low + 2, b.low) && std::equal(a.high, a.high + 2, b.high) &&
           a.opacity == b.opacity;
  };
  shot.begin(0);
  const Vec3 first = shot.light(0).towards;
  EXPECT_GT(shot.surroundings().view.theta, 0);
  const std::vector<FloorShadow> before = textures_of(first);
  Vec3 swimming;
  for (uint32_t frame = 1; frame <= scene.frames; ++frame) {
    shot.begin(frame);
    EXPECT_LT(length(shot.light(frame).towards - first), 1e-12) << frame;
    swimming = resting_camera(*scene.camera).to_scene(shot.camera(frame).to_camera(first));
  }
  EXPECT_GT(std::acos(dot(normalised(shot.camera(0).forward), normalised(shot.camera(scene.frames).forward))),
            60 * k_pi / 180);
  EXPECT_TRUE(same(before[0], textures_of(shot.light(scene.frames).towards)[0]));
  // Controls: a light that turns with the camera, or a lamp at another place, gives other textures.
  EXPECT_FALSE(same(before[0], textures_of(swimming)[0]));
  EXPECT_FALSE(same(before[0], textures_of(normalised(first + Vec3{0.1, 0, 0}))[0]));
}

// A shot in a room with one lamp. The shipped network estimates its light, once a frame.
struct EstimatedTurn {
  static constexpr double k_between = 0.25;  // seconds: the light's default interval
  Folder folder;
  SceneFile scene = shot_scene();
  std::unique_ptr<Shot> shot;
  EstimatedTurn(double turn_deg, uint32_t estimates) {
    write_hdr(folder / "lamp.hdr", lamp_room({0.5, 1.0, 0.4}, 50));
    scene.shot->turn_deg = turn_deg, scene.shot->sway_deg = 1;
    scene.frames = estimates, scene.frame_step = k_between;
    ShotOptions options;
    options.panorama = folder / "lamp.hdr", options.light = LightSource::estimate;
    shot = std::make_unique<Shot>(scene, options);
  }
  // Estimates the light of the frame's image. Returns the light that the app then has, and what the network itself
  // said.
  FollowedLight follow(uint32_t frame) {
    shot->begin(frame);
    uint32_t taken = 0;
    EXPECT_EQ(sandglass_light_set_image(shot->estimator(), shot->image(), &taken, nullptr), SANDGLASS_OK);
    EXPECT_EQ(taken, 1u) << frame;
    while (sandglass_light_run(shot->estimator(), 1000) != 0) {
    }
    FollowedLight light = {};
    light.filtered.struct_size = light.latest.struct_size = sizeof(sandglass_light_estimate);
    sandglass_light_get(shot->estimator(), &light.filtered);
    sandglass_light_get_latest(shot->estimator(), &light.latest);
    return light;
  }
};

Vec3 direction_of(const sandglass_light_estimate& e) { return {e.direction[0], e.direction[1], e.direction[2]}; }
double between_deg(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / k_pi; }
constexpr double k_step_limit_deg = 30;  // the filter's documented limit for one estimate

// The filter's law (light.h): a step goes the share a of the way from the light to the newest estimate, both in the
// world. A control that leaves out the pose, so that estimates are in the camera's axes, breaks the law.
TEST(Shot, AnEstimatedLightFollowsTheFiltersLawWhileTheCameraTurns) {
  if (shipped_light_network().empty()) GTEST_SKIP() << "no lighting network";
  EstimatedTurn turn(90, 18);
  const ShotCamera rest = resting_camera(*turn.scene.camera);
  constexpr double k_share = EstimatedTurn::k_between / (0.4 + EstimatedTurn::k_between), k_outlier_deg = 40;
  Vec3 before;
  double greatest = 0, off_without_pose = 0;
  for (uint32_t frame = 0; frame <= turn.scene.frames; ++frame) {
    const FollowedLight light = turn.follow(frame);
    const Vec3 now = direction_of(light.filtered), said = direction_of(light.latest);
    if (frame > 0) {
      EXPECT_NEAR(between_deg(turn.shot->light(frame).towards, before), 0, 1e-3) << "the light that the frame has";
      const double share = std::max(k_share, 1.0 / (1 + frame)), step = between_deg(now, before);
      const auto expected = [&](Vec3 newest) {
        return std::min(k_step_limit_deg, share * between_deg(newest, before));
      };
      ASSERT_LT(between_deg(said, before), k_outlier_deg) << "no estimate may be rejected here";
      EXPECT_NEAR(step, expected(said), 0.02) << frame;
      EXPECT_LE(step, k_step_limit_deg) << frame;
      const Vec3 without_pose = rest.to_scene(turn.shot->camera(frame).to_camera(said));
      off_without_pose = std::max(off_without_pose, std::fabs(step - expected(without_pose)));
      greatest = std::max(greatest, step);
    }
    before = now;
  }
  EXPECT_GT(greatest, 0.5) << "the estimates must move at all";
  EXPECT_GT(off_without_pose, 3.0);
}

// A camera turns round between one image and the next. An app that filters in the camera's axes and turns the result
// swings its light round.
TEST(Shot, AnEstimatedLightIsNotSwungRoundByTheCamera) {
  if (shipped_light_network().empty()) GTEST_SKIP() << "no lighting network";
  EstimatedTurn turn(540, 3);
  RoomLight alone(shipped_light_network(), true);
  sandglass_camera_image first = {};
  Vec3 before, swung_before;
  double step = 0, swung_step = 0;
  for (uint32_t frame = 0; frame <= turn.scene.frames; ++frame) {
    const Vec3 now = direction_of(turn.follow(frame).filtered);
    sandglass_camera_image image = *turn.shot->image();
    if (frame == 0) first = image;
    std::copy_n(first.orientation, 4, image.orientation);
    const Vec3 left = direction_of(alone.follow(image).filtered);
    const Vec3 swung = turn.shot->camera(frame).to_scene(turn.shot->camera(0).to_camera(left));
    if (frame > 0) step = std::max(step, between_deg(now, before));
    if (frame > 0) swung_step = std::max(swung_step, between_deg(swung, swung_before));
    before = now, swung_before = swung;
  }
  EXPECT_LE(step, k_step_limit_deg);
  EXPECT_GT(swung_step, k_step_limit_deg);
}

#ifdef SANDGLASS_HAVE_EMBREE

// A cube of half a metre on the floor.
Mesh cube() {
  const float size[3] = {0.5f, 0.5f, 0.5f};
  Mesh mesh = make_box(size);
  float low = 1e9f;
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) low = std::min(low, mesh.vertices[i]);
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) mesh.vertices[i] -= low;
  return mesh;
}

double mean_of(const RadianceMap& map, int x0, int y0, int x1, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += luminance(map.colour(x, y));
  return sum / ((x1 - x0) * (y1 - y0));
}

// In a room of equal radiance everywhere, a convex object of reflectance rho that the floor does not influence has rho
// times the radiance. The floor far from it is as bright as the room.
TEST(ShotTruth, AnEvenRoomStaysEven) {
  RadianceMap even(64, 32);
  for (float& value : even.rgb) value = 0.5f;
  const Surroundings room = panorama_surroundings(even, "even", camera(), -90, {0, 0, 0}, 0.8);
  const ShotPicture picture(cube(), {}, 0.001f);
  ShotPictureOptions o;
  o.width = 80, o.height = 60, o.paths = 64;
  const RadianceMap truth = picture.truth(room, resting_camera(camera()), o);
  const double white = tone_mapped_luminance(0.5, 0.5);  // the radiance of the room
  EXPECT_NEAR(mean_of(truth, 0, 0, 80, 8), white, 1e-3) << "the wall behind";
  EXPECT_NEAR(mean_of(truth, 0, 24, 6, 34), white, 0.05) << "the floor beside";
  // The top of the cube sees only the room: radiance rho * 0.5.
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

// The camera's tone curve makes the estimated light darker. Object and grain reflect the light before that curve, and
// are then shown through it. With ambient light alone, which is even here, this has a closed form and equals the path
// tracing.
TEST(ShotComposite, ObjectAndGrainsGoThroughTheToneCurve) {
  const double even = 1.0;
  RadianceMap map(256, 128);
  for (float& value : map.rgb) value = static_cast<float>(even);
  map.set(0, 0, {100, 100, 100});  // white, and too small to count as the light
  const Surroundings room = panorama_surroundings(map, "even", camera(), -90, {0, 0, 0}, 0.0);
  ASSERT_EQ(room.white, 100.0);
  const float grain[3] = {0.4f, 0.6f, 0.4f};
  const ShotPicture picture(cube(), grain, 0.1f);
  ShotPictureOptions o;
  o.width = 80, o.height = 60, o.paths = 256;
  const ShotCamera rest = resting_camera(camera());
  ShotLight light;
  light.ambient = tone_mapped({even, even, even}, room.white);
  EXPECT_NEAR(luminance(light.ambient), 0.5, 1e-3) << "Reinhard's curve takes half of 1";
  const RadianceMap made = picture.composite(room, rest, light, {}, CastShadow::textures, o),
                    plain = picture.composite(room, rest, light, {}, CastShadow::no_curve, o),
                    truth = picture.truth(room, rest, o);
  const auto at = [&](const RadianceMap& of, Vec3 place) {
    const Vec3 to = place - rest.eye;
    const double depth = dot(to, rest.forward);
    const int x = static_cast<int>(40 + 60 * rest.focal * dot(to, rest.right) / depth);
    const int y = static_cast<int>(30 - 60 * rest.focal * dot(to, rest.up) / depth);
    return mean_of(of, x - 1, y - 1, x + 2, y + 1);
  };
  struct {
    Vec3 place, reflectance;
  } const seen[] = {{{0, 0.5, 0}, {0.60, 0.44, 0.30}}, {{0.4, 0.6, 0.4}, grain_colour(0)}};
  for (const auto& [place, reflectance] : seen) {
    const double expected = luminance(tone_mapped(reflectance * even, room.white));
    EXPECT_NEAR(at(made, place), expected, 1e-3);
    EXPECT_NEAR(at(truth, place), expected, 0.06 * expected) << "half of what the grain sees is the floor";
    EXPECT_NEAR(at(plain, place), luminance(reflectance) * 0.5 * even, 1e-3);
    EXPECT_LT(at(plain, place), 0.8 * expected);
  }
}

// Two grains touch and are lit from the horizon, along the line between their centres. The nearer one takes all light
// from the other, though the shadow textures know no light that low.
TEST(ShotComposite, GrainsShadeTheirNeighboursInEveryLight) {
  const float grains[6] = {0, 0.8f, 0, 0.01f, 0.8f, 0};  // above the cube
  ShotPictureOptions o;
  o.width = 40, o.height = 40;
  Camera close = camera();
  close.eye = {0.005, 0.8, 1}, close.target = {0.005, 0.8, 0}, close.fov_deg = 1.6;  // 28 mm high
  const ShotCamera rest = resting_camera(close);
  const Surroundings room = panorama_surroundings(lamp_room({1, 0, 0}, 50), "lamp", close, -90, {0, 0, 0}, 0.0);
  ShotLight light;
  light.light = {1, 1, 1}, light.towards = {1, 0, 0};
  const auto lit = [&](std::span<const float> of) {
    const RadianceMap map = ShotPicture(cube(), of, 0.005f).composite(room, rest, light, {}, CastShadow::textures, o);
    // The left grain where it meets the other: hardly a ray of 20 degrees passes.
    return mean_of(map, 18, 18, 20, 22);
  };
  const double alone = lit(std::span(grains, 3));
  EXPECT_GT(alone, 0.1);
  EXPECT_LT(lit(grains), 0.05 * alone);
}

// The luminance, interpolated bilinearly.
double between(const RadianceMap& map, double x, double y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const auto at = [&](int i, int k) { return luminance(map.colour(u + i, v + k)); };
  return (at(0, 0) * (u + 1 - x) + at(1, 0) * (x - u)) * (v + 1 - y) +
         (at(0, 1) * (u + 1 - x) + at(1, 1) * (x - u)) * (y - v);
}

// A plate hides a lamp overhead but little else. The floor under it is as dark in the composite as in the path tracing.
// If the contrast were multiplied onto what the camera shows, it would be too dark, because of the tone curve.
TEST(ShotComposite, AnUmbraIsAsDarkAsTraced) {
  const Surroundings room =
      panorama_surroundings(lamp_room({0, 1, 0}, 100, 1.0), "lamp", camera(), -90, {0, 0, 0}, 0.0);
  const ShotLight light = labelled_light(room);
  const double lamp = 100 * std::pow(std::sin(10 * k_pi / 180), 2), rest = 1 - std::pow(std::sin(10 * k_pi / 180), 2);
  EXPECT_NEAR(light.contrast, lamp / (lamp + rest), 0.02) << "the patch has square pixels";
  const float size[3] = {0.32f, 0.01f, 0.32f};
  Mesh plate = make_box(size);
  for (size_t i = 1; i < plate.vertices.size(); i += 3) plate.vertices[i] += 0.8f;
  const ShotPicture picture(plate, {}, 0.001f);
  ShotPictureOptions o;
  o.width = 80, o.height = 60, o.paths = 512, o.threads = 2;
  Camera c = camera();
  c.target = {0, 0, 0}, c.fov_deg = 10;  // a pixel covers half a centimetre of the floor
  const ShotCamera rest_camera = resting_camera(c);
  const double truth = mean_of(picture.truth(room, rest_camera, o), 39, 29, 42, 32);
  const auto made = [&](CastShadow cast, const ShotShadows& shadows) {
    return mean_of(picture.composite(room, rest_camera, light, shadows, cast, o), 39, 29, 42, 32);
  };
  FloorShadow whole;
  whole.texels = 2, whole.coverage.assign(4, 255), whole.half_angle = 0.17;
  whole.low[0] = whole.low[1] = -5, whole.high[0] = whole.high[1] = 5;
  const double umbra = tone_mapped_luminance(1 - light.contrast, room.white);
  EXPECT_NEAR(made(CastShadow::none, {}), tone_mapped_luminance(1, room.white), 1e-3);
  EXPECT_NEAR(made(CastShadow::hard, {}), umbra, 1e-3);
  EXPECT_NEAR(made(CastShadow::textures, {{whole}, {}, {}}), umbra, 1e-3);
  EXPECT_NEAR(truth, umbra, 0.02);
  EXPECT_LT(made(CastShadow::no_curve, {{whole}, {}, {}}), truth - 0.05);
}

// Two cameras that look in directions 30 degrees apart see the shadow at the same place of the floor: a point of the
// floor loses the same light in both. With a light that turns with the camera it does not.
TEST(ShotComposite, TheShadowStaysOnTheFloorWhileTheCameraTurns) {
  const SceneFile scene = shot_scene();
  const Mesh object = standing_object(scene, "");
  const ShotPicture picture(object, {}, 0.001f);
  ShotPictureOptions o;
  o.width = 320, o.height = 240, o.threads = 2;
  const Surroundings room =
      panorama_surroundings(lamp_room({0.5, 1, 0.4}, 50), "lamp", *scene.camera, 270, {0, 0, 0}, 0.0);
  const ShotLight light = labelled_light(room);
  ShotTrack track;
  track.turn_deg = 30, track.sway_deg = 0;
  const ShotCamera cameras[] = {held_camera(*scene.camera, track, 0, 0), held_camera(*scene.camera, track, 0, 1)};
  const auto left = [&](const ShotCamera& held, Vec3 towards) {
    StandingShadows standing(scene, SANDGLASS_ISA_AUTOMATIC);
    standing.set_light(scene, 0, towards);
    sandglass_shadow_run(standing.handles().data(), static_cast<uint32_t>(standing.handles().size()), ~0u);
    const ShotShadows shadows = {standing.drawn(colliders_over_frame(scene, 0)), {}, {}};
    const RadianceMap with = picture.composite(room, held, light, shadows, CastShadow::textures, o),
                      without = picture.composite(room, held, light, shadows, CastShadow::none, o);
    // As a share of the light that the point has without the shadow.
    return [=](double x, double z) {
      const Vec3 to = Vec3{x, 0, z} - held.eye;
      const double depth = dot(to, held.forward);
      const double u = 160 + 240 * held.focal * dot(to, held.right) / depth - 0.5,
                   v = 120 - 240 * held.focal * dot(to, held.up) / depth - 0.5;
      if (u < 0 || v < 0 || u >= 319 || v >= 239) return -1.0;
      return between(with, u, v) / between(without, u, v);
    };
  };
  const auto first = left(cameras[0], light.towards), second = left(cameras[1], light.towards);
  const auto swimming = left(cameras[1], cameras[0].to_scene(cameras[1].to_camera(light.towards)));
  double apart = 0, swum = 0, darkest = 1;
  int points = 0;
  for (double x = -1.2; x < 0.6; x += 0.02)
    for (double z = -1.0; z < 0.5; z += 0.02) {
      const double a = first(x, z), b = second(x, z), c = swimming(x, z);
      if (a < 0 || b < 0 || a > 0.97) continue;  // not seen by both, or lit
      apart += std::fabs(a - b), swum += std::fabs(a - c), ++points;
      darkest = std::min(darkest, a);
    }
  ASSERT_GT(points, 300);
  RecordProperty("apart", std::to_string(apart / points));
  RecordProperty("swum", std::to_string(swum / points));
  EXPECT_LT(darkest, 0.6);
  EXPECT_LT(apart / points, 0.01);
  EXPECT_GT(swum / points, 0.05);
}

// A mesh from a file with the shadow baked from it: the program's own chair, written and read again.
TEST(Shot, AnObjectFromAFileIsTheSameObject) {
#ifndef SANDGLASS_HAVE_ASSIMP
  GTEST_SKIP() << "this build has no Assimp, which reads mesh files";
#endif
  const Folder folder;
  const MeshResult chair = make_named("chair");
  ASSERT_TRUE(chair) << chair.error;
  ASSERT_EQ(write_mesh_obj(folder / "chair.obj", chair.mesh), "");
  const SceneFile scene = shot_scene();
  const Mesh named = standing_object(scene, ""), read = standing_object(scene, folder / "chair.obj");
  ShotPictureOptions o;
  o.width = 64, o.height = 48;
  const Surroundings room =
      panorama_surroundings(lamp_room({0.5, 1, 0.4}, 50), "lamp", *scene.camera, 270, {0, 0, 0}, 0.0);
  RadianceMap pictures[2];
  for (const bool file : {false, true})
    pictures[file] = ShotPicture(file ? read : named, {}, 0.001f)
                         .composite(room, resting_camera(*scene.camera), labelled_light(room), {}, CastShadow::hard, o);
  EXPECT_LT(shot_errors(pictures[0], pictures[1]).image.rmse, 2e-3);
  // Another shape has another shadow.
  Mesh wide = chair.mesh;
  for (size_t i = 0; i < wide.vertices.size(); i += 3) wide.vertices[i] *= 1.2f;
  ASSERT_EQ(write_mesh_obj(folder / "wide.obj", wide), "");
  EXPECT_THROW(standing_object(scene, folder / "wide.obj"), Failure);
}

#endif

}  // namespace

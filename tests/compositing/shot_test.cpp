// The shot's pictures against closed forms: where things appear, what an even room must give, on which side shadows
// fall and how dark they are. A shadow stays where it is while the camera turns.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/compositing/shot.h"
#include "models/compositing/shot_camera.h"
#include "models/compositing/shot_picture.h"
#include "models/compositing/surroundings.h"
#include "models/files/image.h"
#include "models/mesh/generated.h"
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
  c.eye = {0, 1.5, 2};
  c.target = {0, 0.2, 0};
  c.fov_deg = 45;
  return c;
}

// An even panorama with one bright patch of 10 degrees in the given direction.
RadianceMap lamp_room(Vec3 towards, double bright, double even = 0.2) {
  return panorama_of(256, 128, [&](Vec3 d) {
    return Vec3{1, 1, 1} * (dot(d, normalised(towards)) > std::cos(10 * k_pi / 180) ? bright : even);
  });
}

TEST(ShotCamera, TurnsWithoutMovingAndKeepsItsAxes) {
  ShotTrack track;
  track.turn_deg = 90;
  track.sway_deg = 1;
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
    level.eye = {0, 1.5, 2};
    level.target = {0, 1.5, 0};
    return level;
  }();
  const Surroundings room =
      panorama_surroundings(lamp_room({std::cos(azimuth), 0, std::sin(azimuth)}, 50), "lamp", c, 200, {0, 0, 0}, 0.8);
  const ShotCamera rest = resting_camera(c);
  const double ahead = room.seen(rest, rest.forward).x;
  EXPECT_GT(ahead, 0.2);
  EXPECT_LT(room.seen(rest, rest.forward + rest.right).x, 0.5 * ahead);
  EXPECT_LT(room.seen(rest, rest.forward * -1.0).x, 0.5 * ahead);
}

// An even room gives every cell the same, and a white surface is as bright as it, whichever way it faces.
TEST(ShotLight, OfAnEvenRoomIsEven) {
  RadianceMap even(128, 64);
  for (float& value : even.rgb) value = 0.4f;
  const ShotLight light = light_of(even, {k_pi / 2, 0.7});
  for (const float p : light.cells) EXPECT_NEAR(p, 1.0 / SANDGLASS_LIGHT_CELLS, 1e-3);
  EXPECT_NEAR(luminance(irradiance_of(light)), 0.4 * k_pi, 2e-3);
  for (const Vec3 n : {Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{1, 0, 0}, Vec3{0, 0.6, -0.8}})
    EXPECT_NEAR(luminance(shown_by(light, n)), 0.4, 1e-3);
}

// A lamp's cell holds its share, the middle of the light is towards it, and a surface that faces it is the brightest.
TEST(ShotLight, OfALampIsWhereTheLampIs) {
  const Vec3 lamp = normalised(Vec3{0.5, 1.0, 0.4});
  const ShotLight light = light_of(lamp_room(lamp, 400), {k_pi / 2, k_pi / 2});
  EXPECT_GT(dot(mean_direction_of(light), lamp), std::cos(6 * k_pi / 180));
  EXPECT_GT(luminance(shown_by(light, lamp)), 3 * luminance(shown_by(light, lamp * -1.0)));
  // What one light alone gives, by the same harmonics.
  const ShotLight sun = one_light(lamp, 1.0, irradiance_of(light));
  for (const Vec3 n : {lamp, Vec3{0, 1, 0}, Vec3{1, 0, 0}})
    EXPECT_NEAR(luminance(main_in_harmonics(sun, n)), luminance(shown_by(sun, n)),
                0.01 * luminance(shown_by(sun, lamp)));
  EXPECT_NEAR(luminance(main_by_cosine(sun, {0, 1, 0})) * k_pi, luminance(irradiance_of(light)), 1e-5);
}

TEST(ShotLight, OfAMirroredRoomIsMirrored) {
  const Vec3 lamp = normalised(Vec3{0.5, 1.0, 0.4});
  const View ahead = {k_pi / 2, k_pi / 2};
  const ShotLight made = mirrored(light_of(lamp_room(lamp, 50), ahead)),
                  real = light_of(lamp_room({lamp.x, lamp.y, -lamp.z}, 50), ahead);
  for (size_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) EXPECT_NEAR(made.cells[i], real.cells[i], 1e-4);
  for (size_t i = 0; i < 27; ++i) EXPECT_NEAR(made.sh[i], real.sh[i], 1e-3) << i;
}

// The level's mean is that of logarithms, and the shares are those of the lights, however bright each is.
TEST(ShotLight, TheMeanCountsEveryRoomTheSame) {
  const View ahead = {k_pi / 2, k_pi / 2};
  const ShotLight left = light_of(lamp_room({-1, 1, 0}, 50), ahead),
                  right = scaled(light_of(lamp_room({1, 1, 0}, 50), ahead), 100);
  const ShotLight lights[] = {left, right}, mean = mean_light(lights);
  EXPECT_NEAR(mean_direction_of(mean).x, 0, 1e-3);
  EXPECT_NEAR(luminance(irradiance_of(mean)), 10 * luminance(irradiance_of(left)), 1e-2);
  EXPECT_NEAR(luminance(shown_by(mean, {1, 0, 0})), luminance(shown_by(mean, {-1, 0, 0})), 1e-3);
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

// A phone has looked around in a room with one lamp before anything was placed, and goes on looking. Nothing jumps, and
// the shares and the level are those of the room.
TEST(Shot, LightIsKnownWhenThingsArePlacedAndDoesNotPop) {
  const Folder folder;
  write_hdr(folder / "lamp.hdr", lamp_room({0.8, 0.6, 0.4}, 20));
  SceneFile scene = shot_scene();
  ShotOptions options;
  options.panorama = folder / "lamp.hdr";
  Shot shot(scene, options);
  const ShotLight start = shot.light(0).object;
  EXPECT_GT(start.seen, 0.9f);
  EXPECT_LT(shot.angle_deg(0), 15.0);
  double step = 0;
  for (uint32_t frame = 1; frame < 220; ++frame) {
    shot.begin(frame);
    if (shot.image() != nullptr) {
      ASSERT_EQ(sandglass_room_set_image(shot.room(), shot.image(), nullptr, nullptr), SANDGLASS_OK);
    }
    for (size_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
      step = std::max(step, std::fabs(static_cast<double>(shot.light(frame).object.cells[i] -
                                                          shot.light(frame - 1).object.cells[i])));
  }
  const ShotLight &end = shot.light(219).object, &truth = shot.truth()->object;
  EXPECT_GT(end.seen, 0.9f);
  EXPECT_LT(step, 0.03) << "a share of the floor's light, in a frame of 20 ms";
  EXPECT_LT(shot.angle_deg(219), 15.0);
  EXPECT_NEAR(std::log(luminance(irradiance_of(end)) / luminance(irradiance_of(truth))), 0, 0.5);
}

// A lamp lights object and sand each from where it is from there: the room's sphere is four times as far away as the
// object was at first.
TEST(Shot, ObjectAndSandAreEachLitWhereTheyAre) {
  const Folder folder;
  write_hdr(folder / "lamp.hdr", lamp_room({0.8, 0.6, 0.4}, 20, 1e-4));
  const SceneFile scene = load_scene("carried");
  ShotOptions options;
  options.panorama = folder / "lamp.hdr";
  options.light = LightSource::truth;
  const Shot shot(scene, options);
  const RadianceMap& seen = shot.surroundings().panorama;
  Vec3 lamp;
  for (int v = 0; v < seen.height; ++v)
    for (int u = 0; u < seen.width; ++u)
      lamp = lamp + panorama_direction(u, v, seen.width, seen.height) *
                        (pixel_solid_angle(v, seen.width, seen.height) * luminance(seen.colour(u, v)));
  const Vec3 eye = scene.camera->eye;
  const Vec3 first = {-0.3, 0, 0.35}, carried = {0.18, 0, -0.85}, sand = {0.75, 0, 0.35};
  const auto expect = [&](const ShotLight& light, Vec3 place) {
    const Vec3 towards =
        normalised(normalised(lamp) * (std::hypot(first.x - eye.x, first.z - eye.z) / 0.25) - (place - eye));
    EXPECT_LT(std::acos(std::min(1.0, dot(mean_direction_of(light), towards))), 0.03);
  };
  expect(shot.light(0).object, carried);  // the truth is that of the last frame
  expect(shot.light(0).sand, sand);
  EXPECT_GT(std::acos(dot(mean_direction_of(shot.light(0).object), mean_direction_of(shot.light(0).sand))), 0.06);
}

#ifdef SANDGLASS_HAVE_EMBREE

// A cube of half a metre on the floor, which does not know what it hides from itself: nothing.
LitObject cube() {
  const float size[3] = {0.5f, 0.5f, 0.5f};
  Mesh mesh = make_box(size);
  float low = 1e9f;
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) low = std::min(low, mesh.vertices[i]);
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) mesh.vertices[i] -= low;
  return {mesh, k_no_rotation, {}};
}

double mean_of(const RadianceMap& map, int x0, int y0, int x1, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += luminance(map.colour(x, y));
  return sum / ((x1 - x0) * (y1 - y0));
}

// In an even room an object is as bright in the composite as traced, and as the closed form has it.
TEST(ShotComposite, TheObjectIsAsBrightAsTraced) {
  RadianceMap map(256, 128);
  for (float& value : map.rgb) value = 1.0f;
  const Surroundings room = panorama_surroundings(map, "even", camera(), -90, {0, 0, 0}, 0.0);
  const ShotPicture picture(cube(), {});
  ShotPictureOptions o;
  o.width = 80;
  o.height = 60;
  o.paths = 256;
  const ShotCamera rest = resting_camera(camera());
  const ShotLight even = scaled(light_above_floor(room.warped, room.view, {1, 1, 1}), room.exposure);
  const RadianceMap made = picture.composite(room, rest, even, {}, CastShadow::textures, o),
                    truth = picture.truth(room, rest, o);
  const auto at = [&](const RadianceMap& of, Vec3 place) {
    const Vec3 to = place - rest.eye;
    const double depth = dot(to, rest.forward);
    const int x = static_cast<int>(40 + 60 * rest.focal * dot(to, rest.right) / depth);
    const int y = static_cast<int>(30 - 60 * rest.focal * dot(to, rest.up) / depth);
    return mean_of(of, x - 1, y - 1, x + 2, y + 1);
  };
  const double expected = luminance({0.60, 0.44, 0.30}) * room.exposure;
  EXPECT_NEAR(at(made, {0, 0.5, 0}), expected, 0.01 * expected);
  EXPECT_NEAR(at(truth, {0, 0.5, 0}), expected, 0.06 * expected) << "half of what its sides see is the floor";
}

// The shipped chair in a room with one lamp: with the true light in cells the composite is nearer to the truth than
// without shadows, and than in the light of the mirrored room.
TEST(ShotComposite, TheRoomsLightIsNearerToTheTruthThanItsMirrorImage) {
  const SceneFile scene = shot_scene();
  const LitObject object = standing_object(scene);
  ASSERT_FALSE(object.transfer.empty()) << "the shipped chair knows what it hides from itself";
  const ShotPicture picture(object, {});
  ShotPictureOptions o;
  o.width = 120;
  o.height = 90;
  o.paths = 128;
  o.threads = 2;
  const Surroundings room =
      panorama_surroundings(lamp_room({0.6, 1, -0.5}, 40), "lamp", *scene.camera, 270, {0, 0, 0}, 0.0);
  const ShotCamera rest = resting_camera(*scene.camera);
  const RadianceMap truth = picture.truth(room, rest, o);
  const auto error = [&](const ShotLight& everywhere, CastShadow cast) {
    PlacedLight light = everywhere;
    light.reflected = room.true_reflected();
    const SceneShadows shadows =
        complete_shadows(scene, SANDGLASS_ISA_AUTOMATIC, 0, colliders_over_frame(scene, 0), {}, light);
    return shot_errors(truth, picture.composite(room, rest, light, shadows, cast, o)).rmse;
  };
  const ShotLight light = room.true_light();
  const double real = error(light, CastShadow::textures);
  EXPECT_LT(real, 0.75 * error(light, CastShadow::none));
  EXPECT_LT(real, 0.75 * error(mirrored(light), CastShadow::textures));
}

// The luminance, interpolated bilinearly.
double between(const RadianceMap& map, double x, double y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const auto at = [&](int i, int k) { return luminance(map.colour(u + i, v + k)); };
  return (at(0, 0) * (u + 1 - x) + at(1, 0) * (x - u)) * (v + 1 - y) +
         (at(0, 1) * (u + 1 - x) + at(1, 1) * (x - u)) * (y - v);
}

// A plate hides a lamp overhead but little else. The floor under it is as dark in the composite as in the path tracing.
TEST(ShotComposite, AnUmbraIsAsDarkAsTraced) {
  const Surroundings room =
      panorama_surroundings(lamp_room({0, 1, 0}, 100, 1.0), "lamp", camera(), -90, {0, 0, 0}, 0.0);
  const double lamp = 100 * std::pow(std::sin(10 * k_pi / 180), 2), rest = 1 - std::pow(std::sin(10 * k_pi / 180), 2);
  const double share = lamp / (lamp + rest);
  const ShotLight light = one_light({0, 1, 0}, share, irradiance_of(room.true_light()));
  const float size[3] = {0.32f, 0.01f, 0.32f};
  LitObject plate = {make_box(size), k_no_rotation, {}};
  for (size_t i = 1; i < plate.mesh.vertices.size(); i += 3) plate.mesh.vertices[i] += 0.8f;
  const ShotPicture picture(plate, {});
  ShotPictureOptions o;
  o.width = 80;
  o.height = 60;
  o.paths = 512;
  o.threads = 2;
  Camera c = camera();
  c.target = {0, 0, 0};  // a pixel covers half a centimetre of the floor
  c.fov_deg = 10;
  const ShotCamera rest_camera = resting_camera(c);
  const double truth = mean_of(picture.truth(room, rest_camera, o), 39, 29, 42, 32);
  const auto made = [&](CastShadow cast, const SceneShadows& shadows) {
    return mean_of(picture.composite(room, rest_camera, light, shadows, cast, o), 39, 29, 42, 32);
  };
  FloorShadow whole;
  whole.texels = 2;
  whole.coverage.assign(4, 255);
  whole.half_angle = 0.17;
  whole.low[0] = whole.low[1] = -5;
  whole.high[0] = whole.high[1] = 5;
  SceneShadows shadows;
  shadows.object = {whole};
  const double umbra = (1 - share) * room.exposure;
  EXPECT_NEAR(made(CastShadow::none, {}), room.exposure, 1e-3);
  EXPECT_NEAR(made(CastShadow::textures, shadows), umbra, 1e-3);
  EXPECT_NEAR(truth, umbra, 0.02);
}

// Ambient shadows of object and sand leave the main light's share alone, and their own parts multiply.
TEST(ShotComposite, AmbientShadowsTakeNothingOfTheMainLight) {
  const Surroundings room =
      panorama_surroundings(lamp_room({0, 1, 0}, 100, 1.0), "lamp", camera(), -90, {0, 0, 0}, 0.0);
  const ShotLight light = one_light({0, 1, 0}, 0.4, irradiance_of(room.true_light()));
  FloorShadow half;
  half.texels = 2;
  half.low[0] = half.low[1] = -5;
  half.high[0] = half.high[1] = 5;
  half.coverage.assign(4, 153);  // 0.6: all that is not the main light's
  Camera c = camera();
  c.target = {0, 0, 0};
  c.fov_deg = 10;
  const float far_below[3] = {0.1f, 0.1f, 0.1f};
  LitObject away = {make_box(far_below), k_no_rotation, {}};
  for (size_t i = 0; i < away.mesh.vertices.size(); i += 3) away.mesh.vertices[i] += 50.0f;
  ShotPictureOptions o;
  o.width = 16;
  o.height = 12;
  const auto shown = [&](const SceneShadows& shadows) {
    return mean_of(ShotPicture(away, {}).composite(room, resting_camera(c), light, shadows, CastShadow::textures, o), 6,
                   4, 10, 8) /
           room.exposure;
  };
  SceneShadows shadows;
  shadows.ambient = {half};
  EXPECT_NEAR(shown(shadows), 0.4, 2e-3);
  half.coverage.assign(4, 77);  // 0.3: half of it
  shadows.ambient = shadows.sky = {half};
  EXPECT_NEAR(shown(shadows), 0.4 + 0.6 * 0.25, 5e-3);
}

// Level sand, of two triangles that are wound as the library's are.
SandShape level_sand(float half, float height) {
  SandShape sand;
  for (int i = 0; i < 4; ++i) {
    sandglass_skin_vertex v = {};
    v.position[0] = (i & 1) != 0 ? half : -half;
    v.position[1] = height;
    v.position[2] = (i & 2) != 0 ? half : -half;
    v.normal[1] = 127;
    v.hollow = 128;
    v.over = 32767;
    sand.vertices.push_back(v);
  }
  sand.indices = {0, 2, 1, 1, 2, 3};
  return sand;
}

// Sand is as bright as the light where the sand is, whatever the object's is.
TEST(ShotComposite, SandHasItsOwnLight) {
  const Surroundings room =
      panorama_surroundings(lamp_room({0, 1, 0}, 100, 1.0), "lamp", camera(), -90, {0, 0, 0}, 0.0);
  const ShotLight light = scaled(room.true_light(), 0.05);
  Camera c = camera();
  c.target = {0, 0, 0};
  c.fov_deg = 10;
  const float size[3] = {0.1f, 0.1f, 0.1f};
  LitObject away = {make_box(size), k_no_rotation, {}};
  for (float& x : away.mesh.vertices) x += 50.0f;
  ShotPictureOptions o;
  o.width = 16;
  o.height = 12;
  const ShotPicture picture(away, level_sand(0.5f, 0.05f));
  const auto shown = [&](const PlacedLight& lights) {
    return mean_of(picture.composite(room, resting_camera(c), lights, {}, CastShadow::textures, o), 6, 4, 10, 8);
  };
  EXPECT_NEAR(shown({light, scaled(light, 0.5)}), 0.5 * shown(light), 1e-6);
  EXPECT_NEAR(shown({scaled(light, 0.5), light}), shown(light), 1e-6);
}

// Two cameras that look in directions 30 degrees apart see the shadow at the same place of the floor: a point of the
// floor loses the same light in both. With a light that turns with the camera it does not.
TEST(ShotComposite, TheShadowStaysOnTheFloorWhileTheCameraTurns) {
  const SceneFile scene = shot_scene();
  const LitObject object = standing_object(scene);
  const ShotPicture picture(object, {});
  ShotPictureOptions o;
  o.width = 320;
  o.height = 240;
  o.threads = 2;
  const Surroundings room =
      panorama_surroundings(lamp_room({0.5, 1, 0.4}, 50), "lamp", *scene.camera, 270, {0, 0, 0}, 0.0);
  const ShotLight light = one_light({0.5, 1, 0.4}, 0.8, irradiance_of(room.true_light()));
  ShotTrack track;
  track.turn_deg = 30;
  track.sway_deg = 0;
  const ShotCamera cameras[] = {held_camera(*scene.camera, track, 0, 0), held_camera(*scene.camera, track, 0, 1)};
  const auto left = [&](const ShotCamera& held, Vec3 towards) {
    StandingShadows standing(scene, SANDGLASS_ISA_AUTOMATIC);
    standing.set_light(scene, 0, towards);
    standing.complete();
    SceneShadows shadows;
    standing.draw(colliders_over_frame(scene, 0), &shadows);
    shadows.ambient.clear();
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
  const auto first = left(cameras[0], main_direction_of(light)), second = left(cameras[1], main_direction_of(light));
  const auto swimming = left(cameras[1], cameras[0].to_scene(cameras[1].to_camera(main_direction_of(light))));
  double difference = 0, swum = 0, darkest = 1;
  int points = 0;
  for (double x = -1.2; x < 0.6; x += 0.02)
    for (double z = -1.0; z < 0.5; z += 0.02) {
      const double a = first(x, z), b = second(x, z), c = swimming(x, z);
      if (a < 0 || b < 0 || a > 0.97) continue;  // not seen by both, or lit
      difference += std::fabs(a - b);
      swum += std::fabs(a - c);
      ++points;
      darkest = std::min(darkest, a);
    }
  ASSERT_GT(points, 300);
  RecordProperty("apart", std::to_string(difference / points));
  RecordProperty("swum", std::to_string(swum / points));
  EXPECT_LT(darkest, 0.6);
  EXPECT_LT(difference / points, 0.01);
  EXPECT_GT(swum / points, 0.05);
}

#endif

}  // namespace

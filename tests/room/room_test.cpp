// What a room answers in environments that are known: an even sphere, one lamp, a lamp that clips, one that goes out.
#include <cstring>
#include <string>

#include "tests/room/made_up_room.h"

namespace sandglass {
namespace {

constexpr double k_pi_double = std::numbers::pi;

uint32_t cell_at(Direction d) {
  const double turns = std::atan2(d.z, d.x) / (2 * k_pi_double);
  const auto sector = static_cast<uint32_t>((turns - std::floor(turns)) * 16) % 16;
  return 16 * std::min(3u, static_cast<uint32_t>(4 * d.y * d.y)) + sector;
}
double sum(const float (&cells)[64]) {
  double all = 0;
  for (const float c : cells) all += static_cast<double>(c);
  return all;
}

// The middle of the part that lies there, 11.25 degrees wide, so that a small lamp does not straddle four.
Direction middle_of_part(double azimuth_deg, double elevation_deg) {
  const auto snap = [](double x) { return (std::floor(x / 11.25) + 0.5) * 11.25; };
  return towards(snap(azimuth_deg), snap(elevation_deg));
}

TEST(RoomLight, NothingSeenIsAnEvenSky) {
  MadeUpRoom room;
  const sandglass_room_light light = room.light();
  EXPECT_EQ(light.valid, 0u);
  EXPECT_EQ(light.main_share, 0.0f);
  EXPECT_EQ(light.seen, 0.0f);
  for (const float c : light.cells) EXPECT_NEAR(c, 1.0 / 64, 0.001 / 64);
}

// Radiance L from everywhere gives a level floor the irradiance pi L, 1/64 of it from each cell, and the first harmonic
// 2 sqrt(pi) L; the others are 0. L is 0.4; bytes of sRGB are within 0.6 % of it.
TEST(RoomLight, AnEvenSphereIsEven) {
  MadeUpRoom room;
  room.look_everywhere([](Direction) { return 0.4; });
  const float floor[3] = {0.4f, 0.4f, 0.4f};
  for (const float x : {0.0f, 1.5f}) {  // anywhere in it
    const sandglass_room_light light = room.light(x, 0, 0, nullptr, nullptr, floor);
    EXPECT_EQ(light.valid, 1u);
    EXPECT_GT(light.seen, 0.99f);
    EXPECT_EQ(light.clipped, 0.0f);
    EXPECT_EQ(light.main_share, 0.0f);
    for (const float c : light.cells) EXPECT_NEAR(c, 1.0 / 64, 0.01 / 64);
    EXPECT_NEAR(sum(light.cells), 1.0, 1e-5);
    for (const float e : light.irradiance) EXPECT_NEAR(e, k_pi_double * 0.4, 0.02 * k_pi_double * 0.4);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.sh[c], 2 * std::sqrt(k_pi_double) * 0.4, 0.02);
    for (int i = 3; i < 27; ++i) EXPECT_NEAR(light.sh[i], 0.0, 0.02);
  }
}

// A covered camera shows nothing: all stays what is usual.
TEST(RoomLight, BlackImagesTeachNothing) {
  MadeUpRoom room;
  room.may_teach_nothing = true;
  const sandglass_room_light before = room.light();
  room.look_everywhere([](Direction) { return 0.0; });
  const sandglass_room_light light = room.light();
  EXPECT_EQ(std::memcmp(&light, &before, sizeof light), 0);
}

// A lamp of 4 degrees and radiance 60 before 0.2: it gives pi sin^2(4 deg) * 60 sin(elevation) of irradiance against
// 0.2 pi, most of the light. It is met without clipping by short exposures.
TEST(RoomLight, FindsALampAndItsMirrorIsNotThere) {
  for (const double azimuth : {20.0, 130.0, 250.0}) {
    SCOPED_TRACE(azimuth);
    const Direction lamp = middle_of_part(azimuth, 50);
    MadeUpRoom room;
    const Radiance radiance = lamp_room(lamp, 5.0, 60.0);
    room.look_everywhere(radiance, 1.0);
    for (int turn = 0; turn < 3; ++turn) room.look_everywhere(radiance, 1.0 / 64);
    const sandglass_room_light light = room.light();
    EXPECT_LT(angle_deg(main_of(light), lamp), 5.0);
    EXPECT_GT(light.main_share, 0.3f);
    EXPECT_NEAR(sum(light.ambient_cells) + static_cast<double>(light.main_share), 1.0, 1e-5);
    for (int i = 0; i < 64; ++i) EXPECT_LE(light.ambient_cells[i], light.cells[i]);
    EXPECT_GT(light.cells[cell_at(lamp)], 0.3f);
    const Direction mirrored = {lamp.x, lamp.y, -lamp.z};
    EXPECT_LT(light.cells[cell_at(mirrored)], 0.05f);
    // The share that is the lamp's: of the cell, within a third (a lamp smaller than a part, met at 16 points).
    const double from_lamp = 60.0 * k_pi_double * std::pow(std::sin(degrees(5)), 2) * lamp.y;
    const double share = from_lamp / (from_lamp + 0.2 * k_pi_double);
    EXPECT_NEAR(light.cells[cell_at(lamp)], share, share / 3);
  }
}

// Where an object stands, a lamp is seen in another direction: that from there to the point of the sphere.
TEST(RoomLight, TheLampMovesAsTheObjectDoes) {
  const Direction lamp = middle_of_part(90, 40);
  MadeUpRoom room;  // radius 3 m
  const Radiance radiance = lamp_room(lamp, 5.0, 60.0);
  for (int turn = 0; turn < 3; ++turn) room.look_everywhere(radiance, 1.0 / 64);
  for (const Direction at : {Direction{1, 0, 0}, Direction{0, 0, 1.5}, Direction{-1, 0, -1}}) {
    const sandglass_room_light light =
        room.light(static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z));
    const Direction ray = {3 * lamp.x - at.x, 3 * lamp.y - at.y, 3 * lamp.z - at.z};
    const double n = std::sqrt(cosine(ray, ray));
    EXPECT_LT(angle_deg(main_of(light), {ray.x / n, ray.y / n, ray.z / n}), 6.0);
    EXPECT_GT(angle_deg(main_of(light), lamp), 10.0);  // the control: it is not where it was
  }
}

// One scene, stored four ways: the sensor may be turned by quarters, and the pose may be that of the stored image or of
// the upright one. All must say the same.
TEST(RoomLight, EveryTurnOfTheSensorSaysTheSame) {
  const Direction lamp = middle_of_part(40, 10);
  const Photograph upright = photograph(lamp_room(lamp, 8.0, 2.0), 40, 0, 0.4, 1000);
  MadeUpRoom straight;
  straight.show(upright.image);
  const sandglass_room_light expected = straight.light();
  const uint32_t width = upright.image.width, height = upright.image.height;
  for (const uint32_t turn : {90u, 180u, 270u})
    for (const uint32_t pose_is_upright : {0u, 1u}) {
      SCOPED_TRACE(std::to_string(turn) + (pose_is_upright != 0 ? " upright" : " stored"));
      // The clockwise turn that makes the stored image upright was undone: upright (x, y) is stored at (sx, sy).
      const bool quarter = turn != 180;
      const uint32_t stored_width = quarter ? height : width, stored_height = quarter ? width : height;
      std::vector<uint8_t> bytes(upright.bytes.size());
      for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
          const uint32_t sx = turn == 90 ? y : turn == 180 ? width - 1 - x : height - 1 - y;
          const uint32_t sy = turn == 90 ? width - 1 - x : turn == 180 ? height - 1 - y : x;
          for (uint32_t c = 0; c < 3; ++c)
            bytes[3 * (sy * stored_width + sx) + c] = upright.bytes[3 * (y * width + x) + c];
        }
      sandglass_camera_image image = upright.image;
      image.planes[0] = bytes.data();
      image.strides[0] = 3 * stored_width;
      image.width = stored_width;
      image.height = stored_height;
      image.turn_deg = turn;
      image.centre_x = 0.5f * static_cast<float>(stored_width - 1);
      image.centre_y = 0.5f * static_cast<float>(stored_height - 1);
      image.pose_is_upright = pose_is_upright;
      if (pose_is_upright == 0) {
        // The stored camera is the upright one turned about its axis, which looks along -z: clockwise by `turn` as one
        // looks at the picture makes it upright, so its own frame is turned the other way.
        const double half = degrees(-0.5 * turn);
        const float q[4] = {0, 0, static_cast<float>(std::sin(half)), static_cast<float>(std::cos(half))};
        const float* p = upright.image.orientation;
        // p q: first the turn, in the camera's frame
        image.orientation[0] = p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1];
        image.orientation[1] = p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0];
        image.orientation[2] = p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3];
        image.orientation[3] = p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2];
      }
      MadeUpRoom room;
      room.show(image);
      const sandglass_room_light light = room.light();
      for (int i = 0; i < 64; ++i) EXPECT_NEAR(light.cells[i], expected.cells[i], 0.02 * expected.cells[i] + 1e-4);
      // The control: without the turn the picture lies on its side.
      image.turn_deg = 0;
      image.pose_is_upright = 0;
      for (int k = 0; k < 4; ++k) image.orientation[k] = upright.image.orientation[k];
      MadeUpRoom wrong;
      wrong.show(image);
      const sandglass_room_light other = wrong.light();
      double difference = 0;
      for (int i = 0; i < 64; ++i)
        difference = std::max(difference, std::fabs(static_cast<double>(other.cells[i] / expected.cells[i] - 1)));
      EXPECT_GT(difference, 0.1);
    }
}

// A camera that exposes each image in another way, and does not say how: what images share tells it.
TEST(RoomLight, FindsTheExposureWhereItIsNotTold) {
  const Radiance gradient = [](Direction d) { return 0.15 + 0.1 * d.x; };
  MadeUpRoom known, unknown;
  known.may_teach_nothing = unknown.may_teach_nothing = true;
  known.may_teach_nothing = unknown.may_teach_nothing = true;
  int image = 0;
  for (int azimuth = 0; azimuth < 360; azimuth += 20, ++image) {
    const double exposure = image % 2 == 0 ? 1.0 : 2.5;
    known.look(gradient, azimuth, 10, exposure, true);
    unknown.look(gradient, azimuth, 10, exposure, false);
  }
  const sandglass_room_light a = known.light(), b = unknown.light();
  for (int i = 0; i < 64; ++i) EXPECT_NEAR(a.cells[i], b.cells[i], 0.1 * a.cells[i]);
  EXPECT_NEAR(a.irradiance[0], b.irradiance[0], 0.1 * a.irradiance[0]);
}

// A picture that is exposed for a 64th shows walls at two or three steps of a byte, and a lamp that was clipped before.
// The walls tell the exposure; the lamp, of which only a lower bound was known, must not.
TEST(RoomLight, FindsAShortExposureByTheDarkPartsOfThePicture) {
  const Direction lamp = middle_of_part(100, 17);
  const Radiance radiance = [=](Direction d) { return angle_deg(d, lamp) < 7 ? 20.0 : 0.045 + 0.02 * d.x; };
  MadeUpRoom known, unknown;
  known.may_teach_nothing = unknown.may_teach_nothing = true;
  for (const double exposure : {2.0, 2.0 / 64})
    for (int azimuth = 0; azimuth < 360; azimuth += 20) {
      known.look(radiance, azimuth, 10, exposure, true);
      unknown.look(radiance, azimuth, 10, exposure, false);
    }
  const float cell = known.light().cells[cell_at(lamp)];
  EXPECT_GT(cell, 0.2f);
  EXPECT_NEAR(unknown.light().cells[cell_at(lamp)], cell, 0.25f * cell);
  EXPECT_NEAR(unknown.light().irradiance[0], known.light().irradiance[0], 0.25f * known.light().irradiance[0]);
}

// Radiance is in the last image's scale: twice the exposure, twice the irradiance.
TEST(RoomLight, AnswersInTheScaleOfTheLastImage) {
  MadeUpRoom room;
  room.look_everywhere([](Direction) { return 0.2; });
  const float before = room.light().irradiance[1];
  room.look([](Direction) { return 0.2; }, 0, 0, 2.0);
  EXPECT_NEAR(room.light().irradiance[1], 2 * before, 0.02f * before);
}

// What is told of how a camera codes its light is undone. Untold, it is taken for sRGB.
TEST(RoomLight, IsTheSameByAToneCurve) {
  static const float k_tone[] = {0, 0, 0.05f, 0.3f, 0.2f, 0.6f, 0.6f, 0.9f, 1, 1};  // light, value
  const Radiance radiance = lamp_room(towards(0, 40), 20, 0.9);
  const auto level = [&](bool toned, bool known) {
    MadeUpRoom room;
    for (int azimuth = 0; azimuth < 360; azimuth += 30) {
      Photograph p =
          photograph(radiance, azimuth, 20, 1.0, 1'000'000'000ull + static_cast<uint64_t>(azimuth) * 10'000'000);
      for (uint8_t& byte : p.bytes) {
        const double c = byte / 255.0, light = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
        const float* at = k_tone;
        while (light > static_cast<double>(at[2])) at += 2;
        const double along = (light - static_cast<double>(at[0])) / static_cast<double>(at[2] - at[0]);
        const double value = static_cast<double>(at[1]) + along * static_cast<double>(at[3] - at[1]);
        if (toned) byte = static_cast<uint8_t>(std::lround(255 * value));
      }
      if (known) {
        p.image.transfer = SANDGLASS_TRANSFER_CURVE;
        p.image.curve = k_tone;
        p.image.curve_points = 5;
      }
      room.show(p.image);
    }
    return static_cast<double>(room.light().irradiance[1]);
  };
  const double truth = level(false, false);
  EXPECT_NEAR(level(true, true) / truth, 1, 0.02);
  EXPECT_GT(std::fabs(level(true, false) / truth - 1), 0.1);  // the control
}

// White pixels hide a lamp; a short exposure shows it, and a long one after that does not hide it again.
TEST(RoomLight, AShortExposureShowsWhatWasClipped) {
  const Direction lamp = middle_of_part(0, 17);
  const Radiance radiance = lamp_room(lamp, 5.6, 40.0);
  MadeUpRoom room;
  for (int i = 0; i < 4; ++i) room.look(radiance, 0, 10, 1.0);
  const sandglass_room_light hidden = room.light();
  EXPECT_GT(hidden.clipped, 0.01f);
  for (int i = 0; i < 4; ++i) room.look(radiance, 0, 10, 1.0 / 64);
  const sandglass_room_light shown = room.light();
  EXPECT_LT(shown.clipped, 0.25f * hidden.clipped);
  EXPECT_GT(shown.cells[cell_at(lamp)], 2 * hidden.cells[cell_at(lamp)]);
  for (int i = 0; i < 4; ++i) room.look(radiance, 0, 10, 1.0);
  const sandglass_room_light after = room.light();
  EXPECT_NEAR(after.cells[cell_at(lamp)], shown.cells[cell_at(lamp)], 0.02f);
}

TEST(RoomLight, ALampThatGoesOutIsGoneWithinASecond) {
  const Direction lamp = middle_of_part(0, 17);
  const Radiance on = lamp_room(lamp, 8.0, 3.0), off = lamp_room(lamp, 8.0, 0.2);
  MadeUpRoom room;
  room.may_teach_nothing = true;
  for (int i = 0; i < 20; ++i) room.look(on, 0, 10, 0.3);
  const float before = room.light().cells[cell_at(lamp)];
  for (int i = 0; i < 10; ++i) room.look(off, 0, 10, 0.3);
  const float after = room.light().cells[cell_at(lamp)];
  MadeUpRoom dark;
  dark.may_teach_nothing = true;
  for (int i = 0; i < 10; ++i) dark.look(off, 0, 10, 0.3);
  const float never = dark.light().cells[cell_at(lamp)];
  EXPECT_GT(before, 1.5f * never);
  EXPECT_LT(after - never, 0.2f * (before - never));
}

// A lamp behind the camera goes out, and the walls in front of it become a third as bright. The lamp is taken to have
// done so too, within one image. Where nothing changes, or one wall alone, nothing is lost.
TEST(RoomLight, WhatIsBehindTheCameraFollowsAChangeOfLight) {
  const Direction lamp = middle_of_part(180, 50);
  const Radiance on = lamp_room(lamp, 8.0, 40.0, 0.6), off = [](Direction) { return 0.2; };
  const Radiance one_wall = [&](Direction d) { return d.x > 0.94 ? 0.2 : on(d); };  // 20 degrees about the middle
  // In a scale that no exposure changes; without what the lamp's cell would get from a wall as bright as the others.
  const auto lamp_gives = [&](const sandglass_room_light& light) {
    return static_cast<double>(light.irradiance[1] * light.white) *
           static_cast<double>(light.cells[cell_at(lamp)] - light.cells[cell_at(towards(0, 50))]);
  };
  for (const auto& [then, left] : {std::pair(off, 1.0 / 3), std::pair(on, 1.0), std::pair(one_wall, 1.0)}) {
    MadeUpRoom room;
    room.look_everywhere(on);
    for (int turn = 0; turn < 3; ++turn) room.look_everywhere(on, 1.0 / 64);
    const double before = lamp_gives(room.light());
    room.look(then, 0, 10);
    EXPECT_NEAR(lamp_gives(room.light()) / before, left, 0.03);
  }
}

// After one half-life what was seen counts half; the share seen of an even sphere says how much.
TEST(RoomLight, ForgetsByHalves) {
  MadeUpRoom room(10.0f);
  const Radiance even = [](Direction) { return 0.3; };
  room.look(even, 0, 20);
  const float before = room.light().seen;
  ASSERT_GT(before, 0.02f);
  room.look(even, 0, -80, 1.0, true, 10.0);  // looks down, ten seconds later
  EXPECT_NEAR(room.light().seen, 0.5f * before, 0.02f * before);
}

TEST(RoomLight, SaysWhereToLook) {
  MadeUpRoom room;
  const Radiance even = [](Direction) { return 0.3; };
  for (int azimuth = 0; azimuth < 360; azimuth += 20)
    for (const int elevation : {0, 35, 70})
      if (azimuth < 60 || azimuth > 160) room.look(even, azimuth, elevation);
  const sandglass_room_light light = room.light();
  const Direction look = {light.look[0], light.look[1], light.look[2]};
  EXPECT_LT(angle_deg(look, towards(110, 40)), 45.0);
}

// The world turns and moves with the origin of an app's scene.
TEST(RoomLight, MovesWithTheWorld) {
  const Direction lamp = middle_of_part(70, 40);
  MadeUpRoom room;
  for (int turn = 0; turn < 2; ++turn) room.look_everywhere(lamp_room(lamp, 6.0, 40.0), 1.0 / 64);
  const Direction before = main_of(room.light(0.5f, 0, 0));
  const float axis[3] = {0, 1, 0}, shift[3] = {4, 1, -2};
  float rotation[4];
  ASSERT_EQ(sandglass_rotation_about(axis, 1.0f, rotation), 1);
  ASSERT_EQ(sandglass_room_move(room.handle(), rotation, shift, nullptr), SANDGLASS_OK);
  // x becomes (x cos 1 + z sin 1, y, z cos 1 - x sin 1).
  const auto turned = [](Direction d) {
    return Direction{d.x * std::cos(1.0) + d.z * std::sin(1.0), d.y, d.z * std::cos(1.0) - d.x * std::sin(1.0)};
  };
  const Direction place = turned({0.5, 0, 0});
  const sandglass_room_light moved = room.light(static_cast<float>(place.x) + 4, 1, static_cast<float>(place.z) - 2);
  EXPECT_LT(angle_deg(main_of(moved), turned(before)), 3.0);  // the cells lie otherwise about the lamp
  EXPECT_GT(angle_deg(main_of(moved), before), 30.0);         // the control
  const float tilt[4] = {0.1f, 0, 0, 0.995f};
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_room_move(room.handle(), tilt, shift, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(reason).find("gravity"), std::string::npos);
}

TEST(RoomLight, PassesOverImagesThatComeTooSoon) {
  sandglass_room_desc desc;
  sandglass_room_desc_default(&desc);
  alignas(64) static uint8_t block[16384];
  sandglass_room* room = nullptr;
  ASSERT_EQ(sandglass_room_create(&desc, block, sizeof block, &room, nullptr), SANDGLASS_OK);
  int32_t taken = 0;
  const uint64_t times_ms[] = {1, 50, 100, 102, 150, 250};
  const int32_t expected[] = {1, 0, 0, 1, 0, 1};
  for (int i = 0; i < 6; ++i) {
    const Photograph p = photograph([](Direction) { return 0.3; }, 0, 0, 1, times_ms[i] * 1'000'000);
    ASSERT_EQ(sandglass_room_set_image(room, &p.image, &taken, nullptr), SANDGLASS_OK);
    EXPECT_EQ(taken, expected[i]) << times_ms[i];
  }
}

TEST(RoomLight, RefusesWhatItCannotUse) {
  sandglass_room_desc desc;
  uint64_t bytes = 0;
  const char* reason = nullptr;
  const auto refused = [&](void (*spoil)(sandglass_room_desc*)) {
    sandglass_room_desc_default(&desc);
    spoil(&desc);
    return sandglass_room_bytes(&desc, &bytes, &reason) == SANDGLASS_ERROR_INVALID_ARGUMENT && reason != nullptr;
  };
  EXPECT_TRUE(refused([](sandglass_room_desc* d) { d->struct_size = 4; }));
  EXPECT_TRUE(refused([](sandglass_room_desc* d) { d->radius = 0.01f; }));
  EXPECT_TRUE(refused([](sandglass_room_desc* d) { d->radius = NAN; }));
  EXPECT_TRUE(refused([](sandglass_room_desc* d) { d->half_life = 0; }));
  EXPECT_TRUE(refused([](sandglass_room_desc* d) { d->interval = -1; }));
  MadeUpRoom room;
  Photograph p = photograph([](Direction) { return 0.3; }, 0, 0, 1, 1);
  p.image.exposure = NAN;
  EXPECT_EQ(sandglass_room_set_image(room.handle(), &p.image, nullptr, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  p.image.exposure = 1;
  p.image.position[1] = INFINITY;
  EXPECT_EQ(sandglass_room_set_image(room.handle(), &p.image, nullptr, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  const sandglass_room_place nowhere = {sizeof nowhere, {0, NAN, 0}, nullptr, nullptr, nullptr, nullptr, nullptr};
  EXPECT_EQ(sandglass_room_get(room.handle(), &nowhere, &light, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
}

// A network's estimate of a light from there, of which it is sure.
sandglass_estimator_light sure_of(Direction d) {
  sandglass_estimator_light estimate = {};
  estimate.struct_size = sizeof estimate;
  estimate.valid = 1;
  const double axes[3] = {d.x, d.y, d.z};
  for (int k = 0; k < 3; ++k) estimate.direction[k] = static_cast<float>(axes[k]);
  estimate.confidence = estimate.contrast = 1;
  return estimate;
}

bool same(const sandglass_room_light& a, const sandglass_room_light& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Numbers that are not finite, and shares that are none, are refused: nothing is written. The control: the estimate as
// it should be is taken, and says where light is to be expected.
TEST(RoomLight, AnEstimateThatIsNoneIsRefused) {
  const MadeUpRoom room;
  const Direction lamp = towards(60, 40);
  const sandglass_estimator_light good = sure_of(lamp);
  EXPECT_GT(room.light(0, 0, 0, &good).cells[cell_at(lamp)], 1.1f / 64);
  const auto refused = [&](auto change) {
    sandglass_estimator_light estimate = good;
    change(&estimate);
    sandglass_room_light light;
    std::memset(&light, 0x5a, sizeof light);
    light.struct_size = sizeof light;
    const sandglass_room_light before = light;
    const sandglass_room_place place = {sizeof place, {0, 0, 0}, &estimate, nullptr, nullptr, nullptr, nullptr};
    const char* reason = nullptr;
    return sandglass_room_get(room.handle(), &place, &light, &reason) == SANDGLASS_ERROR_INVALID_ARGUMENT &&
           reason != nullptr && same(light, before);
  };
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    SCOPED_TRACE(bad);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(refused([&](sandglass_estimator_light* e) { e->direction[k] = bad; })) << k;
  }
  for (const float bad : {NAN, INFINITY, -INFINITY, -0.5f, 1.5f}) {
    SCOPED_TRACE(bad);
    EXPECT_TRUE(refused([&](sandglass_estimator_light* e) { e->confidence = bad; }));
    EXPECT_TRUE(refused([&](sandglass_estimator_light* e) { e->contrast = bad; }));
  }
  EXPECT_TRUE(refused([](sandglass_estimator_light* e) { e->struct_size = 4; }));
}

// A finite direction that is far from a unit vector is no direction. The answer is that without an estimate.
TEST(RoomLight, AnEstimateWithoutAUnitVectorSaysNothing) {
  const MadeUpRoom room;
  const sandglass_room_light without = room.light();
  for (const float length : {2.0f, 1e20f, -1e30f, 3e38f}) {
    SCOPED_TRACE(length);
    for (int k = 0; k < 3; ++k) {
      sandglass_estimator_light estimate = sure_of(towards(60, 40));
      estimate.direction[k] = length;
      EXPECT_TRUE(same(room.light(0, 0, 0, &estimate), without)) << k;
    }
  }
}

}  // namespace
}  // namespace sandglass

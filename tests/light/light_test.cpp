// The light as an app uses it: memory, units, the world's frame, what is refused, and its stage in a frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "models/rooms/panorama.h"
#include "platform/virtual_clock.h"
#include "runtime/light/camera/camera_image.h"
#include "runtime/light/network/resample.h"
#include "runtime/math/random.h"
#include "tests/camera_picture.h"
#include "tests/light/light_fixture.h"
#include "tests/reason.h"
#include "tests/sand_scene.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;
using host::Vec3;

constexpr uint64_t k_period_ns = 300'000'000;

TEST(Light, BeforeTheFirstEstimateItComesFromAboveAndIsNotValid) {
  const LiveLight live;
  const sandglass_estimator_light e = live.light();
  EXPECT_EQ(e.valid, 0u);
  EXPECT_EQ(e.direction[1], 1.0f);
  EXPECT_EQ(e.contrast, 0.0f);
  EXPECT_EQ(e.strength, 0.0f);
  EXPECT_EQ(e.confidence, 0.0f);
  EXPECT_NEAR(e.sh[0], 0.5 * std::sqrt(4.0 * std::numbers::pi), 1e-6);
  EXPECT_EQ(sandglass_estimator_units_left(live.get()), 0u);
}

Vec3 vector_of(const float* v) { return {v[0], v[1], v[2]}; }

// With the identity pose the camera looks along -z, y up: the network's (x, y down, z) is the world's (x, -y, -z). If a
// turned camera sees the same image, the light is turned with it.
TEST(Estimator, TheCamerasTurnIsTakenOut) {
  sandglass_estimator_desc desc = describe_light();
  desc.smoothing = 0.0f;
  LiveLight live(desc);
  TestImage picture(5);
  live.estimate(picture.image);
  const Vec3 straight = vector_of(live.light().direction);
  const double angle = 0.7;
  picture.image.orientation[1] = static_cast<float>(std::sin(0.5 * angle));
  picture.image.orientation[3] = static_cast<float>(std::cos(0.5 * angle));
  live.estimate(picture.image);
  const Vec3 turned = vector_of(live.light().direction);
  EXPECT_NEAR(turned.x, std::cos(angle) * straight.x + std::sin(angle) * straight.z, 1e-6);
  EXPECT_NEAR(turned.y, straight.y, 1e-6);
  EXPECT_NEAR(turned.z, -std::sin(angle) * straight.x + std::cos(angle) * straight.z, 1e-6);
}

// For any pose and turn, a world direction that the sensor sees in upright coordinates comes back. The quarter turn is
// done here on the screen: clockwise, right becomes down and down becomes left.
TEST(Estimator, StoredTurnedAndUprightPosesGiveOneWorld) {
  Random random = random_stream(11, 1);
  for (int trial = 0; trial < 40; ++trial) {
    TestImage picture(1);
    sandglass_camera_image& image = picture.image;
    for (float& q : image.orientation) q = static_cast<float>(2.0 * random.uniform() - 1.0);
    image.turn_deg = 90 * (static_cast<uint32_t>(trial) % 4);
    const Vec3 d = host::normalised(Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
    // The camera's axes in the world, from the quaternion's matrix (any length).
    const double x = image.orientation[0], y = image.orientation[1], z = image.orientation[2], w = image.orientation[3];
    const double n = x * x + y * y + z * z + w * w;
    const Vec3 right = Vec3{w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)} * (1.0 / n);
    const Vec3 up = Vec3{2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)} * (1.0 / n);
    const Vec3 back = Vec3{2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z} * (1.0 / n);
    double across = host::dot(d, right), down = -host::dot(d, up);
    for (uint32_t quarter = 0; quarter < image.turn_deg / 90; ++quarter) {
      const double was = across;
      across = -down;
      down = was;
    }
    const double upright[3] = {across, down, -host::dot(d, back)};
    double world[3];
    camera_to_world(image, upright, world);
    EXPECT_NEAR(host::length(Vec3{world[0], world[1], world[2]} - d), 0.0, 1e-6) << trial;

    // FROM_POSE picks that of the four turns in which the world's up is nearest to up in the image.
    sandglass_camera_image unknown = image;
    unknown.turn_deg = SANDGLASS_TURN_FROM_POSE;
    double u = right.y, v = -up.y, lowest = 2.0;
    uint32_t best = 0;
    for (uint32_t turn = 0; turn < 360; turn += 90) {
      if (v < lowest) {
        lowest = v;
        best = turn;
      }
      const double was = u;
      u = -v;
      v = was;
    }
    EXPECT_EQ(with_turn(unknown).turn_deg, best);
  }
  TestImage picture(1);
  picture.image.turn_deg = 90;
  picture.image.pose_is_upright = 1;
  const double ahead_right[3] = {0.6, 0.0, 0.8};
  double world[3];
  camera_to_world(picture.image, ahead_right, world);
  EXPECT_NEAR(world[0], 0.6, 1e-9);
  EXPECT_NEAR(world[2], -0.8, 1e-9);
}

TEST(Estimator, ImagesComeNoMoreOftenThanTheInterval) {
  LiveLight live;
  TestImage picture(3);
  const auto offer = [&](uint64_t time_ns) {
    picture.image.timestamp_ns = time_ns;
    int32_t taken = 7;
    EXPECT_EQ(sandglass_estimator_set_image(live.get(), &picture.image, &taken, nullptr), SANDGLASS_OK);
    return taken;
  };
  EXPECT_EQ(offer(1'000'000'000), 1);
  EXPECT_EQ(offer(2'000'000'000), 0);  // an estimate is in progress
  live.finish();
  EXPECT_EQ(offer(1'000'000'000), 0);  // the same image
  EXPECT_EQ(offer(1'249'000'000), 0);
  EXPECT_EQ(offer(1'250'000'000), 1);
}

TEST(Estimator, ResetForgetsAndTurnTurns) {
  LiveLight live, fresh;
  TestImage picture(3);
  live.estimate(picture.image);
  const Vec3 before = vector_of(live.light().direction);
  const float quarter[4] = {0.0f, 0.0f, 2.0f, 2.0f};  // about z, of any length
  ASSERT_EQ(sandglass_estimator_turn(live.get(), quarter, nullptr), SANDGLASS_OK);
  const Vec3 after = vector_of(live.light().direction);
  EXPECT_NEAR(host::length(after - Vec3{-before.y, before.x, before.z}), 0.0, 1e-6);
  const float none[4] = {};
  EXPECT_EQ(sandglass_estimator_turn(live.get(), none, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  sandglass_estimator_reset(live.get());
  EXPECT_EQ(live.light().valid, 0u);
  live.estimate(picture.image);
  fresh.estimate(picture.image);
  EXPECT_EQ(sandglass_estimator_hash(live.get()), sandglass_estimator_hash(fresh.get()));
}

// Quaternions of any length work, also those whose squares overflow or vanish in float. Turning the world during an
// estimate gives the same as turning the finished estimate.
TEST(Estimator, PosesAndTurnsOfAnyLengthTurnTheImageUnderWay) {
  const auto turned_at_length = [](float length, bool under_way) {
    LiveLight live;
    TestImage picture(3);
    const float pose[4] = {0.5f * length, 0.1f * length, -0.3f * length, 0.8f * length};
    const float turn[4] = {-0.2f * length, 0.6f * length, 0.4f * length, 0.7f * length};
    std::copy_n(pose, 4, picture.image.orientation);
    EXPECT_EQ(sandglass_estimator_set_image(live.get(), &picture.image, nullptr, nullptr), SANDGLASS_OK);
    if (!under_way) live.finish();
    EXPECT_EQ(sandglass_estimator_turn(live.get(), turn, nullptr), SANDGLASS_OK);
    live.finish();
    EXPECT_EQ(live.light().valid, 1u);
    return vector_of(live.light().direction);
  };
  const Vec3 expected = turned_at_length(1.0f, false);
  EXPECT_NEAR(host::length(expected), 1.0, 1e-6);
  for (const float length : {1.0f, 1e20f, 1e37f, 1e-25f, 1e-37f}) {
    if (SANDGLASS_EMULATED && length != 1e20f) continue;  // an estimate takes seconds
    EXPECT_NEAR(host::length(turned_at_length(length, true) - expected), 0.0, 1e-6) << length;
  }
}

// ------------------------------------------------------------------------------------------------------- bad input

TEST(LightInput, WhatCannotBeUsedIsRefusedWithASentence) {
  const auto refused = [](const std::string& words, auto&& spoil,
                          sandglass_status status = SANDGLASS_ERROR_INVALID_ARGUMENT) {
    sandglass_estimator_desc desc = describe_light();
    spoil(desc);
    uint64_t bytes = 0;
    expect_refused(
        words, [&](const char** reason) { return sandglass_estimator_bytes(&desc, &bytes, reason); }, status);
    EXPECT_EQ(bytes, 0u);
  };
  refused("struct_size", [](auto& d) { d.struct_size = 3; });
  refused("NULL", [](auto& d) { d.asset = nullptr; });
  refused("aligned", [](auto& d) { d.asset = static_cast<const uint8_t*>(d.asset) + 1; });
  refused("damaged", [](auto& d) { --d.asset_bytes; });
  refused("lighting", [](auto& d) { d.asset_bytes = 5; });
  refused("interval", [](auto& d) { d.interval = NAN; });
  refused("smoothing", [](auto& d) { d.smoothing = -1.0f; });
  refused("turn_limit", [](auto& d) { d.turn_limit = 0.0f; });
  refused("outlier_angle", [](auto& d) { d.outlier_angle = 4.0f; });
  refused("outlier_level", [](auto& d) { d.outlier_level = INFINITY; });
  constexpr sandglass_status k_unsupported = SANDGLASS_ERROR_UNSUPPORTED;
  refused(
      "isa", [](auto& d) { d.isa = 99; }, k_unsupported);
  refused(
      "not one of sandglass_estimator_backend", [](auto& d) { d.backend = -1; }, k_unsupported);
  refused(
      "SANDGLASS_ESTIMATOR_BACKEND_OWN", [](auto& d) { d.backend = 1 + SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8; },
      k_unsupported);
  if (!SANDGLASS_WITH_XNNPACK)
    refused(
        "SANDGLASS_XNNPACK=ON", [](auto& d) { d.backend = SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32; }, k_unsupported);
  sandglass_estimator_release(nullptr);  // as after a refusal, when there is nothing to release
  // Another kind of asset: the identifier of a shadow with a right checksum.
  AssetFile shadow = random_light();
  std::memcpy(shadow.data() + 4, "SGSH", 4);
  shadow.repair_checksum();
  refused("not a lighting network", [&](auto& d) { d.asset = shadow.data(); });
}

// camera_image_test.cpp has what else is wrong with an image.
TEST(LightInput, ABadImageIsRefusedAndChangesNothing) {
  LiveLight live;
  const uint64_t before = sandglass_estimator_hash(live.get());
  TestImage picture(1);
  picture.image.focal_x = NAN;
  int32_t taken = 9;
  for (const sandglass_camera_image* image : {&picture.image, static_cast<sandglass_camera_image*>(nullptr)})
    expect_refused(image == nullptr ? "NULL" : "focal", [&](const char** reason) {
      return sandglass_estimator_set_image(live.get(), image, &taken, reason);
    });
  EXPECT_EQ(taken, 9);
  EXPECT_EQ(sandglass_estimator_hash(live.get()), before);
  EXPECT_EQ(sandglass_estimator_units_left(live.get()), 0u);
}

void expect_usable(const sandglass_estimator_light& e) {
  EXPECT_EQ(e.valid, 1u);
  EXPECT_NEAR(host::length(vector_of(e.direction)), 1.0, 1e-6);
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(e.light[c] >= 0.0f && e.light[c] <= 1.0f);
    EXPECT_TRUE(e.ambient[c] >= 0.0f && e.ambient[c] <= 1.0f);
  }
  EXPECT_TRUE(e.contrast >= 0.0f && e.contrast <= 1.0f);
  EXPECT_TRUE(e.confidence >= 0.0f && e.confidence <= 1.0f);
  EXPECT_TRUE(e.strength >= 0.0f && e.strength <= 64.0f);
  for (const float x : e.sh) EXPECT_TRUE(std::isfinite(x));
}

TEST(LightInput, BlackWhiteTinyAndHugeImagesGiveUsableLight) {
  for (const uint8_t level : {uint8_t{0}, uint8_t{255}}) {
    LiveLight live;
    TestImage flat(1);
    std::fill(flat.bytes.begin(), flat.bytes.end(), level);
    live.estimate(flat.image);
    expect_usable(live.light());
  }
  LiveLight live;
  const TestImage tiny(2, 2, 2);
  live.estimate(tiny.image);
  expect_usable(live.light());
  if (SANDGLASS_EMULATED) return;
  LiveLight other;
  const TestImage huge(3, 16384, 1024);
  other.estimate(huge.image);
  expect_usable(other.light());
}

// An image that is enlarged or shrunk by far stays the same picture: a ramp stays a ramp, also where only the middle
// rows of a box are read.
TEST(LightInput, AHugeImageIsReadWhereItShouldBe) {
  constexpr uint32_t k_width = 3000, k_height = 9000;
  TestImage ramp(1, k_width, k_height);
  for (uint32_t y = 0; y < k_height; ++y)
    for (uint32_t x = 0; x < k_width; ++x) {
      uint8_t* p = ramp.bytes.data() + 3 * (size_t{y} * k_width + x);
      p[0] = static_cast<uint8_t>(255 * y / k_height);
      p[1] = static_cast<uint8_t>(255 * x / k_width);
      p[2] = 90;
    }
  ramp.image.turn_deg = 0;
  ramp.image.focal_x = static_cast<float>(k_light_focal * k_width / 256.0);
  ramp.image.focal_y = static_cast<float>(k_light_focal * k_height / 192.0);
  std::vector<uint8_t> rgb(3 * k_light_width * k_light_height);
  std::vector<uint32_t> sums(k_camera_sums);
  resample_camera_block(ramp.image, whole_camera_block(ramp.image), rgb.data(), sums.data());
  for (uint32_t y = 0; y < k_light_height; ++y)
    for (uint32_t x = 0; x < k_light_width; ++x) {
      const uint8_t* p = rgb.data() + 3 * (y * k_light_width + x);
      ASSERT_NEAR(p[0], 255.0 * (y + 0.5) / 192.0 - 0.5, 1.2);
      ASSERT_NEAR(p[1], 255.0 * (x + 0.5) / 256.0 - 0.5, 1.2);
      ASSERT_EQ(p[2], 90);
    }
}

// ------------------------------------------------------------------------------------------------------- every machine

// Of a filtered estimate from an RGB image, and of a second one, from a turned NV12 image with a pose. (The kernels of
// all sets one by one: network_test.cpp.)
TEST(LightHash, IsOneOnEveryMachineAndCompiler) {
  LiveLight live;
  TestImage picture{21};
  picture.image.timestamp_ns = k_period_ns;
  live.estimate(picture.image);
  std::vector<uint8_t> planes(640 * 480 * 3 / 2);
  Random random = random_stream(5, 5);
  for (uint8_t& b : planes) b = static_cast<uint8_t>(random.below(256));
  sandglass_camera_image image = camera_picture(planes.data(), 640, 480, 525.0f, SANDGLASS_CAMERA_NV12);
  image.turn_deg = 90;
  image.orientation[0] = 0.3f;
  image.orientation[2] = -0.6f;
  image.timestamp_ns = 2 * k_period_ns;
  live.estimate(image);
  EXPECT_EQ(sandglass_estimator_hash(live.get()), 5541727358863979531u);
}

// ------------------------------------------------------------------------------------------------------- in the frame

sandglass_frame_report frame(SandScene& sand, sandglass_estimator* light, const sandglass_camera_image* image,
                             uint64_t budget_ns) {
  sandglass_frame_input input = frame_input();
  input.estimator = light;
  input.camera = image;
  return sand.frame(input, budget_ns);
}

// With no time at all, the image is resampled in its frame, and then one unit a frame runs. The estimate before stays
// until the same one arrives as in one call. The app may change the image's bytes after the frame.
TEST(LightFrame, ABudgetOfNothingStillBringsTheEstimate) {
  LiveLight expected, live;
  TestImage first(1), picture(4);
  first.image.timestamp_ns = k_period_ns;
  picture.image.timestamp_ns = 2 * k_period_ns;
  for (LiveLight* light : {&expected, &live}) light->estimate(first.image);
  expected.estimate(picture.image);
  const sandglass_estimator_light before = live.light();
  EXPECT_EQ(before.timestamp_ns, k_period_ns);
  VirtualClock time;
  time.step_ns = 1000;
  SandScene sand(virtual_clock(&time));
  sandglass_frame_report report = frame(sand, live.get(), &picture.image, 0);
  std::fill(picture.bytes.begin(), picture.bytes.end(), uint8_t{0});
  EXPECT_GT(report.stages[SANDGLASS_STAGE_LIGHT].units, 1u);
  uint32_t left = report.estimator.units_left, frames = 1;
  EXPECT_GT(left, 100u);
  for (; left > 0; ++frames) {
    const sandglass_estimator_light now = live.light();
    ASSERT_EQ(std::memcmp(&now, &before, sizeof now), 0) << left;
    ASSERT_EQ(sandglass_estimator_units_left(live.get()), left);
    report = frame(sand, live.get(), &picture.image, 0);  // images during an estimate are ignored
    ASSERT_EQ(report.stages[SANDGLASS_STAGE_LIGHT].units, 1u);
    ASSERT_EQ(report.estimator.units_left, left - 1);
    left = report.estimator.units_left;
    ASSERT_EQ(report.estimator.changed, left == 0 ? 1u : 0u);
  }
  EXPECT_EQ(report.estimator.valid, 1u);
  EXPECT_EQ(report.estimator.frames_behind, frames - 1);
  EXPECT_EQ(sandglass_estimator_hash(live.get()), sandglass_estimator_hash(expected.get()));
  report = frame(sand, live.get(), nullptr, 0);
  EXPECT_EQ(report.stages[SANDGLASS_STAGE_LIGHT].units, 0u);
  EXPECT_EQ(report.estimator.frames_behind, frames);
  EXPECT_EQ(report.estimator.changed, 0u);
  EXPECT_EQ(live.light().estimates, 2u);
}

TEST(LightFrame, WithoutAClockTheEstimateIsDoneInItsFrame) {
  LiveLight live;
  SandScene sand;
  const TestImage picture(6);
  const sandglass_frame_report report = frame(sand, live.get(), &picture.image, 1);
  EXPECT_EQ(report.estimator.valid, 1u);
  EXPECT_EQ(report.estimator.changed, 1u);
  EXPECT_EQ(report.estimator.units_left, 0u);
  EXPECT_EQ(report.estimator.frames_behind, 0u);
}

TEST(LightFrame, ABadImageIsLeftOutAndReported) {
  std::string said;
  LiveLight live;
  SandScene sand({}, {[](void* user, const char* sentence) { *static_cast<std::string*>(user) = sentence; }, &said});
  TestImage picture(6);
  picture.image.focal_x = NAN;
  const uint64_t before = sandglass_estimator_hash(live.get());
  const sandglass_frame_report report = frame(sand, live.get(), &picture.image, 1'000'000);
  EXPECT_EQ(sand.status, SANDGLASS_OK);
  EXPECT_EQ(report.estimator.ignored_images, 1u);
  EXPECT_NE(said.find("focal"), std::string::npos) << said;
  EXPECT_EQ(sandglass_estimator_hash(live.get()), before);
}

}  // namespace

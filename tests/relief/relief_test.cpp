// What relief.h promises: heights where things are, in whatever way an image is stored, divided and posed; and what it
// refuses. How well it does with the images of devices is verified by the laboratory.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "runtime/math/hash.h"
#include "tests/damaged_file.h"
#include "tests/reason.h"
#include "tests/relief/depth_of_box.h"

namespace {

using namespace sandglass::tests;

constexpr double k_quarter = 0.00026;  // metres: one height, and what a float rounds away

TEST(Relief, KnowsABoxAfterFiveLooks) {
  const DepthOfBox depth;
  sandglass::Relief relief = made();
  for (int look = 1; look <= 4; ++look) EXPECT_TRUE(relief.set_image(depth.image));
  EXPECT_EQ(relief.heights().version, 0u);
  EXPECT_EQ(wrong_heights(relief, k_quarter, 0), 0u);
  EXPECT_TRUE(relief.set_image(depth.image));
  EXPECT_EQ(relief.heights().version, 1u);
  EXPECT_EQ(wrong_heights(relief, k_quarter), 0u);
  EXPECT_GT(wrong_heights(relief, k_quarter, 0), 200u);
  // What was changed is the box alone, and all of it.
  const sandglass_heights h = relief.heights();
  for (int k = 0; k < 2; ++k) {
    const double half = k == 0 ? k_box[0] : k_box[2];
    EXPECT_NEAR(h.low[k], 64 - 100 * half, 1.5);
    EXPECT_NEAR(h.high[k], 64 + 100 * half, 1.5);
  }
  EXPECT_TRUE(relief.set_image(depth.image));
  EXPECT_EQ(relief.heights().version, 1u);
}

TEST(Relief, WhatIsTakenAwayGoesAndAReset) {
  const DepthOfBox with, without(false);
  sandglass::Relief relief = seen(with.image);
  int images = 0;
  for (; wrong_heights(relief, k_quarter, 0) != 0 && images < 30; ++images)
    EXPECT_TRUE(relief.set_image(without.image));
  EXPECT_LE(images, 12);  // 0.8 s of 15 a second
  EXPECT_GE(images, 4);   // one image may be a mistake
  relief = seen(with.image);
  relief.reset();
  EXPECT_EQ(heights_of(relief), heights_of(made()));
  EXPECT_EQ(relief.heights().version, 2u);
}

TEST(Relief, TakesACamerasBiasAway) {
  for (const double factor : {0.95, 1.04}) {
    const DepthOfBox depth(true, factor);
    const sandglass::Relief relief = seen(depth.image);
    EXPECT_NEAR(relief.heights().depth_scale, 1 / factor, 0.002) << factor;
    EXPECT_EQ(wrong_heights(relief, 0.003), 0u) << factor;
  }
  const DepthOfBox beyond(true, 0.85);  // the control: more than the plane is sought for
  const sandglass::Relief relief = seen(beyond.image);
  EXPECT_EQ(relief.heights().depth_scale, 1);
  EXPECT_GT(wrong_heights(relief, 0.003), 1000u);
}

TEST(Relief, LeavesOutWhatIsMaskedOrDoubtful) {
  DepthOfBox depth;
  std::vector<uint8_t> doubt;
  for (const uint8_t on : depth.mask) doubt.push_back(on != 0 ? 1 : 2);
  depth.image.mask_stride = depth.image.confidence_stride = k_width;
  depth.image.mask = depth.mask.data();
  EXPECT_EQ(wrong_heights(seen(depth.image), k_quarter, 0), 0u);
  depth.image.mask = nullptr;
  depth.image.confidence = doubt.data();
  depth.image.confidence_min = 2;
  EXPECT_EQ(wrong_heights(seen(depth.image), k_quarter, 0), 0u);
  depth.image.confidence_min = 1;  // the control
  EXPECT_EQ(wrong_heights(seen(depth.image), k_quarter), 0u);
}

TEST(Relief, AnImageTwiceIsOneLook) {
  DepthOfBox depth;
  sandglass::Relief relief = made();
  int32_t taken = 0;
  for (int look = 0; look < 8; ++look) {
    depth.image.timestamp_ns = 5;
    EXPECT_EQ(sandglass_relief_set_image(relief.get(), &depth.image, &taken, nullptr), SANDGLASS_OK);
    EXPECT_EQ(taken, look == 0 ? 1 : 0);
  }
  EXPECT_EQ(relief.heights().version, 0u);
  for (uint64_t look = 0; look < 4; ++look) {
    depth.image.timestamp_ns = 6 + look;
    EXPECT_TRUE(relief.set_image(depth.image));
  }
  EXPECT_EQ(relief.heights().version, 1u);
}

TEST(Relief, AnImageIsTheSameHoweverItIsStored) {
  DepthOfBox depth;
  const std::vector<float> plain = heights_of(seen(depth.image));
  std::vector<float> floats(k_width * k_height);  // the lower row first
  for (uint32_t i = 0; i < floats.size(); ++i) {
    const uint32_t row = k_height - 1 - i / k_width;
    floats[row * k_width + i % k_width] = static_cast<float>(depth.pixels[i]);
  }
  sandglass_depth_image stored = depth.image;
  stored.format = SANDGLASS_DEPTH_F32;
  stored.depth = floats.data() + (k_height - 1) * k_width;
  stored.stride = -4 * static_cast<int32_t>(k_width);
  EXPECT_EQ(heights_of(seen(stored)), plain);
  // What is no number is as a hole, in the middle of the box.
  std::vector<float> holed;
  for (const float none : {0.0f, -1.0f, std::nanf(""), std::numeric_limits<float>::infinity(), 1e30f}) {
    for (uint32_t x = 0; x < 24; ++x) floats[(k_height / 2 + x / 12) * k_width + k_width / 2 + x % 12] = none;
    const sandglass::Relief relief = seen(stored);
    if (holed.empty()) holed = heights_of(relief);
    EXPECT_EQ(heights_of(relief), holed) << none;
    EXPECT_LT(wrong_heights(relief, k_quarter), 40u) << none;
  }
  // The control: rows that are not where they are.
  stored.depth = floats.data();
  stored.stride = 4 * k_width;
  stored.position[2] += 0.05f;
  EXPECT_NE(heights_of(seen(stored)), plain);
}

TEST(Relief, TheWorldMayBeTurned) {
  const DepthOfBox depth;
  const float axis[3] = {0.3f, 1, -0.4f};
  sandglass::Rotation turn;
  ASSERT_EQ(sandglass_rotation_about(axis, 1.1f, turn.data()), 1);
  const float place[3] = {2, -1, 3};
  sandglass_depth_image turned = depth.image;
  const auto t = turn;
  const float *a = depth.image.orientation, y = static_cast<float>(k_camera_high);
  // The rotation's product, and the image of (0, y, 0).
  turned.orientation[0] = t[3] * a[0] + t[0] * a[3] + t[1] * a[2] - t[2] * a[1];
  turned.orientation[1] = t[3] * a[1] - t[0] * a[2] + t[1] * a[3] + t[2] * a[0];
  turned.orientation[2] = t[3] * a[2] + t[0] * a[1] - t[1] * a[0] + t[2] * a[3];
  turned.orientation[3] = t[3] * a[3] - t[0] * a[0] - t[1] * a[1] - t[2] * a[2];
  turned.position[0] = place[0] + y * 2 * (t[0] * t[1] - t[3] * t[2]);
  turned.position[1] = place[1] + y * (1 - 2 * (t[0] * t[0] + t[2] * t[2]));
  turned.position[2] = place[2] + y * 2 * (t[1] * t[2] + t[3] * t[0]);
  sandglass::Relief relief = made();
  EXPECT_TRUE(relief.set_plane(place, turn));
  for (int look = 0; look < 8; ++look) EXPECT_TRUE(relief.set_image(turned));
  EXPECT_EQ(wrong_heights(relief, 2 * k_quarter), 0u);
  const sandglass_heights h = relief.heights();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(h.corner[k] + 0.5f * (h.along[k] + h.across[k]), place[k], 1e-5f);
    EXPECT_NEAR(h.up[k], (turned.position[k] - place[k]) / y, 1e-5f);
  }
  sandglass::Relief unmoved = made();  // the control
  for (int look = 0; look < 8; ++look) EXPECT_TRUE(unmoved.set_image(turned));
  EXPECT_GT(wrong_heights(unmoved, 2 * k_quarter), 200u);
}

// A second device takes what each version has changed, and a later session all.
TEST(Relief, SavesWhatAnotherOneShows) {
  const DepthOfBox with, without(false);
  sandglass::Relief first = made(), second = made(), later = made();
  std::vector<std::byte> bytes, changes;
  uint64_t version = 0;
  for (int image = 0; image < 30; ++image) {
    EXPECT_TRUE(first.set_image(image < 12 ? with.image : without.image));
    if (first.heights().version == version) continue;
    version = first.heights().version;
    EXPECT_TRUE(first.save(&changes, false) && second.restore(changes));
    EXPECT_EQ(heights_of(second), heights_of(first)) << image;
    EXPECT_EQ(second.heights().version, version);
    if (version > 1) continue;
    EXPECT_LT(changes.size(), 1000u);  // of 32,816
    EXPECT_TRUE(first.save(&bytes));
    EXPECT_EQ(wrong_heights(second, k_quarter), 0u);
  }
  EXPECT_GE(version, 2u);
  // The changes alone of a version do not make up for one that was missed.
  EXPECT_TRUE(later.restore(changes));
  EXPECT_TRUE(later.restore(bytes));
  EXPECT_EQ(wrong_heights(later, k_quarter), 0u);
  // What was restored goes like what was seen.
  for (int image = 0; image < 12; ++image) EXPECT_TRUE(later.set_image(without.image));
  EXPECT_EQ(wrong_heights(later, k_quarter, 0), 0u);
}

TEST(Relief, RestoresWholeBytesOfItsOwnKindAlone) {
  const DepthOfBox depth;
  sandglass_relief_desc small = sandglass::relief_desc();
  small.cells[0] = 40;
  small.cells[1] = 16;
  sandglass::Relief relief = made(small);
  for (int look = 0; look < 8; ++look) EXPECT_TRUE(relief.set_image(depth.image));
  std::vector<std::byte> bytes;
  EXPECT_TRUE(relief.save(&bytes));
  expect_only_whole_taken(
      bytes, [&](const std::vector<std::byte>& data) { return static_cast<bool>(relief.restore(data)); }, 400);
  std::swap(small.cells[0], small.cells[1]);
  EXPECT_FALSE(made(small).restore(bytes));
  uint64_t written = 0;
  expect_refused(
      "bytes",
      [&](const char** reason) {
        return sandglass_relief_save(relief.get(), 1, bytes.data(), bytes.size() - 1, &written, reason);
      },
      SANDGLASS_ERROR_MEMORY_TOO_SMALL);
}

// A clock by which every frame is late: one unit a frame beside those that read the image.
TEST(Relief, AnyDivisionIntoFramesGivesTheSameBits) {
  const DepthOfBox depth;
  const sandglass::Relief whole = seen(depth.image, 6);
  sandglass::Relief parts = made();
  sandglass::Scene scene;
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = 64;
  uint64_t now = 0;
  desc.clock.now_ns = [](void* time) { return *static_cast<uint64_t*>(time) += 1000; };
  desc.clock.user = &now;
  ASSERT_TRUE(scene.create(desc));
  sandglass_frame_input input = sandglass::frame_input(0.016f, 0);
  input.relief = parts.get();
  uint32_t frames = 0, units = 0;
  for (int look = 0; look < 6; ++look) {
    sandglass_frame_report report = sandglass::frame_report();
    input.depth = &depth.image;
    do {
      ASSERT_TRUE(scene.frame(input, &report));
      input.depth = nullptr;
      units += report.stages[SANDGLASS_STAGE_RELIEF].units;
      ++frames;
    } while (report.stages[SANDGLASS_STAGE_RELIEF].denied != 0 && frames < 1000);
  }
  EXPECT_EQ(parts.hash(), whole.hash());
  EXPECT_EQ(heights_of(parts), heights_of(whole));
  // 12 units read 12,288 pixels, in the frame that takes them, and 12 gather them; 8 and 8 are of 16,384 cells.
  EXPECT_EQ(units, 6u * (12 + 12 + 8 + 8));
  EXPECT_GE(frames, 6u * 28);
  EXPECT_NE(seen(depth.image, 5).hash(), whole.hash());  // the control
}

// No libm has a part in what is hashed.
TEST(Relief, OneHashOnEveryMachine) {
  constexpr uint64_t k_golden = 0x5fa32739b54a9166ull;
  sandglass::Relief relief = made();
  DepthOfBox depth;
  for (uint32_t look = 0; look < 9; ++look) {
    for (uint32_t i = 0; i < depth.pixels.size(); ++i)
      depth.pixels[i] = static_cast<uint16_t>(depth.pixels[i] + (i * 7919 + look * 104729) % 5 - 2);
    depth.image.orientation[1] = 0.03125f * static_cast<float>(look % 3);
    depth.image.position[0] = 0.0625f * static_cast<float>(look % 2);
    EXPECT_TRUE(relief.set_image(depth.image));
  }
  const std::vector<float> heights = heights_of(relief);
  const uint64_t hash = sandglass::hash_with(relief.hash(), sandglass::hash_bytes(heights.data(), 4 * heights.size()));
  EXPECT_EQ(hash, k_golden) << std::hex << hash;
}

TEST(Relief, RefusesWhatItCannotUse) {
  sandglass::Relief relief = made();
  const DepthOfBox depth;
  const auto image = [&](const char* words, auto change) {
    sandglass_depth_image i = depth.image;
    change(&i);
    expect_refused(words,
                   [&](const char** reason) { return sandglass_relief_set_image(relief.get(), &i, nullptr, reason); });
  };
  image("struct_size", [](auto* i) { --i->struct_size; });
  image("format", [](auto* i) { i->format = 2; });
  image("width", [](auto* i) { i->width = 1; });
  image("height", [](auto* i) { i->height = SANDGLASS_CAMERA_SIDE_LIMIT + 1; });
  image("NULL", [](auto* i) { i->depth = nullptr; });
  image("stride", [](auto* i) { i->stride = 2 - i->stride; });
  image("confidence_stride", [&](auto* i) { i->confidence = depth.mask.data(); });
  image("mask_stride", [&](auto* i) { i->mask = depth.mask.data(); });
  for (const float none : {0.0f, -1.0f, std::nanf(""), 1e9f}) {
    image("to_metres", [&](auto* i) { i->to_metres = none; });
    image("focal_y", [&](auto* i) { i->focal_y = none; });
  }
  image("centre_x", [](auto* i) { i->centre_x = static_cast<float>(i->width); });
  image("position", [](auto* i) { i->position[1] = std::nanf(""); });
  image("orientation", [](auto* i) {
    for (float& x : i->orientation) x = 0;
  });
  const float place[3] = {0, 1001, 0}, none[4] = {}, turn[4] = {0, 0, 0, 1};
  expect_refused("position",
                 [&](const char** reason) { return sandglass_relief_set_plane(relief.get(), place, turn, reason); });
  expect_refused("rotation",
                 [&](const char** reason) { return sandglass_relief_set_plane(relief.get(), none, none, reason); });
  const auto desc = [&](const char* words, auto change) {
    sandglass_relief_desc d = sandglass::relief_desc();
    change(&d);
    uint64_t bytes = 0;
    expect_refused(words, [&](const char** reason) { return sandglass_relief_bytes(&d, &bytes, reason); });
  };
  desc("cells", [](auto* d) { d->cells[1] = 15; });
  desc("cells", [](auto* d) { d->cells[0] = 257; });
  desc("cell", [](auto* d) { d->cell = 0.001f; });
  desc("cell", [](auto* d) { d->cell = std::nanf(""); });
  EXPECT_EQ(relief.hash(), made().hash());  // nothing was changed
}

// In a frame an image that cannot be used is counted, and the log says why.
TEST(Relief, AFrameCountsWhatItCannotUse) {
  DepthOfBox depth;
  depth.image.focal_x = 0;
  sandglass::Relief relief = made();
  sandglass::Scene scene;
  sandglass_scene_desc desc = sandglass::scene_desc();
  std::string said;
  desc.log.user = &said;
  desc.log.write = [](void* to, const char* sentence) { *static_cast<std::string*>(to) = sentence; };
  ASSERT_TRUE(scene.create(desc));
  sandglass_frame_input input = sandglass::frame_input(0.016f, 0);
  input.relief = relief.get();
  input.depth = &depth.image;
  sandglass_frame_report report = sandglass::frame_report();
  ASSERT_TRUE(scene.frame(input, &report));
  EXPECT_EQ(report.estimator.ignored_images, 1u);
  EXPECT_NE(said.find("focal_x"), std::string::npos) << said;
  depth.image.focal_x = k_focal;  // the control
  ASSERT_TRUE(scene.frame(input, &report));
  EXPECT_EQ(report.estimator.ignored_images, 0u);
}

}  // namespace

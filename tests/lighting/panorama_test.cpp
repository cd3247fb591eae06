// The convention of panoramas, their tone mapping and their files.
#include "models/rooms/panorama.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/rooms/panorama_file.h"
#include "tests/refusal.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

void expect_near(Vec3 found, Vec3 expected, double tolerance) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

TEST(PanoramaConvention, CentreLooksAlongZAndRightIsMinusX) {
  expect_near(panorama_direction(31.5, 15.5, 64, 32), {0, 0, 1}, 1e-12);
  expect_near(panorama_direction(47.5, 15.5, 64, 32), {-1, 0, 0}, 1e-12);
  expect_near(panorama_direction(15.5, 15.5, 64, 32), {1, 0, 0}, 1e-12);
  expect_near(panorama_direction(31.5, -0.5, 64, 32), {0, 1, 0}, 1e-12);
}

TEST(PanoramaConvention, PlacesAndDirectionsAreInverse) {
  for (int v = 0; v < 16; ++v)
    for (int u = 0; u < 32; ++u) {
      const PanoramaPlace place = panorama_place(panorama_direction(u, v, 32, 16) * 3.0, 32, 16);
      EXPECT_NEAR(place.u, u, 1e-9);
      EXPECT_NEAR(place.v, v, 1e-9);
    }
}

TEST(PanoramaConvention, PixelsCoverTheSphere) {
  double sum = 0.0;
  for (int v = 0; v < 256; ++v) sum += 512 * pixel_solid_angle(v, 512, 256);
  EXPECT_NEAR(sum, 4.0 * std::numbers::pi, 1e-4);
}

// Radiance that is linear in the direction is reproduced to the second order of the pixel's size, also at seam and
// poles.
TEST(LookUp, LinearInDirection) {
  RadianceMap map(128, 64);
  const auto truth = [](Vec3 d) { return Vec3{2 + d.x, 2 + d.y, 2 + d.z}; };
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 128; ++u) map.set(u, v, truth(panorama_direction(u, v, 128, 64)));
  for (int i = 0; i < 500; ++i) {
    const Vec3 d = panorama_direction(std::fmod(i * 61.803, 128.0) - 0.5, std::fmod(i * 7.548, 64.0) - 0.5, 128, 64);
    expect_near(look_up(map, d), truth(d), 2e-3);
  }
}

TEST(ToneMapping, ReinhardExtended) {
  EXPECT_DOUBLE_EQ(tone_mapped_luminance(5.0, 5.0), 1.0);
  EXPECT_DOUBLE_EQ(tone_mapped_luminance(1.0, 2.0), 1.25 / 2.0);
  const Vec3 mapped = tone_mapped({4, 2, 1}, 10.0);
  EXPECT_NEAR(luminance(mapped), tone_mapped_luminance(luminance(Vec3{4, 2, 1}), 10.0), 1e-12);
  EXPECT_NEAR(mapped.x / mapped.z, 4.0, 1e-12);
  expect_near(tone_mapped({0, 0, 0}, 0.0), {0, 0, 0}, 0.0);
}

TEST(Tripod, BlackPixelsTakeTheLastAbove) {
  RadianceMap map(16, 8);
  for (int v = 0; v < 6; ++v)
    for (int u = 0; u < 16; ++u) map.set(u, v, {1.0 + u, 1.0 + v, 1.0});
  map.set(3, 1, {0, 0, 0});  // black above the horizon is dark, not the tripod
  fill_tripod(&map);
  expect_near(map.colour(5, 7), {6, 6, 1}, 0.0);
  expect_near(map.colour(5, 6), {6, 6, 1}, 0.0);
  expect_near(map.colour(3, 1), {0, 0, 0}, 0.0);
}

class PanoramaFiles : public ::testing::Test {
 protected:
  tests::TemporaryFolder folder;
  std::string path(const std::string& name) const { return folder / name; }
  static std::string refusal(const std::string& file) {
    return tests::refusal_of([&] { read_panorama(file); });
  }
  // The bytes of a small panorama's file.
  std::string whole() const {
    RadianceMap map(16, 8);
    for (size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = 0.1f + static_cast<float>(i % 7);
    write_hdr(path("whole.hdr"), map);
    return read_file(path("whole.hdr"), "panorama");
  }
};

TEST_F(PanoramaFiles, HdrRoundTrip) {
  RadianceMap map(32, 16);
  for (int v = 0; v < 16; ++v)
    for (int u = 0; u < 32; ++u) map.set(u, v, {std::pow(2.0, u - 16), 0.3 * std::pow(2.0, u - 16), 1e-3});
  write_hdr(path("a.hdr"), map);
  const RadianceMap back = read_panorama(path("a.hdr"));
  ASSERT_EQ(back.width, 32);
  for (int v = 0; v < 16; ++v)
    for (int u = 0; u < 32; ++u) {
      const Vec3 a = map.colour(u, v), b = back.colour(u, v);
      expect_near(b, a, std::max({a.x, a.y, a.z}) / 128.0);  // 8 bits of the largest channel
    }
}

TEST_F(PanoramaFiles, WhatIsNoPanoramaIsRefusedWithASentence) {
  EXPECT_NE(refusal(path("missing.hdr")).find("missing.hdr"), std::string::npos);
  EXPECT_NE(refusal(path("a.jpg")).find("neither .hdr nor .exr"), std::string::npos);
  write_file(path("text.hdr"), std::string_view("not a panorama\n"));
  EXPECT_NE(refusal(path("text.hdr")).find("not a Radiance"), std::string::npos);
  write_file(path("text.exr"), std::string_view("not a panorama"));
  EXPECT_NE(refusal(path("text.exr")).find("text.exr"), std::string::npos);
  RadianceMap square(16, 16);
  write_hdr(path("square.hdr"), square);
  EXPECT_NE(refusal(path("square.hdr")).find("twice as wide"), std::string::npos);
  write_hdr(path("black.hdr"), RadianceMap(32, 16));
  EXPECT_NE(refusal(path("black.hdr")).find("black"), std::string::npos);
}

TEST_F(PanoramaFiles, EveryTruncationIsRefused) {
  const std::string bytes = whole();
  for (size_t n = 0; n < bytes.size(); ++n) {
    write_file(path("cut.hdr"), std::string_view(bytes).substr(0, n));
    EXPECT_NE(refusal(path("cut.hdr")).find("cut.hdr"), std::string::npos) << n << " bytes";
  }
}

TEST_F(PanoramaFiles, EveryFlippedByteIsRefusedOrRead) {
  const std::string bytes = whole();
  for (size_t n = 0; n < bytes.size(); ++n)
    for (const int bit : {1, 128}) {
      std::string flipped = bytes;
      flipped[n] = static_cast<char>(flipped[n] ^ bit);
      write_file(path("flipped.hdr"), flipped);
      try {
        const RadianceMap read = read_panorama(path("flipped.hdr"));
        EXPECT_EQ(read.width, 2 * read.height);
      } catch (const Failure&) {
      }
    }
}

}  // namespace
}  // namespace sandglass::host

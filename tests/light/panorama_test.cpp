// The convention of panoramas, their tone mapping and their files.
#include "models/rooms/panorama.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/files/atomic_file.h"
#include "models/rooms/panorama_file.h"
#include "tests/light/made_panorama.h"
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
  const auto truth = [](Vec3 d) { return Vec3{2 + d.x, 2 + d.y, 2 + d.z}; };
  const RadianceMap map = tests::panorama_of(128, truth);
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

TEST(PanoramaFiles, HdrRoundTrip) {
  const tests::TemporaryFolder folder;
  RadianceMap map(32, 16);
  for (int v = 0; v < 16; ++v)
    for (int u = 0; u < 32; ++u) map.set(u, v, {std::pow(2.0, u - 16), 0.3 * std::pow(2.0, u - 16), 1e-3});
  write_hdr(folder / "a.hdr", map);
  const RadianceMap back = read_panorama(folder / "a.hdr");
  ASSERT_EQ(back.width, 32);
  for (int v = 0; v < 16; ++v)
    for (int u = 0; u < 32; ++u) {
      const Vec3 a = map.colour(u, v), b = back.colour(u, v);
      expect_near(b, a, std::max({a.x, a.y, a.z}) / 128.0);  // 8 bits of the largest channel
    }
}

// One bright pixel in an even room, in the ways in which programs write Radiance files.
TEST(PanoramaFiles, EveryKindOfHdrShowsTheSame) {
  constexpr int k_width = 64, k_height = 32, k_u = 48, k_v = 8;
  const std::string even("\x40\x80\xC0\x80", 4), lamp("\x80\x80\x80\x88", 4);  // .25 .5 .75, and 128
  const auto pixels = [&](bool mirrored, bool upside_down, const auto& repeated) {
    std::string all;
    for (int v = 0; v < k_height; ++v)
      for (int u = 0, run = 0; u < k_width; u += run) {
        const bool is_row = v == (upside_down ? k_height - 1 - k_v : k_v);
        const int at = mirrored ? k_width - 1 - k_u : k_u;
        run = is_row && u <= at ? (u == at ? 1 : at - u) : k_width - u;
        all += repeated(is_row && u == at ? lamp : even, run);
      }
    return all;
  };
  const auto plain = [](const std::string& pixel, int count) {
    std::string all;
    for (int i = 0; i < count; ++i) all += pixel;
    return all;
  };
  const auto old_runs = [](const std::string& pixel, int count) {
    return count == 1 ? pixel : pixel + "\1\1\1" + static_cast<char>(count - 1);
  };
  const std::string format = "FORMAT=32-bit_rle_rgbe\n", size = "\n-Y 32 +X 64\n", whole = pixels(false, false, plain);
  struct Kind {
    const char* name;
    std::string file;
    double exposure;
    Vec3 correction = {1, 1, 1};
  };
  const Kind kinds[] = {{"plain", "#?RADIANCE\n" + format + size + whole, 1},
                        {"old runs", "#?RADIANCE\n" + format + size + pixels(false, false, old_runs), 1},
                        {"returns", "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 32 +X 64\r\n" + whole, 1},
                        {"another program", "#?AUTOPANO\n" + format + size + whole, 1},
                        {"exposures", "#?RGBE\nEXPOSURE=4\n" + format + "EXPOSURE= 0.5\n" + size + whole, 2},
                        {"corrected", "#?RADIANCE\nCOLORCORR= 2 1 0.5\n" + format + size + whole, 1, {2, 1, 0.5}},
                        {"upwards", "#?RADIANCE\n" + format + "\n+Y 32 +X 64\n" + pixels(false, true, plain), 1},
                        {"leftwards", "#?RADIANCE\n" + format + "\n-Y 32 -X 64\n" + pixels(true, false, plain), 1}};
  const tests::TemporaryFolder folder;
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(kind.name);
    write_file(folder / "kind.hdr", std::string_view(kind.file));
    const RadianceMap map = read_panorama(folder / "kind.hdr");
    for (int v = 0; v < k_height; ++v)
      for (int u = 0; u < k_width; ++u) {
        const Vec3 shown = u == k_u && v == k_v ? Vec3{128, 128, 128} : Vec3{.25, .5, .75},
                   c = kind.correction * kind.exposure;
        expect_near(map.colour(u, v), {shown.x / c.x, shown.y / c.y, shown.z / c.z}, 1e-7);
      }
  }
}

TEST(PanoramaFiles, WhatIsNoPanoramaIsRefusedWithASentence) {
  const tests::TemporaryFolder folder;
  write_file(folder / "text.hdr", std::string_view("not a panorama\n"));
  write_file(folder / "text.exr", std::string_view("not a panorama"));
  write_hdr(folder / "square.hdr", RadianceMap(16, 16));
  write_hdr(folder / "black.hdr", RadianceMap(32, 16));
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";  // of pixels that take gigabytes and are not there
  write_file(folder / "huge_square.hdr", std::string_view(head + "-Y 16384 +X 16384\n"));
  write_file(folder / "huge.hdr", std::string_view(head + "-Y 8192 +X 16384\n" + std::string(1 << 20, '\2')));
  for (const auto& [file, words] :
       {std::pair("missing.hdr", "missing.hdr"), std::pair("a.jpg", "a.jpg"),
        std::pair("text.hdr", "neither Radiance .hdr nor OpenEXR"), std::pair("text.exr", "text.exr"),
        std::pair("square.hdr", "twice as wide"), std::pair("huge_square.hdr", "twice as wide"),
        std::pair("huge.hdr", "cut off"), std::pair("black.hdr", "black")}) {
    const std::string path = folder / file;  // clang 14 captures no structured binding
    tests::expect_refusal(words, [&] { read_panorama(path); });
  }
}

}  // namespace
}  // namespace sandglass::host

// The network's input against a camera model in double that turns rays, and so shares no method with the library's
// boxes per axis.
#include "runtime/light/network/resample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "models/rooms/excerpt.h"
#include "runtime/light/camera/transfer.h"
#include "runtime/math/random.h"
#include "tests/light/made_panorama.h"
#include "tests/reason.h"

namespace sandglass {
namespace {

constexpr size_t k_bytes = 3 * k_light_width * k_light_height;

struct Camera {
  CameraImage image;
  std::vector<uint8_t> bytes[3];

  Camera(sandglass_camera_format format, uint32_t width, uint32_t height, uint32_t padding, uint64_t seed) {
    sandglass_camera_image_default(&image);
    image.turn_deg = 0;
    image.format = format;
    image.width = width;
    image.height = height;
    image.focal_x = 0.8f * static_cast<float>(width);
    image.focal_y = 0.83f * static_cast<float>(width);
    image.centre_x = 0.47f * static_cast<float>(width);
    image.centre_y = 0.52f * static_cast<float>(height);
    const bool planar = format == SANDGLASS_CAMERA_I420, yuv = format >= SANDGLASS_CAMERA_NV12;
    const uint32_t rows[3] = {height, height / 2, height / 2};
    const uint32_t widths[3] = {format == SANDGLASS_CAMERA_RGB    ? 3 * width
                                : format == SANDGLASS_CAMERA_RGBA ? 4 * width
                                                                  : width,
                                planar ? width / 2 : width, width / 2};
    Random random = random_stream(seed, 1);
    for (uint32_t i = 0; i < (planar ? 3u : yuv ? 2u : 1u); ++i) {
      image.strides[i] = widths[i] + padding;
      bytes[i].assign(static_cast<size_t>(image.strides[i]) * rows[i], 0);
      for (uint8_t& b : bytes[i]) b = static_cast<uint8_t>(random.below(256));
      image.planes[i] = bytes[i].data();
    }
  }
  std::vector<uint8_t> resampled() const {
    std::vector<uint8_t> rgb(k_bytes);
    uint32_t sums[k_camera_sums];
    resample_camera_block(image, whole_camera_block(image), rgb.data(), sums);
    return rgb;
  }
  double channel(int x, int y, int c) const {
    const int step = image.format == SANDGLASS_CAMERA_RGBA ? 4 : 3;
    return bytes[0][static_cast<size_t>(y) * image.strides[0] + static_cast<size_t>(x * step + c)];
  }
};

// The mean over the box around the projected ray, with real weights.
double reference(const Camera& camera, int i, int j, int c) {
  const CameraImage& m = camera.image;
  const double x = (i - 127.5) / k_light_focal, y = (j - 95.5) / k_light_focal;
  // From the stored to the upright image, clockwise on the screen.
  const double turn = m.turn_deg * std::numbers::pi / 180.0;
  const double sx = std::cos(turn) * x + std::sin(turn) * y, sy = -std::sin(turn) * x + std::cos(turn) * y;
  const double u = m.focal_x * sx + m.centre_x, v = m.focal_y * sy + m.centre_y;
  const double half_u = 0.5 * std::max(1.0, m.focal_x / k_light_focal);
  const double half_v = 0.5 * std::max(1.0, m.focal_y / k_light_focal);
  const auto interval = [](double middle, double half, double size) {
    double low = middle + 0.5 - half, high = middle + 0.5 + half;
    if (high <= 0.0) return std::pair(0.0, 1.0);
    if (low >= size) return std::pair(size - 1.0, size);
    return std::pair(std::max(low, 0.0), std::min(high, size));
  };
  const auto [u0, u1] = interval(u, half_u, m.width);
  const auto [v0, v1] = interval(v, half_v, m.height);
  double sum = 0.0, area = 0.0;
  for (int q = static_cast<int>(v0); q < v1; ++q)
    for (int p = static_cast<int>(u0); p < u1; ++p) {
      const double w = (std::min<double>(p + 1, u1) - std::max<double>(p, u0)) *
                       (std::min<double>(q + 1, v1) - std::max<double>(q, v0));
      sum += w * camera.channel(p, q, c);
      area += w;
    }
  return sum / area;
}

TEST(CameraImage, FocalLengthIsThatOfTheDataSet) {
  EXPECT_NEAR(k_light_focal, host::focal_length(256, 192, 85.0), 1e-10);
  EXPECT_NEAR(2.0 * std::atan(160.0 / k_light_focal), 85.0 * std::numbers::pi / 180, 1e-12);  // of the diagonal
}

TEST(CameraImage, AgreesWithTheDoubleModelForEveryTurnAndSize) {
  for (const sandglass_camera_format format : {SANDGLASS_CAMERA_RGB, SANDGLASS_CAMERA_RGBA})
    for (const uint32_t turn : {0u, 90u, 180u, 270u})
      for (const auto& [width, height] : {std::pair(640u, 480u), std::pair(97u, 211u), std::pair(1280u, 720u)}) {
        Camera camera(format, width, height, 5, width + turn);
        camera.image.turn_deg = turn;
        const std::vector<uint8_t> rgb = camera.resampled();
        double worst = 0.0;
        for (int j = 0; j < 192; j += 7)
          for (int i = 0; i < 256; i += 5)
            for (int c = 0; c < 3; ++c)
              worst = std::max(worst,
                               std::fabs(reference(camera, i, j, c) - rgb[static_cast<size_t>(3 * (j * 256 + i) + c)]));
        // Half a step of rounding, and edges that are rounded to 1/256 pixel: at most 255/256 on each side of a box
        // that is one pixel wide.
        EXPECT_LE(worst, 0.5 + 2.0 * 255.0 / 256.0) << width << " x " << height << ", turned by " << turn;
      }
}

// The resampled image of a camera in a panorama equals that of the data set's camera: a pixel means the same ray in
// both.
TEST(CameraImage, SeesAPanoramaAsTheDataSetDoes) {
  const host::RadianceMap panorama = tests::panorama_of(512, [](host::Vec3 d) {
    return host::Vec3{0.5 + 0.4 * std::sin(5 * d.x), 0.5 + 0.4 * std::sin(5 * d.y), 0.5 + 0.4 * std::sin(5 * d.z)};
  });
  const host::View view = host::choose_views(2)[0];
  const host::RadianceMap expected = host::cut_excerpt(panorama, view);
  const host::RadianceMap photograph = host::cut_excerpt(panorama, view, 800, 600, 100.0);
  const auto focal = static_cast<float>(host::focal_length(800, 600, 100.0));
  for (const uint32_t turn : {0u, 90u}) {
    // The sensor stores the upright photograph turned the other way.
    Camera camera(SANDGLASS_CAMERA_RGB, turn == 0 ? 800 : 600, turn == 0 ? 600 : 800, 0, 1);
    for (int y = 0; y < 600; ++y)
      for (int x = 0; x < 800; ++x)
        for (int c = 0; c < 3; ++c) {
          const int u = turn == 0 ? x : y, v = turn == 0 ? y : 799 - x;
          camera.bytes[0][static_cast<size_t>(v) * camera.image.strides[0] + static_cast<size_t>(3 * u + c)] =
              static_cast<uint8_t>(std::lround(255.0 * photograph.at(x, y)[c]));
        }
    camera.image.turn_deg = turn;
    camera.image.focal_x = camera.image.focal_y = focal;
    camera.image.centre_x = 0.5f * static_cast<float>(camera.image.width - 1);
    camera.image.centre_y = 0.5f * static_cast<float>(camera.image.height - 1);
    const std::vector<uint8_t> rgb = camera.resampled();
    double worst = 0.0;
    for (int y = 0; y < 192; ++y)
      for (int x = 0; x < 256; ++x)
        for (int c = 0; c < 3; ++c)
          worst = std::max(worst,
                           std::fabs(255.0 * expected.at(x, y)[c] - rgb[static_cast<size_t>(3 * (y * 256 + x) + c)]));
    EXPECT_LE(worst, 2.0) << turn;
  }
}

TEST(CameraImage, YuvMatricesAgainstTheirDefinitions) {
  const struct {
    sandglass_yuv_range range;
    double kr, kb;
    bool video;
  } k_all[] = {{SANDGLASS_YUV_FULL_601, 0.299, 0.114, false},    {SANDGLASS_YUV_VIDEO_601, 0.299, 0.114, true},
               {SANDGLASS_YUV_FULL_709, 0.2126, 0.0722, false},  {SANDGLASS_YUV_VIDEO_709, 0.2126, 0.0722, true},
               {SANDGLASS_YUV_FULL_2020, 0.2627, 0.0593, false}, {SANDGLASS_YUV_VIDEO_2020, 0.2627, 0.0593, true}};
  for (const auto& [range, kr, kb, video] : k_all) {
    const double kg = 1.0 - kr - kb;
    for (int y = 0; y < 256; y += 15)
      for (int u = 0; u < 256; u += 17)
        for (int v = 0; v < 256; v += 17) {
          Camera camera(SANDGLASS_CAMERA_I420, 8, 8, 0, 1);
          camera.image.range = range;
          const int values[3] = {y, u, v};
          for (int i = 0; i < 3; ++i)
            std::fill(camera.bytes[i].begin(), camera.bytes[i].end(), static_cast<uint8_t>(values[i]));
          uint8_t rgb[k_bytes];
          uint32_t sums[k_camera_sums];
          resample_camera_block(camera.image, {0, 1, 0, 1}, rgb, sums);
          const double luma = video ? (y - 16) * 255.0 / 219.0 : y, chroma = video ? 255.0 / 224.0 : 1.0;
          const double pb = chroma * (u - 128), pr = chroma * (v - 128);
          const double expected[3] = {luma + 2 * (1 - kr) * pr,
                                      luma - 2 * kb * (1 - kb) / kg * pb - 2 * kr * (1 - kr) / kg * pr,
                                      luma + 2 * (1 - kb) * pb};
          for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], std::clamp(expected[c], 0.0, 255.0), 0.51);
        }
  }
}

TEST(CameraImage, YuvLayoutsOfOnePictureAgreeAndPaddingIsNotRead) {
  for (const uint32_t turn : {0u, 270u}) {
    Camera planar(SANDGLASS_CAMERA_I420, 320, 240, 7, 5), nv12(SANDGLASS_CAMERA_NV12, 320, 240, 13, 6),
        nv21(SANDGLASS_CAMERA_NV21, 320, 240, 0, 7);
    for (uint32_t y = 0; y < 240; ++y)
      for (Camera* other : {&nv12, &nv21})
        std::memcpy(other->bytes[0].data() + y * other->image.strides[0],
                    planar.bytes[0].data() + y * planar.image.strides[0], 320);
    for (uint32_t y = 0; y < 120; ++y)
      for (uint32_t x = 0; x < 160; ++x) {
        const uint8_t u = planar.bytes[1][y * planar.image.strides[1] + x],
                      v = planar.bytes[2][y * planar.image.strides[2] + x];
        nv12.bytes[1][y * nv12.image.strides[1] + 2 * x] = u;
        nv12.bytes[1][y * nv12.image.strides[1] + 2 * x + 1] = v;
        nv21.bytes[1][y * nv21.image.strides[1] + 2 * x] = v;
        nv21.bytes[1][y * nv21.image.strides[1] + 2 * x + 1] = u;
      }
    planar.image.turn_deg = nv12.image.turn_deg = nv21.image.turn_deg = turn;
    EXPECT_EQ(planar.resampled(), nv12.resampled());
    EXPECT_EQ(planar.resampled(), nv21.resampled());
  }
}

// One picture in every layout that phones have: with the lower row first, mirrored, by numbers of 16 bits, in planes whose
// chroma lies two bytes apart. All are resampled to the same bytes as the plain one.
TEST(CameraImage, EveryLayoutOfAPictureIsThatPicture) {
  constexpr int32_t k_w = 96, k_h = 64;
  Camera rgb(SANDGLASS_CAMERA_RGB, k_w, k_h, 4, 3), planar(SANDGLASS_CAMERA_I420, k_w, k_h, 4, 4);
  const auto resampled = [&](const CameraImage& image) {
    EXPECT_EQ(sandglass_camera_check(&image, nullptr), SANDGLASS_OK);
    Camera any = rgb;
    any.image = image;
    return any.resampled();
  };
  const std::vector<uint8_t> of_rgb = resampled(rgb.image), of_yuv = resampled(planar.image);
  EXPECT_NE(of_rgb, of_yuv);
  const auto pixel = [&](int32_t x, int32_t y) { return rgb.bytes[0].data() + y * rgb.image.strides[0] + 3 * x; };

  std::vector<uint8_t> bgra(size_t{4} * k_w * k_h), below(rgb.bytes[0].size()), mirror(rgb.bytes[0].size());
  for (int32_t y = 0; y < k_h; ++y)
    for (int32_t x = 0; x < k_w; ++x)
      for (int32_t c = 0; c < 3; ++c) {
        const uint8_t value = pixel(x, y)[c];
        bgra[static_cast<size_t>(4 * (y * k_w + x) + 2 - c)] = value;
        below[static_cast<size_t>((k_h - 1 - y) * rgb.image.strides[0] + 3 * x + c)] = value;
        mirror[static_cast<size_t>(y * rgb.image.strides[0] + 3 * (k_w - 1 - x) + c)] = value;
      }
  CameraImage image = rgb.image;
  image.format = SANDGLASS_CAMERA_BGRA;
  image.planes[0] = bgra.data();
  image.strides[0] = 4 * k_w;
  EXPECT_EQ(resampled(image), of_rgb);
  image = rgb.image;
  image.planes[0] = below.data() + (k_h - 1) * rgb.image.strides[0];
  image.strides[0] = -rgb.image.strides[0];
  EXPECT_EQ(resampled(image), of_rgb);
  image = rgb.image;
  image.planes[0] = mirror.data();
  image.centre_x = static_cast<float>(k_w - 1) - rgb.image.centre_x;
  EXPECT_NE(resampled(image), of_rgb) << "the control: taken for what it is not";
  image.mirrored = 1;
  const std::vector<uint8_t> mirrored = resampled(image);
  for (size_t i = 0; i < mirrored.size(); ++i)
    ASSERT_NEAR(mirrored[i], of_rgb[i], 1) << i;  // boxes are rounded to 1/256

  // The planes end with their last sample: nothing behind it is read (under sanitizers).
  const size_t row = 2 * k_w + 8;
  std::vector<uint8_t> pairs(k_w * k_h / 2), luma16(row * k_h), pairs16(row * k_h / 2);
  for (int32_t y = 0; y < k_h; ++y)
    for (int32_t x = 0; x < k_w; ++x) {
      const auto at = static_cast<size_t>(y) * row + static_cast<size_t>(2 * x);
      luma16[at] = 0xc0;  // the two lowest of ten bits
      luma16[at + 1] = planar.bytes[0][static_cast<size_t>(y * planar.image.strides[0] + x)];
      if (y >= k_h / 2 || x >= k_w / 2) continue;
      for (size_t c = 0; c < 2; ++c) {
        const uint8_t value = planar.bytes[1 + c][static_cast<size_t>(y * planar.image.strides[1 + c] + x)];
        pairs[static_cast<size_t>(y * k_w + 2 * x) + c] = value;
        pairs16[static_cast<size_t>(y) * row + static_cast<size_t>(4 * x) + 2 * c + 1] = value;
      }
    }
  image = planar.image;
  image.chroma_step = 2;  // Android's planes U and V, one byte apart; each ends a byte before the other's last
  for (const bool v_first : {false, true}) {
    std::vector<uint8_t> chroma = pairs;
    for (size_t i = 0; v_first && i < chroma.size(); i += 2) std::swap(chroma[i], chroma[i + 1]);
    image.planes[1] = chroma.data() + (v_first ? 1 : 0);
    image.planes[2] = chroma.data() + (v_first ? 0 : 1);
    image.strides[1] = image.strides[2] = k_w;
    EXPECT_EQ(resampled(image), of_yuv) << v_first;
  }
  image = planar.image;
  image.format = SANDGLASS_CAMERA_P010;
  image.planes[0] = luma16.data();
  image.planes[1] = pairs16.data();
  image.strides[0] = image.strides[1] = static_cast<int32_t>(row);
  EXPECT_EQ(resampled(image), of_yuv);
}

// Luma and chroma ramps that are in step stay in step: chroma samples lie between pairs of luma samples.
TEST(CameraImage, ChromaIsNotShifted) {
  Camera camera(SANDGLASS_CAMERA_I420, 256, 192, 0, 1);
  camera.image.focal_x = camera.image.focal_y = static_cast<float>(k_light_focal);
  camera.image.centre_x = 127.5f;
  camera.image.centre_y = 95.5f;
  std::fill(camera.bytes[0].begin(), camera.bytes[0].end(), static_cast<uint8_t>(128));
  std::fill(camera.bytes[1].begin(), camera.bytes[1].end(), static_cast<uint8_t>(128));
  for (size_t y = 0; y < 96; ++y)
    for (size_t x = 0; x < 128; ++x) camera.bytes[2][y * 128 + x] = static_cast<uint8_t>(88 + x / 2);  // V along x
  const std::vector<uint8_t> rgb = camera.resampled();
  for (int x = 8; x < 248; ++x) {
    const double v = 88 + ((x - 0.5) / 2.0 - 0.5) / 2.0;  // a step of 1 every four pixels, about their middle
    EXPECT_NEAR(rgb[static_cast<size_t>(3 * (90 * 256 + x))], 128 + 1.402 * (v - 128), 1.6) << x;
  }
}

TEST(CameraImage, BlocksInAnyOrderAreTheWhole) {
  for (const auto& [format, width, height] :
       {std::tuple(SANDGLASS_CAMERA_RGBA, 500u, 333u), std::tuple(SANDGLASS_CAMERA_NV21, 640u, 480u),
        std::tuple(SANDGLASS_CAMERA_RGBA, 16384u, 300u), std::tuple(SANDGLASS_CAMERA_I420, 16384u, 300u)})
    for (const uint32_t turn : {0u, 90u, 180u, 270u}) {
      if (SANDGLASS_EMULATED && width > 1000 && turn != 90) continue;
      Camera camera(format, width, height, 3, 9);
      camera.image.turn_deg = turn;
      std::vector<uint8_t> rgb(k_bytes);
      uint32_t sums[k_camera_sums];
      const CameraBlocks blocks = camera_blocks(camera.image);
      EXPECT_EQ(blocks.across > 1, width > 1000);
      for (uint32_t i = blocks.count; i-- > 0;)
        resample_camera_block(camera.image, camera_block(camera.image, blocks, i), rgb.data(), sums);
      EXPECT_EQ(rgb, camera.resampled()) << width << " turned by " << turn;
    }
}

// The bound of a unit at every size, format, focal length and turn that is accepted. A block reads no more than it may,
// the blocks cover every pixel of the output once, and for an image that is small enough they are whole rows.
TEST(CameraImage, NoBlockReadsMoreThanItMay) {
  Random random = random_stream(31, 2);
  for (int trial = 0; trial < 4000; ++trial) {
    const auto length = [&](double low, double high) { return low * std::pow(high / low, random.uniform()); };
    CameraImage image;
    sandglass_camera_image_default(&image);
    image.format = static_cast<sandglass_camera_format>(random.below(5));
    image.width = trial % 4 == 0 ? SANDGLASS_CAMERA_SIDE_LIMIT
                                 : static_cast<uint32_t>(length(2.0, SANDGLASS_CAMERA_SIDE_LIMIT)) & ~1u;
    image.height = static_cast<uint32_t>(length(2.0, SANDGLASS_CAMERA_SIDE_LIMIT)) & ~1u;
    image.focal_x = static_cast<float>(length(1.0, 1e6));
    image.focal_y = static_cast<float>(length(1.0, 1e6));
    image.turn_deg = 90 * random.below(4);
    const CameraBlocks blocks = camera_blocks(image);
    const CameraBlock whole = whole_camera_block(image);
    // In bytes: each output pixel reads the rows and columns of a box, and a row has no more columns than the image.
    const bool rgb = image.format == SANDGLASS_CAMERA_RGB, rgba = image.format == SANDGLASS_CAMERA_RGBA;
    const double pixel = rgb ? 3.0 : rgba ? 4.0 : 2.0;
    const double down = std::clamp(image.focal_y / k_light_focal, 1.0, 16.0) + 1.0;
    const double across = std::clamp(image.focal_x / k_light_focal, 1.0, 1024.0) + 1.0;
    const double reads = pixel * blocks.rows * down * std::min<double>(image.width, blocks.columns * across);
    ASSERT_LE(reads, 256.0 * 1024.0 * (1.0 + 1.0 / 2.0))
        << "the limit has half as much again, for the parts of pixels at the edges of boxes";
    ASSERT_LE(blocks.bytes, k_camera_block_bytes);
    if (pixel * image.width * down <= 256.0 * 1024.0) {
      ASSERT_EQ(blocks.columns, whole.columns);
    }
    uint64_t pixels = 0;
    for (uint32_t i = 0; i < blocks.count; ++i) {
      const CameraBlock block = camera_block(image, blocks, i);
      ASSERT_LE(block.first_row + block.rows, whole.rows);
      ASSERT_LE(block.first_column + block.columns, whole.columns);
      ASSERT_GT(block.rows * block.columns, 0u);
      pixels += uint64_t{block.rows} * block.columns;
    }
    ASSERT_EQ(pixels, uint64_t{256} * 192);
  }
}

TEST(CameraImage, BeyondTheCamerasViewIsTheEdgesColour) {
  Camera camera(SANDGLASS_CAMERA_RGB, 64, 48, 0, 4);
  camera.image.focal_x = camera.image.focal_y = 200.0f;  // far narrower than the network's view
  camera.image.centre_x = 31.5f;
  camera.image.centre_y = 23.5f;
  const std::vector<uint8_t> rgb = camera.resampled();
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(rgb[static_cast<size_t>(c)], camera.channel(0, 0, c));
    EXPECT_EQ(rgb[k_bytes - 3 + static_cast<size_t>(c)], camera.channel(63, 47, c));
  }
  camera.image.centre_x = 9e5f;  // looks past the whole image
  camera.image.centre_y = -9e5f;
  const std::vector<uint8_t> beside = camera.resampled();
  for (size_t i = 0; i < k_bytes; ++i) ASSERT_EQ(beside[i], camera.channel(63, 0, static_cast<int>(i % 3)));
}

TEST(CameraImage, WhatIsWrongIsRefusedWithASentence) {
  const Camera good(SANDGLASS_CAMERA_NV12, 64, 48, 0, 1);
  EXPECT_EQ(sandglass_camera_check(&good.image, nullptr), SANDGLASS_OK);
  const auto refused = [&](const char* words, void (*spoil)(CameraImage&)) {
    CameraImage image = good.image;
    spoil(image);
    tests::expect_refused(words, [&](const char** reason) { return sandglass_camera_check(&image, reason); });
  };
  refused("struct_size", [](CameraImage& i) { i.struct_size = 0; });
  refused("2 x 2", [](CameraImage& i) { i.width = i.height = 1; });
  refused("16384", [](CameraImage& i) { i.width = 16385; });
  refused("odd", [](CameraImage& i) { i.height = 47; });
  refused("stride", [](CameraImage& i) { i.strides[0] = 63; });
  refused("stride", [](CameraImage& i) { i.strides[1] = 32; });
  refused("NULL", [](CameraImage& i) { i.planes[0] = nullptr; });
  refused("NULL", [](CameraImage& i) { i.planes[1] = nullptr; });
  refused("turn", [](CameraImage& i) { i.turn_deg = 45; });
  refused("focal", [](CameraImage& i) { i.focal_x = NAN; });
  refused("focal", [](CameraImage& i) { i.focal_y = 0.0f; });
  refused("principal", [](CameraImage& i) { i.centre_y = INFINITY; });
  refused("principal", [](CameraImage& i) { i.centre_x = i.centre_y = 0; });
  refused("principal", [](CameraImage& i) { i.centre_x = 64; });
  refused("stride", [](CameraImage& i) { i.strides[0] = -63; });
  refused("chroma_step", [](CameraImage& i) { i.chroma_step = 2; });
  refused("mirrored", [](CameraImage& i) { i.mirrored = 2; });
  refused("orientation", [](CameraImage& i) { i.orientation[3] = 0.0f; });
  refused("orientation", [](CameraImage& i) { i.orientation[0] = INFINITY; });
  refused("upright", [](CameraImage& i) {
    i.turn_deg = SANDGLASS_TURN_FROM_POSE;
    i.pose_is_upright = 1;
  });
  refused("format", [](CameraImage& i) { i.format = 9; });
  refused("format", [](CameraImage& i) { i.format = -1; });
  refused("range", [](CameraImage& i) { i.range = 9; });
  refused("transfer", [](CameraImage& i) { i.transfer = 5; });
  for (const float gain : {-1.0f, 0.0f, NAN, 17.0f, INFINITY})
    for (int c = 0; c < 3; ++c) {
      CameraImage wrong = good.image;
      for (float& g : wrong.gains) g = 2.0f;
      EXPECT_EQ(sandglass_camera_check(&wrong, nullptr), SANDGLASS_OK);
      wrong.gains[c] = gain;
      tests::expect_refused("gains", [&](const char** reason) { return sandglass_camera_check(&wrong, reason); });
    }
  static const float rises[66] = {0, 0, 1, 1}, falls[4] = {0, 1, 1, 0}, stays[4] = {0, 0.5f, 1, 0.5f};
  const auto of_curve = [](CameraImage& i, const float* curve, uint32_t points) {
    i.transfer = SANDGLASS_TRANSFER_CURVE;
    i.curve = curve;
    i.curve_points = points;
  };
  CameraImage curved = good.image;
  of_curve(curved, rises, 2);
  EXPECT_EQ(sandglass_camera_check(&curved, nullptr), SANDGLASS_OK);
  refused("curve", [](CameraImage& i) { i.transfer = SANDGLASS_TRANSFER_CURVE; });
  refused("curve", [](CameraImage& i) { i.curve = rises; });
  refused("curve", [](CameraImage& i) { i.curve_points = 2; });
  for (const auto& [curve, points] : {std::pair(rises, 0u), {rises, 1u}, {rises, 33u}, {falls, 2u}, {stays, 2u}}) {
    of_curve(curved, curve, points);
    tests::expect_refused("curve", [&](const char** reason) { return sandglass_camera_check(&curved, reason); });
  }
}

// Against the functions of ITU-R BT.2100 and IEC 61966-2-1 from light to value, which the library has not.
TEST(CameraImage, EveryTransferIsUndone) {
  CameraImage image = Camera(SANDGLASS_CAMERA_RGB, 8, 8, 0, 1).image;
  const auto light_of = [&](int value) {
    return static_cast<double>(camera_light(image, camera_light_table(image), static_cast<uint8_t>(value)));
  };
  const std::pair<sandglass_transfer, double (*)(double)> k_codes[] = {
      {SANDGLASS_TRANSFER_SRGB,
       [](double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }},
      {SANDGLASS_TRANSFER_LINEAR, [](double x) { return x; }},
      {SANDGLASS_TRANSFER_HLG,
       [](double x) {  // white, 1, is 0.75
         const double e = x * (std::exp((0.75 - 0.55991073) / 0.17883277) + 0.28466892) / 12;
         return e <= 1.0 / 12 ? std::sqrt(3 * e) : 0.17883277 * std::log(12 * e - 0.28466892) + 0.55991073;
       }},
      {SANDGLASS_TRANSFER_PQ, [](double x) {
         const double y = std::pow(x * 203 / 10000, 2610.0 / 16384);
         return std::pow((3424.0 / 4096 + 2413.0 / 128 * y) / (1 + 2392.0 / 128 * y), 2523.0 / 32);
       }}};
  for (const auto& [transfer, code] : k_codes) {
    image.transfer = transfer;
    for (int value = 0; value < 256; ++value) EXPECT_NEAR(code(light_of(value)), value / 255.0, 2e-6) << transfer;
  }
  // Below its first point a curve is its first light, above its last its last.
  const float curve[] = {0.05f, 0.2f, 0.1f, 0.6f, 0.5f, 0.6f, 0.9f, 0.8f};
  image.transfer = SANDGLASS_TRANSFER_CURVE;
  image.curve = curve;
  image.curve_points = 4;
  const std::pair<int, double> k_points[] = {
      {0, 0.05}, {51, 0.05}, {102, 0.075}, {153, 0.1}, {178, 0.5 + 0.4 * 25 / 51}, {230, 0.9}};
  for (const auto& [value, light] : k_points) EXPECT_NEAR(light_of(value), light, 1e-6);
}

// The network was trained on sRGB: it sees the sRGB value nearest to the light, and white beyond it.
TEST(CameraImage, TheNetworkSeesSrgb) {
  CameraImage image = Camera(SANDGLASS_CAMERA_RGB, 8, 8, 0, 1).image;
  for (const sandglass_transfer transfer : {SANDGLASS_TRANSFER_LINEAR, SANDGLASS_TRANSFER_HLG, SANDGLASS_TRANSFER_PQ}) {
    image.transfer = transfer;
    for (int value = 0; value < 256; ++value) {
      const auto code = static_cast<uint8_t>(value);
      uint8_t seen = code;
      camera_to_srgb(image, &seen, 1);
      const auto light = static_cast<double>(std::min(1.0f, camera_light(image, camera_light_table(image), code)));
      const auto off = [&](int byte) { return std::fabs(srgb_light(static_cast<uint8_t>(byte)) - light); };
      EXPECT_LE(off(seen), off(seen > 0 ? seen - 1 : 0) + 1e-7);
      EXPECT_LE(off(seen), off(seen < 255 ? seen + 1 : 255) + 1e-7);
    }
  }
}

// A phone held straight down trembles: up is hardly anywhere in its image. It keeps the turn that it had; the control takes
// each in turn. Half a quarter turn on it still does, and then takes the other.
TEST(CameraImage, APhoneHeldStraightDownKeepsItsTurn) {
  CameraImage image = Camera(SANDGLASS_CAMERA_RGB, 64, 48, 0, 1).image;
  image.turn_deg = SANDGLASS_TURN_FROM_POSE;
  const auto look = [&](double pitch, double roll) {  // degrees: -90 is down
    const double p = pitch * std::numbers::pi / 360, r = roll * std::numbers::pi / 360;
    const double x = std::sin(p), w = std::cos(p), z = std::sin(r), c = std::cos(r);
    const double q[4] = {x * c, -x * z, w * z, w * c};
    for (int k = 0; k < 4; ++k) image.orientation[k] = static_cast<float>(q[k]);
  };
  uint32_t turn = SANDGLASS_TURN_FROM_POSE, changes = 0, alone = 0, last = 0;
  for (int i = 0; i < 40; ++i) {
    look(i == 0 ? -60 : -90 + 4 * std::sin(1.7 * i), 30 * std::sin(0.9 * i));
    const uint32_t before = turn;
    turn = with_turn(image, turn).turn_deg;
    changes += i > 0 && turn != before ? 1 : 0;
    alone += with_turn(image).turn_deg != last ? 1 : 0;
    last = with_turn(image).turn_deg;
  }
  EXPECT_EQ(changes, 0u);
  EXPECT_GT(alone, 5u);
  look(0, 50);
  EXPECT_EQ(with_turn(image, 0).turn_deg, 0u);
  look(0, 80);
  EXPECT_NE(with_turn(image, 0).turn_deg, 0u);
}

// The vector v turned by a unit quaternion.
host::Vec3 turned(const float q[4], host::Vec3 v) {
  const host::Vec3 u = {q[0], q[1], q[2]};
  const auto cross = [](host::Vec3 a, host::Vec3 b) {
    return host::Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const host::Vec3 t = cross(u, v) * 2.0;
  return v + t * q[3] + cross(u, t);
}

TEST(CameraPose, MatricesBecomeQuaternionsThatTurnTheSameWay) {
  const float half = std::sqrt(0.5f);
  // Columns: where the camera's x, y and z axes point in the world.
  const float matrices[4][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1},
                                 {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1},
                                 {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1},
                                 {half, half, 0, 0, 0, 0, 1, 0, half, -half, 0, 0, 0, 0, 0, 1}};
  for (const auto& m : matrices) {
    float q[4];
    ASSERT_EQ(sandglass_camera_orientation(m, q), 1);
    for (int axis = 0; axis < 3; ++axis) {
      const host::Vec3 unit = {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
      const host::Vec3 expected = {m[4 * axis], m[4 * axis + 1], m[4 * axis + 2]};
      EXPECT_NEAR(host::length(turned(q, unit) - expected), 0.0, 1e-6);
    }
  }
  float q[4];
  const float mirror[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
  const float broken[16] = {NAN, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_EQ(sandglass_camera_orientation(mirror, q), 0);
  EXPECT_EQ(sandglass_camera_orientation(broken, q), 0);
  EXPECT_EQ(q[3], 1.0f);
}

TEST(CameraPose, FocalLengthOfAFieldOfView) {
  EXPECT_NEAR(sandglass_camera_focal(256, 192, 85.0f), 160.0 / std::tan(42.5 * std::numbers::pi / 180), 1e-4);
  EXPECT_EQ(sandglass_camera_focal(256, 192, 180.0f), 0.0f);
  EXPECT_EQ(sandglass_camera_focal(256, 192, NAN), 0.0f);
}

}  // namespace
}  // namespace sandglass

// Panoramas as OpenEXR files, which the OpenEXR library writes here with the compressions that Blender and cameras use.
#include <ImfArray.h>
#include <ImfRgbaFile.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "models/files/failure.h"
#include "models/rooms/panorama_file.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

void write_exr(const std::string& path, int width, int height, Imf::Compression compression,
               Imf::RgbaChannels channels) {
  Imf::Array2D<Imf::Rgba> pixels(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      pixels[v][u] = Imf::Rgba(static_cast<float>(u) + 0.5f, static_cast<float>(v) + 0.25f, 4096.0f, 1.0f);
  Imf::Header header(width, height);
  header.compression() = compression;
  Imf::RgbaOutputFile file(path.c_str(), header, channels);
  file.setFrameBuffer(&pixels[0][0], 1, static_cast<size_t>(width));
  file.writePixels(height);
}

TEST(Exr, HalfFloatsAreReadExactly) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "panorama.exr";
  for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    write_exr(path, 32, 16, compression, Imf::WRITE_RGBA);
    const RadianceMap map = read_panorama(path);
    ASSERT_EQ(map.width, 32);
    ASSERT_EQ(map.height, 16);
    for (int v = 0; v < 16; ++v)
      for (int u = 0; u < 32; ++u) {
        EXPECT_EQ(map.colour(u, v).x, u + 0.5);
        EXPECT_EQ(map.colour(u, v).y, v + 0.25);
        EXPECT_EQ(map.colour(u, v).z, 4096.0);
      }
  }
}

// A renderer stored a part of the picture, or more than it.
TEST(Exr, TheDataLieWhereTheirWindowSays) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "window.exr";
  for (const Imath::Box2i& data : {Imath::Box2i({16, 0}, {31, 7}), Imath::Box2i({-4, -2}, {35, 17})}) {
    Imf::Header header(Imath::Box2i({0, 0}, {31, 15}), data);
    const int width = data.max.x - data.min.x + 1, height = data.max.y - data.min.y + 1;
    Imf::Array2D<Imf::Rgba> pixels(height, width);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        pixels[v][u] =
            Imf::Rgba(static_cast<float>(data.min.x + u + 8), static_cast<float>(data.min.y + v + 8), 1.0f, 1.0f);
    {
      Imf::RgbaOutputFile file(path.c_str(), header, Imf::WRITE_RGBA);
      const std::ptrdiff_t origin = data.min.x + data.min.y * std::ptrdiff_t{width};
      file.setFrameBuffer(&pixels[0][0] - origin, 1, static_cast<size_t>(width));
      file.writePixels(height);
    }
    const RadianceMap map = read_panorama(path);
    ASSERT_EQ(map.width, 32);
    for (int v = 0; v < 16; ++v)
      for (int u = 0; u < 32; ++u) {
        const bool is_stored = data.intersects(Imath::V2i(u, v));
        EXPECT_EQ(map.colour(u, v).x, is_stored ? u + 8.0 : 0.0) << u << " " << v;
        EXPECT_EQ(map.colour(u, v).y, is_stored ? v + 8.0 : 0.0) << u << " " << v;
      }
  }
}

TEST(Exr, WithoutColourOrOfAnotherShapeIsRefused) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "odd.exr";
  write_exr(path, 32, 16, Imf::ZIP_COMPRESSION, Imf::WRITE_Y);
  EXPECT_THROW(read_panorama(path), Failure);
  write_exr(path, 32, 32, Imf::ZIP_COMPRESSION, Imf::WRITE_RGB);
  EXPECT_THROW(read_panorama(path), Failure);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_THROW(read_panorama(path), Failure);
}

}  // namespace
}  // namespace sandglass::host

#include "tests/lighting/light_fixture.h"

#include <gtest/gtest.h>

#include "models/lighting/light_file.h"
#include "runtime/core/random.h"

namespace sandglass::tests {

namespace {
uint64_t need(const sandglass_light_desc& desc) {
  uint64_t bytes = 0;
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_light_bytes(&desc, &bytes, &reason), SANDGLASS_OK) << reason;
  return bytes;
}

}  // namespace

const AssetFile& random_light() {
  static const AssetFile file(host::light_file_bytes(host::random_light_file(7)));
  return file;
}

sandglass_light_desc describe_light() {
  sandglass_light_desc desc;
  sandglass_light_desc_default(&desc);
  desc.asset = random_light().data();
  desc.asset_bytes = random_light().bytes;
  return desc;
}

TestImage::TestImage(uint64_t seed, uint32_t width, uint32_t height) : bytes(3 * size_t{width} * height) {
  sandglass_camera_image_default(&image);
  image.format = SANDGLASS_CAMERA_RGB;
  image.width = width, image.height = height;
  image.planes[0] = bytes.data(), image.strides[0] = 3 * width;
  image.focal_x = image.focal_y = sandglass_camera_focal(width, height, 85.0f);
  image.centre_x = 0.5f * static_cast<float>(width - 1), image.centre_y = 0.5f * static_cast<float>(height - 1);
  Random random = random_stream(seed, 4);
  uint32_t cells[3][8][8];
  for (auto& channel : cells)
    for (auto& row : channel)
      for (uint32_t& cell : row) cell = random.below(256);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (uint32_t c = 0; c < 3; ++c)
        bytes[3 * (size_t{y} * width + x) + c] =
            static_cast<uint8_t>((cells[c][8 * y / height][8 * x / width] + 255 * x / width) / 2);
}

LiveLight::LiveLight(const sandglass_light_desc& desc) : block(need(desc)) {
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_light_create(&desc, block.data(), block.bytes(), &light, &reason), SANDGLASS_OK) << reason;
}

void LiveLight::estimate(const sandglass_camera_image& image) {
  uint32_t taken = 0;
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_light_set_image(light, &image, &taken, &reason), SANDGLASS_OK) << reason;
  ASSERT_EQ(taken, 1u);
  finish();
}

void LiveLight::finish() {
  while (sandglass_light_run(light, 1000) != 0) {
  }
}

sandglass_light_estimate LiveLight::get() const {
  sandglass_light_estimate e = {};
  e.struct_size = sizeof e;
  sandglass_light_get(light, &e);
  return e;
}
sandglass_light_estimate LiveLight::latest() const {
  sandglass_light_estimate e = {};
  e.struct_size = sizeof e;
  sandglass_light_get_latest(light, &e);
  return e;
}

}  // namespace sandglass::tests

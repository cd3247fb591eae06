#include "tests/light/light_fixture.h"
#include "tests/camera_picture.h"

#include "models/lighting/light_file.h"
#include "runtime/math/random.h"

namespace sandglass::tests {

const AssetFile& random_light() {
  static const AssetFile file(host::light_file_bytes(host::random_light_file(7)));
  return file;
}

sandglass_estimator_desc describe_light() {
  sandglass_estimator_desc desc = estimator_desc();
  desc.asset = random_light().data();
  desc.asset_bytes = random_light().bytes;
  return desc;
}

TestImage::TestImage(uint64_t seed, uint32_t width, uint32_t height) : bytes(3 * size_t{width} * height) {
  image = camera_picture(bytes.data(), width, height, sandglass_camera_focal(width, height, 85.0f));
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

}  // namespace sandglass::tests

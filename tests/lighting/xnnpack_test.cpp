// The peer of the lighting benchmark computes the same network: in float what the file says without any rounding, in
// bytes the own kernels' features but for its rounding. So its times are those of the same work, here and, under
// emulation, on ARM.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "models/host/random.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/xnnpack_peer.h"
#include "tests/lighting/byte_network.h"

namespace sandglass::host {
namespace {

std::vector<uint8_t> noise(int width, int height) {
  std::vector<uint8_t> rgb(static_cast<size_t>(3 * width * height));
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(256 * random_unit(i));
  return rgb;
}

TEST(XnnpackPeer, InFloatIsTheFileWithoutRounding) {
  constexpr int k_width = 64, k_height = 32;
  const LightFile file = random_light_file(7);
  const std::vector<uint8_t> rgb = noise(k_width, k_height);
  LightRunner runner(light_file_bytes(file), "random", SANDGLASS_ISA_AUTOMATIC, k_width, k_height);
  XnnpackLightPeer peer(runner.asset(), false, k_width, k_height);
  peer.run(rgb);
  const std::vector<float> features = peer.features();

  const tests::Map<double> map = tests::last_map<double>(file, rgb, k_width, k_height);
  const int pixels = map.width * map.height;
  double worst = 0, size = 0;
  for (int c = 0; c < map.channels; ++c) {
    double sum = 0;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) sum += map.at(x, y, c);
    const auto i = static_cast<size_t>(c);
    const double scale = static_cast<double>(file.feature_scale[i]);
    const double truth = scale * (sum / pixels) + static_cast<double>(file.feature_shift[i]);
    // In units of the range that a byte has: 1e-3, as the float network of the project against PyTorch.
    worst = std::max(worst, std::fabs(static_cast<double>(features[i]) - truth) / (255 * std::fabs(scale)));
    size = std::max(size, sum / pixels);
  }
  EXPECT_LE(worst, 1e-3);
  EXPECT_GT(size, 16.0) << "features that say something";
  std::printf("greatest difference of 1024 features: %.2g of their range\n", worst);
}

// Of two networks; in the shipped one some channels have multipliers of thousands.
class XnnpackPeerInBytes : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(, XnnpackPeerInBytes, testing::Bool(),
                         [](const auto& network) { return network.param ? "Shipped" : "Random"; });
TEST_P(XnnpackPeerInBytes, IsTheOwnNetworkButForItsRounding) {
  constexpr int k_width = 64, k_height = 32;
  const std::vector<uint8_t> rgb = noise(k_width, k_height);
  std::ifstream shipped(SANDGLASS_LIGHTS_DIR "/room.light", std::ios::binary);
  const std::vector<uint8_t> file = GetParam() ? std::vector<uint8_t>(std::istreambuf_iterator<char>(shipped), {})
                                               : light_file_bytes(random_light_file(7));
  LightRunner runner(file, "network", SANDGLASS_ISA_AUTOMATIC, k_width, k_height);
  runner.run(rgb);
  const std::vector<float> own = runner.features();
  XnnpackLightPeer peer(runner.asset(), true, k_width, k_height);
  peer.run(rgb);
  const std::vector<float> features = peer.features();
  double square = 0;
  for (size_t i = 0; i < own.size(); ++i) {
    const double scale = 255 * static_cast<double>(runner.asset().feature_scale[i]);
    if (scale == 0) continue;  // the file does not use this channel
    square += std::pow(static_cast<double>(features[i] - own[i]) / scale, 2);
  }
  const double rms = std::sqrt(square / static_cast<double>(own.size()));
  EXPECT_LE(rms, 0.01);
  std::printf("root mean square of 1024 features' differences: %.2g of their range\n", rms);
}

}  // namespace
}  // namespace sandglass::host

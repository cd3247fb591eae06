// The shipped network on images: 56 excerpts of seven made-up rooms on which it was neither trained nor calibrated. The
// truth is PyTorch's output with the float weights from which the bytes were made (models/lighting/excerpts,
// float_network.py).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "models/files/atomic_file.h"
#include "models/files/npy.h"
#include "models/lighting/excerpts.h"
#include "models/lighting/light_net.h"
#include "models/lighting/light_runner.h"

namespace sandglass::host {
namespace {

const std::string k_folder = SANDGLASS_EXCERPTS_DIR;

std::vector<uint8_t> shipped() {
  const std::string content = read_file(SANDGLASS_LIGHTS_DIR "/room.light", "lighting network");
  return {content.begin(), content.end()};
}

TEST(Excerpts, TheShippedBytesSayWhatPyTorchSaysInFloat) {
  const std::vector<Excerpt> all = read_excerpts(SANDGLASS_EXCERPTS_DIR, SANDGLASS_EMULATED ? 9 : 1);
  ASSERT_GE(all.size(), SANDGLASS_EMULATED ? 6u : 50u);
  LightRunner runner(shipped(), "room.light");
  std::vector<LightValues> bytes, floats;
  for (const Excerpt& excerpt : all) {
    const LightOutputs out = runner.run(excerpt.rgb);
    bytes.push_back({out.direction[0], out.direction[1], out.direction[2], out.light[0], out.light[1], out.light[2],
                     out.ambient[0], out.ambient[1], out.ambient[2], out.contrast});
    floats.push_back(excerpt.values);
  }
  const LightDifference found = median_difference(bytes, floats);
  EXPECT_LE(found.angle_deg, 1.0);
  EXPECT_LE(found.other, 0.01);
  std::printf("bytes against float on %zu excerpts: median %.3f deg, %.4f\n", all.size(), found.angle_deg, found.other);
  // The control: outputs that belong to the next image are beyond both limits.
  std::rotate(bytes.begin(), bytes.begin() + 1, bytes.end());
  const LightDifference shifted = median_difference(bytes, floats);
  EXPECT_GT(shifted.angle_deg, 2.0);
  EXPECT_GT(shifted.other, 0.02);
}

// The file has the heads in float, as PyTorch has them: the table was made with the weights of this file.
TEST(Excerpts, TheHeadsOfTheShippedBytesAreThoseOfTheFloatNetwork) {
  const auto arrays = read_npz(k_folder + "/heads.npz");
  const std::vector<float>&spread = arrays.at("spread").values, &bias = arrays.at("bias").values;
  LightRunner runner(shipped(), "room.light");
  const LightAsset& asset = runner.asset();
  constexpr size_t k_copies = 16;  // copies of each regression among the latent units
  for (size_t o = 0; o < k_heads; ++o) {
    EXPECT_EQ(asset.heads_bias[o], bias[o]);
    for (size_t i = 0; i < k_latent; ++i)
      ASSERT_EQ(asset.heads_weights[o * k_latent + i], i / k_copies == o ? spread[o] : 0.0f) << o << " " << i;
  }
}

// Run by float_network.sh, which makes the weights.
TEST(Excerpts, TheFloatNetworkInCppIsPyTorchs) {
  const char* weights = std::getenv("SANDGLASS_FLOAT_WEIGHTS");
  if (weights == nullptr) GTEST_SKIP() << "SANDGLASS_FLOAT_WEIGHTS is not set to what float_network.py wrote";
  const LightNet net = light_net_of(read_npz(weights));
  double worst = 0;
  const std::vector<Excerpt> all = read_excerpts(SANDGLASS_EXCERPTS_DIR);
  for (const Excerpt& excerpt : all) {
    const LightValues values = light_of(net, features_of(net.trunk, excerpt.rgb, 256, 192));
    for (size_t i = 0; i < values.size(); ++i)
      worst = std::max(worst, static_cast<double>(std::fabs(values[i] - excerpt.values[i])));
  }
  EXPECT_LE(worst, 1e-3);
  std::printf("C++ against PyTorch in float on %zu excerpts: %.2g at the most\n", all.size(), worst);
}

}  // namespace
}  // namespace sandglass::host

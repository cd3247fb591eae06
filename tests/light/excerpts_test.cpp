// The shipped network on images: 56 excerpts of seven made-up rooms on which it was neither trained nor calibrated. The
// truth is PyTorch's output with the float weights from which the bytes were made (models/lighting/excerpts,
// float_network.py).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "models/files/atomic_file.h"
#include "tests/light/network_checks.h"

namespace sandglass::host {
namespace {

const std::string k_folder = SANDGLASS_EXCERPTS_DIR;

std::vector<uint8_t> shipped() {
  const std::string content = read_file(SANDGLASS_LIGHTS_DIR "/room.light", "lighting network");
  return {content.begin(), content.end()};
}

TEST(Excerpts, TheShippedBytesSayWhatPyTorchSaysInFloat) {
  const std::vector<Excerpt> all = read_excerpts(k_folder, SANDGLASS_EMULATED ? 9 : 1);
  ASSERT_GE(all.size(), SANDGLASS_EMULATED ? 6u : 50u);
  const std::vector<uint8_t> file = shipped();
  EXPECT_LE(file.size(), 8'000'000u);
  LightRunner runner(file, "room.light");
  std::vector<LightValues> bytes, floats;
  for (const Excerpt& excerpt : all) {
    bytes.push_back(tests::values_of(runner.run(excerpt.rgb)));
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

}  // namespace
}  // namespace sandglass::host

// What every back end of the lighting network must do, and what its tests run it on.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

#include "models/lighting/excerpts.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "models/work/random.h"
#include "tests/int8_kernels.h"
#include "tests/light/byte_network.h"

namespace sandglass::tests {

inline std::vector<uint8_t> noise(int width, int height) {
  std::vector<uint8_t> rgb(static_cast<size_t>(3 * width * height));
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(256 * host::random_unit(i));
  return rgb;
}

// What a network's file gives for an image.
inline std::vector<float> features_of(const host::LightFile& file, sandglass_estimator_backend backend,
                                      const std::vector<uint8_t>& rgb, int width, int height) {
  host::LightRunner runner(host::light_file_bytes(file), "network", SANDGLASS_ISA_AUTOMATIC,
                           static_cast<uint32_t>(width), static_cast<uint32_t>(height), backend);
  runner.run(rgb);
  return runner.features();
}

inline host::LightValues values_of(const LightOutputs& out) {
  return {out.direction[0], out.direction[1], out.direction[2], out.light[0],   out.light[1],
          out.light[2],     out.ambient[0],   out.ambient[1],   out.ambient[2], out.contrast};
}

// `values` gives a network's outputs for an image. They must be PyTorch's for every excerpt in `folder`.
template <class Values>
void expect_pytorch(const std::string& folder, Values&& values) {
  float worst = 0;
  const std::vector<host::Excerpt> all = host::read_excerpts(folder);
  for (const host::Excerpt& excerpt : all) {
    const host::LightValues found = values(excerpt.rgb);
    for (size_t i = 0; i < found.size(); ++i) worst = std::max(worst, std::fabs(found[i] - excerpt.values[i]));
  }
  EXPECT_LE(worst, 1e-3f);
  std::printf("against PyTorch in float on %zu excerpts: %.2g at the most\n", all.size(), static_cast<double>(worst));
}

// Features in float are those of the file's network without any rounding, to 1e-3 of a byte's range: as the project's
// float network against PyTorch.
inline void expect_unrounded(const host::LightFile& file, const std::vector<float>& features,
                             const std::vector<uint8_t>& rgb, int width, int height) {
  const Map<double> map = last_map<double>(file, rgb, width, height);
  const int pixels = map.width * map.height;
  double worst = 0, size = 0;
  for (int c = 0; c < map.channels; ++c) {
    double sum = 0;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) sum += map.at(x, y, c);
    const auto i = static_cast<size_t>(c);
    const double scale = static_cast<double>(file.feature_scale[i]);
    const double truth = scale * (sum / pixels) + static_cast<double>(file.feature_shift[i]);
    worst = std::max(worst, std::fabs(static_cast<double>(features[i]) - truth) / (255 * std::fabs(scale)));
    size = std::max(size, sum / pixels);
  }
  EXPECT_LE(worst, 1e-3);
  EXPECT_GT(size, 16.0) << "the features must not all be small";
  std::printf("greatest difference of 1024 features: %.2g of their range\n", worst);
}

// The units of one operator may run in any order.
inline void expect_any_order(host::LightRunner* runner, const std::vector<uint8_t>& rgb) {
  const LightOutputs expected = runner->run(rgb);
  runner->run(std::vector<uint8_t>(rgb.size(), 90));  // fills the memory with other values
  LightNetwork* net = runner->network();
  begin_light_network(net, rgb.data());
  for (uint32_t first = 0; first < net->units; first = light_operator_end(*net, first))
    for (uint32_t unit = light_operator_end(*net, first); unit-- > first;) run_light_unit(net, unit);
  LightOutputs outputs;
  finish_light_network(*net, &outputs);
  EXPECT_EQ(std::memcmp(&outputs, &expected, sizeof outputs), 0);
}

}  // namespace sandglass::tests

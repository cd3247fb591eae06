// The lighting network at run time: equal to the naive network of bytes to the bit, equal on every instruction set and in
// every order that is allowed, and within its memory. excerpts_test.cpp compares it with the float network.
#include "runtime/light/network/network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/files/aligned_bytes.h"
#include "models/lighting/light_runner.h"
#include "runtime/light/network/heads.h"
#include "runtime/math/hash.h"
#include "tests/light/network_checks.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_width = 96, k_height = 64;  // small, and not square
constexpr uint64_t k_golden = 4615494675203553879u;

const std::vector<uint8_t>& random_file() {
  static const std::vector<uint8_t> bytes = light_file_bytes(random_light_file(7));
  return bytes;
}

std::vector<uint8_t> random_image(uint32_t width, uint32_t height) {
  std::vector<uint8_t> rgb(size_t{3} * width * height);
  tests::Integers random = {11};
  for (uint8_t& b : rgb) {
    random.next(0, 255);
    b = static_cast<uint8_t>(random.state >> 56);
  }
  return rgb;
}

uint64_t golden_on(sandglass_isa isa, const std::vector<uint8_t>& file) {
  LightRunner runner(file, "random", isa, k_width, k_height);
  const LightOutputs outputs = runner.run(random_image(k_width, k_height));
  const std::vector<float> features = runner.features();
  return hash_bytes(features.data(), 4 * features.size()) * 1099511628211ull ^ hash_bytes(&outputs, sizeof outputs);
}

std::vector<uint32_t> averages_of(LightRunner* runner) {
  std::vector<uint32_t> averages;
  for (uint32_t c = 0; c < k_light_features; ++c)
    averages.push_back(256u * runner->network()->pooled_high[c] + runner->network()->pooled_low[c]);
  return averages;
}

TEST(LightNetwork, OneHashOnEveryInstructionSet) {
  for (const sandglass_isa isa : tests::int8_sets()) EXPECT_EQ(golden_on(isa, random_file()), k_golden) << isa;
}

TEST(LightNetwork, EqualsTheNaiveNetworkOfBytes) {
  LightRunner runner(random_file(), "random", SANDGLASS_ISA_AUTOMATIC, 64, 32);
  const std::vector<uint8_t> rgb = random_image(64, 32);
  runner.run(rgb);
  const std::vector<uint32_t> expected = tests::byte_features(random_light_file(7), rgb, 64, 32);
  EXPECT_EQ(averages_of(&runner), expected);
  // The channels must differ, or equality would prove little.
  EXPECT_GT(*std::max_element(expected.begin(), expected.end()),
            *std::min_element(expected.begin(), expected.end()) + 25600);
}

TEST(LightNetwork, DoesNotReadAFloatNetworkBesideTheBytes) {
  LightFile file = random_light_file(7);
  file.float_parameters.assign(k_light_float_parameters, 0.5f);
  EXPECT_EQ(golden_on(SANDGLASS_ISA_AUTOMATIC, light_file_bytes(file)), k_golden);
}

TEST(LightNetwork, UnitsOfAnOperatorMayRunInAnyOrder) {
  LightRunner runner(random_file(), "random", SANDGLASS_ISA_AUTOMATIC, k_width, k_height);
  tests::expect_any_order(&runner, random_image(k_width, k_height));
}

TEST(LightNetwork, UnitsAreSmallAndAddUp) {
  LightRunner runner(random_file(), "random");
  const LightNetwork& net = *runner.network();
  uint64_t left[k_light_kinds], sum = 0, counted = 0;
  light_items_left(net, 0, left);
  for (uint32_t kind = k_light_kind_stem; kind < k_light_kinds; ++kind) sum += left[kind];
  for (uint32_t unit = 0; unit < net.units; ++unit) {
    const WorkUnit work = light_unit(net, unit);
    EXPECT_LE(work.items, k_light_unit_macs / 1000) << unit;
    EXPECT_GT(work.items, 0u) << unit;
    counted += work.items;
  }
  // 2.549 G multiplications, 10 M more for the stem's padding, and 7 M comparisons. Each unit rounds down.
  EXPECT_NEAR(static_cast<double>(sum), 2.549e6 + 0.010e6 + 0.002e6, 2e3);
  EXPECT_NEAR(static_cast<double>(counted), static_cast<double>(sum), static_cast<double>(net.units));
  light_items_left(net, net.units, left);
  for (const uint64_t items : left) EXPECT_EQ(items, 0u);
}

TEST(LightNetwork, ActivationsStayBelowTwoMegabytes) { EXPECT_LE(light_activation_bytes(256, 192), uint64_t{2} << 20); }

TEST(LightNetwork, HeadsMeanWhatTheyShould) {
  const double heads[k_light_heads] = {0.5, -1, 0.25, 2, -2, 0, 40, -40, 800, 0.75};
  const LightOutputs out = light_outputs_of(heads);
  const double x = std::tanh(0.5), y = std::tanh(-1.0), z = std::tanh(0.25), length = std::sqrt(x * x + y * y + z * z);
  EXPECT_FLOAT_EQ(out.direction[0], static_cast<float>(x / length));
  EXPECT_FLOAT_EQ(out.direction[1], static_cast<float>(y / length));
  EXPECT_FLOAT_EQ(out.direction[2], static_cast<float>(z / length));
  EXPECT_FLOAT_EQ(out.light[0], static_cast<float>(1 / (1 + std::exp(-2.0))));
  EXPECT_FLOAT_EQ(out.light[2], 0.5f);
  EXPECT_FLOAT_EQ(out.ambient[1], static_cast<float>(std::exp(-40.0)));
  EXPECT_FLOAT_EQ(out.ambient[2], 1.0f);
  EXPECT_FLOAT_EQ(out.contrast, static_cast<float>(1 / (1 + std::exp(-0.75))));
  const LightOutputs nowhere = light_outputs_of(std::array<double, k_light_heads>{}.data());
  EXPECT_EQ(nowhere.direction[1], -1.0f);
  for (const double t : {-3.0, -1e-3, 0.0, 2.0}) EXPECT_NEAR(elu(t), t > 0 ? t : std::expm1(t), 1e-15);
}

}  // namespace
}  // namespace sandglass::host

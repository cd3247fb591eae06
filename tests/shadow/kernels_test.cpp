// Every int8 table equals a naive oracle in 64-bit integers and double to the bit, and so every other table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/int8_kernels.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

struct Case {
  uint32_t width, layers;
  bool extreme;
};

struct Oracle {
  std::vector<int16_t> columns, rows;
  std::vector<std::vector<int8_t>> weights;
  std::vector<std::vector<int32_t>> bias;
  std::vector<std::vector<float>> multiplier;
  std::vector<int8_t> last;
  std::vector<uint8_t> coverage;
  int32_t last_bias = 700;
  float last_multiplier = 0.01f;
  uint32_t width, shift = 3;

  explicit Oracle(const Case& c)
      : columns(256 * c.width), rows(256 * c.width), last(c.width), coverage(k_coverage_steps), width(c.width) {
    Integers random = {c.width * 31 + c.layers};
    const auto next = [&](int64_t low, int64_t high) { return random.next(low, high); };
    const int64_t reach = c.extreme ? 32767 : 1500;
    for (int16_t& x : columns) x = static_cast<int16_t>(next(-reach, reach));
    for (int16_t& x : rows) x = static_cast<int16_t>(next(-reach, reach));
    for (uint32_t layer = 0; layer < c.layers; ++layer) {
      weights.emplace_back(c.width * c.width);
      bias.emplace_back(c.width);
      multiplier.emplace_back(c.width);
      for (int8_t& w : weights.back())
        w = static_cast<int8_t>(c.extreme ? (next(0, 3) == 0 ? -127 : 127) : next(-127, 127));
      for (int32_t& b : bias.back()) b = static_cast<int32_t>(next(-20000, 20000));
      for (float& m : multiplier.back()) m = static_cast<float>(next(1, 1000)) * (c.extreme ? 1e-7f : 3e-6f);
    }
    for (int8_t& w : last) w = static_cast<int8_t>(next(-127, 127));
    for (uint8_t& b : coverage) b = static_cast<uint8_t>(next(0, 255));
  }

  // The conversion to float and the product are rounded once each. nearbyint in double rounds to nearest even.
  uint8_t texel(uint32_t u, uint32_t v) const {
    std::vector<uint8_t> in(width), out(width);
    for (uint32_t i = 0; i < width; ++i) {
      const int32_t sum = std::clamp(columns[u * width + i] + rows[v * width + i], -32768, 32767);
      in[i] = static_cast<uint8_t>(std::clamp(static_cast<int32_t>(std::floor(sum / std::pow(2.0, shift))), 0, 255));
    }
    for (size_t layer = 0; layer < weights.size(); ++layer) {
      for (uint32_t o = 0; o < width; ++o) {
        int64_t sum = bias[layer][o];
        for (uint32_t i = 0; i < width; ++i) sum += int64_t{weights[layer][o * width + i]} * in[i];
        const float scaled = static_cast<float>(sum) * multiplier[layer][o];
        out[o] = static_cast<uint8_t>(std::nearbyint(std::clamp(static_cast<double>(scaled), 0.0, 255.0)));
      }
      in.swap(out);
    }
    int64_t sum = last_bias;
    for (uint32_t i = 0; i < width; ++i) sum += int64_t{last[i]} * in[i];
    const float x = static_cast<float>(sum) * last_multiplier;
    const double index = std::nearbyint(std::clamp(static_cast<double>(x), -2048.0, 2047.0)) + 2048;
    return coverage[static_cast<size_t>(index)];
  }
};

TEST(ShadowKernels, EveryTableEqualsTheOracleForEveryCountOfTexels) {
  for (const Case& c :
       {Case{32, 1, false}, Case{96, 2, false}, Case{128, 2, true}, Case{224, 3, false}, Case{256, 2, true}}) {
    const Oracle oracle(c);
    std::vector<uint16_t> u, v;
    std::vector<uint8_t> expected;
    constexpr uint32_t k_texels = 2 * k_texel_block + 1;
    for (uint32_t i = 0; i < k_texels; ++i) {
      u.push_back(static_cast<uint16_t>(i * 37 % 256));
      v.push_back(static_cast<uint16_t>(i * 101 % 256));
      expected.push_back(oracle.texel(u[i], v[i]));
    }
    Aligned columns(oracle.columns), rows(oracle.rows);
    Aligned last(oracle.last);
    Aligned<uint8_t> scratch(shadow_scratch_bytes(c.width));
    for (const sandglass_isa isa : int8_sets()) {
      const Int8Kernels* table = select_int8_kernels(isa);
      std::vector<Aligned<int8_t>> packed(c.layers, Aligned<int8_t>(c.width * c.width));
      std::vector<std::vector<int32_t>> bias(c.layers, std::vector<int32_t>(c.width));
      ShadowNetwork network = {
          c.width,     c.layers,         columns.data(),         rows.data(),           oracle.shift, {},
          last.data(), oracle.last_bias, oracle.last_multiplier, oracle.coverage.data()};
      for (uint32_t layer = 0; layer < c.layers; ++layer) {
        table->pack_layer(oracle.weights[layer].data(), oracle.bias[layer].data(), c.width, c.width,
                          packed[layer].data(), bias[layer].data());
        network.layer[layer] = {packed[layer].data(), bias[layer].data(), oracle.multiplier[layer].data()};
      }
      for (uint32_t count = 1; count <= k_texels; count += count < 4 || count > 44 ? 1 : 7) {
        std::vector<uint8_t> result(count + 1, 0xEE);
        const TexelRange range = {u.data(), v.data(), count, scratch.data(), result.data()};
        table->shadow_texels(&network, &range);
        EXPECT_EQ(result[count], 0xEE);
        for (uint32_t i = 0; i < count; ++i)
          ASSERT_EQ(result[i], expected[i])
              << "isa " << isa << " width " << c.width << " count " << count << " at " << i;
      }
    }
  }
}

// Weights and texels of any size, the largest included, for every count of components and every range.
TEST(ShadowKernels, AmbientTexelsEqualTheOracle) {
  constexpr uint32_t k_side = 32, k_size = k_side * k_side;
  Integers random = {77};
  const auto next = [&](int64_t low, int64_t high) { return random.next(low, high); };
  for (const bool extreme : {false, true})
    for (uint32_t count = 2; count <= k_ambient_components_limit; count += 10)
      for (const uint32_t shift : {1u, 13u, k_ambient_shift_limit}) {
        Aligned<int8_t> texels(count * k_size);
        for (uint32_t i = 0; i < count * k_size; ++i)
          texels.data()[i] = static_cast<int8_t>(extreme ? (i % k_side < k_side / 2 ? -128 : 127) : next(-127, 127));
        std::vector<int16_t> weights(count);
        for (int16_t& w : weights) w = static_cast<int16_t>(extreme ? 32767 : next(-20000, 20000));
        std::vector<uint8_t> expected(k_size);
        for (uint32_t t = 0; t < k_size; ++t) {
          int64_t sum = int64_t{1} << (shift - 1);
          for (uint32_t k = 0; k < count; ++k) sum += int64_t{weights[k]} * texels.data()[k * k_size + t];
          const double dark = std::floor(static_cast<double>(sum) / std::pow(2.0, shift));
          expected[t] = static_cast<uint8_t>(255 - std::clamp(dark, 0.0, 255.0));
        }
        const AmbientComponents components = {texels.data(), k_size, count, weights.data(), shift};
        for (const sandglass_isa isa : int8_sets())
          for (uint32_t begin = 0; begin < k_size; begin += 5 * k_ambient_group) {
            const uint32_t end = std::min(k_size, begin + 5 * k_ambient_group);
            std::vector<uint8_t> result(k_size, 0xEE);
            select_int8_kernels(isa)->ambient_texels(&components, begin, end, result.data());
            for (uint32_t t = 0; t < k_size; ++t)
              ASSERT_EQ(result[t], t >= begin && t < end ? expected[t] : 0xEE)
                  << "isa " << isa << " components " << count << " shift " << shift << " at " << t;
          }
      }
}

}  // namespace

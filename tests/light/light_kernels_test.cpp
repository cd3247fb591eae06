// The convolutions of every int8 table equal naive oracles to the bit, for all lengths of a row around the tile's size,
// also with weights and bytes at their extremes.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/int8_kernels.h"
#include "tests/light/byte_network.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

constexpr uint8_t k_untouched = 0xEE;

host::ByteConvolution random_convolution(Integers* random, uint32_t inputs, uint32_t places, uint32_t outputs,
                                         bool extreme) {
  host::ByteConvolution c;
  for (uint32_t i = 0; i < outputs * places * inputs; ++i)
    c.weights.push_back(
        static_cast<int8_t>(extreme ? (random->next(0, 2) == 0 ? -127 : 127) : random->next(-127, 127)));
  for (uint32_t o = 0; o < outputs; ++o) {
    c.bias.push_back(static_cast<int32_t>(random->next(-40000, 40000)));
    c.multiplier.push_back(static_cast<float>(random->next(1, 1000)) / (extreme ? 1e8f : 1e6f));
  }
  for (uint32_t i = 0; i < inputs; ++i) {
    const auto a = static_cast<uint8_t>(random->next(0, 255)), b = static_cast<uint8_t>(random->next(0, 255));
    c.low.push_back(extreme ? uint8_t{0} : std::min(a, b));
    c.high.push_back(extreme ? uint8_t{255} : std::max(a, b));
  }
  return c;
}

ByteMap random_map(Integers* random, int width, int height, int channels, bool extreme) {
  ByteMap map(width, height, channels);
  for (uint8_t& b : map.values) b = static_cast<uint8_t>(extreme ? 255 * random->next(0, 3) / 3 : random->next(0, 255));
  return map;
}

// A convolution packed for a table.
struct Packed {
  Aligned<int8_t> weights;
  std::vector<int32_t> bias;
  Int8Convolution convolution;
  Packed(const Int8Kernels& table, const host::ByteConvolution& c, uint32_t inputs, uint32_t all_inputs)
      : weights(c.weights.size()), bias(c.bias.size()) {
    const auto outputs = static_cast<uint32_t>(c.bias.size());
    table.pack_layer(c.weights.data(), c.bias.data(), outputs, all_inputs, weights.data(), bias.data());
    convolution = {weights.data(), bias.data(), c.multiplier.data(), c.low.data(), c.high.data(), inputs, outputs};
  }
};

struct Shape {
  uint32_t inputs, outputs;
  bool extreme;
};

TEST(LightKernels, NarrowAndTransitionEqualTheOracleForEveryCountOfPixels) {
  Integers random = {1};
  for (const Shape& s : {Shape{64, 128, false}, Shape{96, 32, true}, Shape{992, 64, false}, Shape{1024, 32, true}}) {
    constexpr int k_pixels = 19;
    const host::ByteConvolution c = random_convolution(&random, s.inputs, 1, s.outputs, s.extreme);
    const ByteMap in = random_map(&random, 2 * k_pixels, 2, static_cast<int>(s.inputs), s.extreme);
    const ByteMap limited = clamped(in, c.low, c.high);
    const ByteMap expected_narrow = convolved(c, limited, 1, 1, nullptr);
    const ByteMap expected_transition = convolved(c, averaged(limited), 1, 1, nullptr);
    const uint32_t stride = s.outputs + 64;  // as in a dense block, where the next channels belong to another layer
    for (const sandglass_isa isa : int8_sets()) {
      const Int8Kernels& table = *select_int8_kernels(isa);
      Packed packed(table, c, s.inputs, s.inputs);
      for (uint32_t count = 1; count <= k_pixels; ++count)
        for (const bool transition : {false, true}) {
          Aligned<uint8_t> out(size_t{k_pixels} * stride);
          std::fill_n(out.data(), k_pixels * stride, k_untouched);
          const PixelRow row = {in.values.data(), s.inputs, 2 * k_pixels * s.inputs, count, out.data(), stride};
          (transition ? table.transition : table.narrow)(&packed.convolution, &row);
          const ByteMap& expected = transition ? expected_transition : expected_narrow;
          for (uint32_t i = 0; i < k_pixels * stride; ++i) {
            const bool written = i / stride < count && i % stride < s.outputs;
            const int x = static_cast<int>(i / stride), o = static_cast<int>(i % stride);
            ASSERT_EQ(out.data()[i], written ? expected.at(x, 0, o) : k_untouched)
                << "isa " << isa << " inputs " << s.inputs << " count " << count << " transition " << transition
                << " pixel " << x << " output " << o;
          }
        }
    }
  }
}

TEST(LightKernels, WideEqualsTheOracleForEveryCountOfPixels) {
  Integers random = {2};
  for (const Shape& s : {Shape{32, 32, false}, Shape{128, 32, true}, Shape{128, 64, false}})
    for (int width = 1; width <= 17; width += width < 9 ? 1 : 4) {
      const host::ByteConvolution c = random_convolution(&random, s.inputs, 9, s.outputs, s.extreme);
      const int channels = static_cast<int>(s.inputs);
      const ByteMap in = random_map(&random, width, 3, channels, s.extreme);
      const ByteMap expected = convolved(c, in, 3, 1, nullptr);
      ByteMap bordered(width + 2 + static_cast<int>(k_tile_slack), 3, channels);
      std::fill(bordered.values.begin(), bordered.values.end(), k_untouched);
      for (int y = 0; y < 3; ++y)
        for (int i = 0; i < channels; ++i) {
          bordered.at(0, y, i) = bordered.at(width + 1, y, i) = 0;
          for (int x = 0; x < width; ++x) bordered.at(x + 1, y, i) = in.at(x, y, i);
        }
      for (const sandglass_isa isa : int8_sets()) {
        const Int8Kernels& table = *select_int8_kernels(isa);
        Packed packed(table, c, s.inputs, 9 * s.inputs);
        Aligned<uint8_t> out(size_t{18} * s.outputs);
        std::fill_n(out.data(), 18 * s.outputs, k_untouched);
        const PixelRow row = {
            bordered.values.data(),       s.inputs,   static_cast<uint32_t>(bordered.width) * s.inputs,
            static_cast<uint32_t>(width), out.data(), s.outputs};
        table.wide(&packed.convolution, &row);
        for (uint32_t i = 0; i < 18 * s.outputs; ++i) {
          const int x = static_cast<int>(i / s.outputs), o = static_cast<int>(i % s.outputs);
          ASSERT_EQ(out.data()[i], x < width ? expected.at(x, 1, o) : k_untouched)
              << "isa " << isa << " inputs " << s.inputs << " width " << width << " pixel " << x << " output " << o;
        }
      }
    }
}

TEST(LightKernels, StemAndPoolEqualTheOracle) {
  Integers random = {3};
  const uint8_t border[3] = {124, 116, 104};
  for (const int width : {32, 56, 256}) {
    constexpr int k_height = 16;
    const host::ByteConvolution c = random_convolution(&random, 147, 1, k_stem_outputs, width == 56);
    const ByteMap image = random_map(&random, width, k_height, 3, width == 56);
    const ByteMap expected = convolved(c, image, 7, 2, border), expected_pool = pooled(expected);
    host::ByteConvolution grown = c;
    grown.weights.clear();
    for (uint32_t o = 0; o < k_stem_outputs; ++o) {
      grown.weights.insert(grown.weights.end(), c.weights.begin() + o * 147, c.weights.begin() + (o + 1) * 147);
      grown.weights.insert(grown.weights.end(), k_stem_bytes - 147, 0);
    }
    const auto columns = static_cast<uint32_t>(width);
    for (const sandglass_isa isa : int8_sets()) {
      const Int8Kernels& table = *select_int8_kernels(isa);
      Packed packed(table, grown, k_stem_bytes, k_stem_bytes);
      Aligned<uint8_t> out(expected.values.size()), pool(expected_pool.values.size());
      for (uint32_t y = 0; y < k_height / 2; ++y)
        table.stem(&packed.convolution, image.values.data(), border, columns, k_height, y,
                   out.data() + y * (columns / 2) * k_stem_outputs);
      EXPECT_TRUE(std::equal(expected.values.begin(), expected.values.end(), out.data())) << isa << " " << width;
      for (uint32_t y = 0; y < k_height / 4; ++y)
        table.pool(out.data(), columns / 2, k_height / 2, y, pool.data() + y * (columns / 4) * k_stem_outputs,
                   k_stem_outputs);
      EXPECT_TRUE(std::equal(expected_pool.values.begin(), expected_pool.values.end(), pool.data()))
          << isa << " " << width;
    }
  }
}

TEST(LightKernels, DotEqualsTheOracle) {
  Integers random = {4};
  for (const uint32_t count : {32u, 96u, 1024u}) {
    Aligned<uint8_t> bytes(count);
    Aligned<int8_t> weights(count);
    int64_t expected = 0;
    for (uint32_t i = 0; i < count; ++i) {
      bytes.data()[i] = static_cast<uint8_t>(random.next(200, 255));
      weights.data()[i] = static_cast<int8_t>(count == 1024 ? 127 : random.next(-127, 127));
      expected += int64_t{bytes.data()[i]} * weights.data()[i];
    }
    for (const sandglass_isa isa : int8_sets())
      EXPECT_EQ(select_int8_kernels(isa)->dot(bytes.data(), weights.data(), count), expected) << isa;
  }
}

}  // namespace

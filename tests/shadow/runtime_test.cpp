// The runtime through its C API: one texture on every instruction set, difficult lights. (In divided units: set_test.cpp.)
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "runtime/asset/shadow_asset.h"
#include "runtime/math/hash.h"
#include "tests/int8_kernels.h"
#include "tests/shadow/shadow_fixture.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

constexpr uint32_t k_size = SANDGLASS_SHADOW_TEXELS;
constexpr float k_degree = 3.14159265f / 180;
constexpr RandomShadow k_network = {128, 2, 10, 4, 11, 0.6f};

// Hashes of the textures of k_network for light (0.5, 1, 0.25), the same on all instruction sets, compilers and
// machines.
constexpr uint64_t k_golden_full = 0x448de45a0e59d3b8ull, k_golden_adaptive = 0x4e71d93b206021eeull;

uint64_t hash(const std::vector<uint8_t>& bytes) { return hash_bytes(bytes.data(), bytes.size()); }

std::vector<uint8_t> texture_of(const AssetFile& file, sandglass_isa isa, sandglass_shadow_mode mode) {
  LiveShadow shadow(describe(file, isa, mode));
  shadow.shade(0.5f, 1, 0.25f);
  EXPECT_TRUE(shadow.block.guards_intact());
  return shadow.coverage();
}

TEST(Shadow, OneHashOnEveryInstructionSet) {
  const AssetFile file = make_shadow_file(k_network);
  for (const sandglass_isa isa : golden_sets()) {
    const std::vector<uint8_t> texture = texture_of(file, isa, SANDGLASS_SHADOW_FULL);
    EXPECT_EQ(hash(texture), k_golden_full) << isa;
    EXPECT_EQ(hash(texture_of(file, isa, SANDGLASS_SHADOW_ADAPTIVE)), k_golden_adaptive) << isa;
    // The control: a flat texture would prove little.
    EXPECT_GT(std::set<uint8_t>(texture.begin(), texture.end()).size(), 100u);
  }
}

TEST(Shadow, AdaptiveEqualsFullWhereItAsksTheNetwork) {
  const AssetFile file = make_shadow_file(k_network);
  const std::vector<uint8_t> full = texture_of(file, SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_FULL);
  LiveShadow shadow(describe(file));
  shadow.shade(0.5f, 1, 0.25f);
  const std::vector<uint8_t> adaptive = shadow.coverage();
  // Every corner of the coarse grid has the network's value. At least as many texels agree as the network was asked
  // for.
  uint32_t equal = 0;
  for (uint32_t v = 0; v < k_size; ++v)
    for (uint32_t u = 0; u < k_size; ++u) {
      const bool same = full[v * k_size + u] == adaptive[v * k_size + u];
      equal += same;
      ASSERT_TRUE(same || u % 4 != 0 || v % 4 != 0) << u << " " << v;
    }
  const uint32_t outside = 2 * 64 + 1;  // corners beyond the last texels
  EXPECT_GE(equal, shadow.evaluated() - outside);
  EXPECT_LT(shadow.evaluated(), k_size * k_size);
}

// With the threshold 255 nothing is refined: values are bilinear between the corners, checked in double.
TEST(Shadow, CellsThatAreNotRefinedAreInterpolated) {
  const AssetFile file = make_shadow_file(k_network);
  sandglass_shadow_desc desc = describe(file);
  desc.threshold = 255;
  LiveShadow shadow(desc);
  shadow.shade(0.5f, 1, 0.25f);
  EXPECT_EQ(shadow.evaluated(), 65u * 65u);
  const std::vector<uint8_t> t = shadow.coverage();
  const auto corner = [&](double x, double y) {
    return static_cast<double>(t[4 * static_cast<uint32_t>(y) * k_size + 4 * static_cast<uint32_t>(x)]);
  };
  for (uint32_t v = 0; v + 4 < k_size; ++v)
    for (uint32_t u = 0; u + 4 < k_size; ++u) {
      const double value = bilinear(corner, u / 4.0, v / 4.0);
      ASSERT_LE(std::fabs(value - t[v * k_size + u]), 0.5) << u << " " << v;
    }
}

TEST(Shadow, ALightThatNeverStopsStillGetsTextures) {
  LiveShadow shadow(describe(make_shadow_file({32, 1, 10, 4, 11, 0.6f})));
  uint32_t changes = 0, oldest = 0, units_of_texture = 0;
  constexpr uint32_t k_units_a_frame = 5;
  std::vector<uint8_t> last = shadow.coverage();
  for (int frame = 0; frame < 1000; ++frame) {
    shadow.light(std::sin(0.02f * static_cast<float>(frame)), 1, 0.3f);
    if (frame == 0) units_of_texture = sandglass_shadow_units_left(shadow.shadow);  // units of one texture
    sandglass_shadow_run(&shadow.shadow, 1, k_units_a_frame);
    oldest = std::max(oldest, shadow.texture().behind);
    if (shadow.coverage() != last) {
      ++changes;
      last = shadow.coverage();
    }
  }
  EXPECT_GT(changes, 10u);
  EXPECT_GT(shadow.texture().behind, 0u);
  // A texture is as old as its own making when it arrives, and is shown while the next one is made. Two may share a
  // frame.
  const uint32_t frames = (units_of_texture + k_units_a_frame - 1) / k_units_a_frame;
  EXPECT_LE(oldest, 2 * frames + 1);
  EXPECT_LT(2 * frames + 1, 500u);  // of 1000 frames; otherwise the bound would say nothing
}

TEST(Shadow, NothingIsComputedForALightThatHardlyMoved) {
  const AssetFile file = make_shadow_file(k_network);
  sandglass_shadow_desc desc = describe(file);
  desc.light_tolerance = 0.05f;
  LiveShadow shadow(desc);
  shadow.shade(0, 1, 0);
  shadow.light(std::sin(0.04f), std::cos(0.04f), 0);
  EXPECT_EQ(sandglass_shadow_run(&shadow.shadow, 1, 1), 0u);
  shadow.light(std::sin(0.06f), std::cos(0.06f), 0);
  EXPECT_EQ(sandglass_shadow_run(&shadow.shadow, 1, 1), 1u);
}

TEST(Shadow, LightsBeyondTheBakedOnesFadeOut) {
  LiveShadow shadow(describe(make_shadow_file(k_network)));
  const auto at = [&](float polar) {
    shadow.shade(std::sin(polar * k_degree), std::cos(polar * k_degree), 0);
    return shadow.texture();
  };
  EXPECT_EQ(at(0).scale, 1);
  EXPECT_EQ(at(69.9f).scale, 1);
  EXPECT_LT(at(70.001f).scale, 1);
  const std::vector<uint8_t> limit = shadow.coverage();
  EXPECT_NEAR(at(80).scale, 0.5, 1e-4);
  EXPECT_LT(at(80).scale, 1);
  EXPECT_EQ(shadow.coverage(), limit);  // the light is turned up to 70 degrees
  EXPECT_NEAR(at(89).scale, 0.05, 1e-4);
  EXPECT_EQ(at(90.1f).scale, 0);
  EXPECT_EQ(at(180).scale, 0);
  EXPECT_EQ(at(20).scale, 1);
}

// A light at the limit itself is within it, at every azimuth and length of the vector, though floats put half of these
// directions past it. A hundredth or a ten-thousandth of a degree more is beyond, and fades as documented.
TEST(Shadow, ALightAtTheLimitIsWithinAndOneJustBeyondIsNot) {
  const AssetFile file = make_shadow_file(k_network);
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  ASSERT_EQ(sandglass_shadow_inspect(file.data(), file.bytes, &info, nullptr), SANDGLASS_OK);
  const double limit = static_cast<double>(info.polar_max), degree = std::acos(-1.0) / 180;
  LiveShadow shadow(describe(file));
  int past = 0;
  for (int turn = 0; turn < 360; ++turn)
    for (const double over : {-0.01, 0.0, 0.0001, 0.01}) {
      const double polar = limit + over * degree, azimuth = turn * degree, length = std::exp(0.1 * (turn - 180));
      const float x = static_cast<float>(length * std::sin(polar) * std::cos(azimuth)),
                  y = static_cast<float>(length * std::cos(polar)),
                  z = static_cast<float>(length * std::sin(polar) * std::sin(azimuth));
      shadow.light(x, y, z);
      const double rounded = std::atan2(std::hypot(static_cast<double>(x), static_cast<double>(z)), y);
      past += over == 0 && rounded > limit;
      EXPECT_EQ(shadow.texture().scale<1, over> 0) << turn << " " << over;
      const double fade = (90 * degree - polar) / (90 * degree - limit);
      EXPECT_NEAR(shadow.texture().scale, std::min(1.0, fade), over > 0 ? 1e-6 : 0.0) << turn << " " << over;
    }
  EXPECT_GT(past, 90);  // otherwise nothing was tested
}

// The last texture before the limit and the first one beyond are equal, up to the rounding of the light's own numbers.
TEST(Shadow, NothingJumpsAtTheLimit) {
  const AssetFile file = make_shadow_file(k_network);
  LiveShadow shadow(describe(file, SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_FULL));
  const auto at = [&](float polar) {
    shadow.shade(std::sin(polar * k_degree), std::cos(polar * k_degree), 0);
    return shadow.coverage();
  };
  const std::vector<uint8_t> limit = at(70);
  EXPECT_EQ(shadow.texture().scale, 1);
  at(20);
  const std::vector<uint8_t> beyond = at(70.01f);
  EXPECT_LT(shadow.texture().scale, 1);
  const auto rms = [&](const std::vector<uint8_t>& other) {
    double squares = 0;
    for (size_t i = 0; i < limit.size(); ++i) squares += std::pow(other[i] - limit[i], 2);
    return std::sqrt(squares / static_cast<double>(limit.size()));
  };
  EXPECT_LE(rms(beyond), 1);
  EXPECT_GT(rms(at(69)), 1);  // a difference of one degree is visible
}

TEST(Shadow, LengthOfTheLightDoesNotMatter) {
  const AssetFile file = make_shadow_file(k_network);
  const std::vector<uint8_t> expected = texture_of(file, SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  for (const float scale : {0x1p-140f, 0x1p100f}) {
    LiveShadow shadow(describe(file));
    shadow.shade(0.5f * scale, scale, 0.25f * scale);
    EXPECT_EQ(shadow.coverage(), expected);
  }
}

// Each texel is the mean of the 2 x 2 that it covers, or a bilinear interpolation at its centre; both in double.
TEST(Shadow, ResamplingIsTheMeanOrBilinear) {
  LiveShadow shadow(describe(make_shadow_file(k_network)));
  shadow.shade(0.5f, 1, 0.25f);
  const std::vector<uint8_t> native = shadow.coverage();
  const auto texel = [&](double x, double y) {  // clamped to the edge
    const auto u = static_cast<uint32_t>(std::clamp(x, 0.0, k_size - 1.0));
    const auto v = static_cast<uint32_t>(std::clamp(y, 0.0, k_size - 1.0));
    return static_cast<double>(native[v * k_size + u]);
  };
  for (const uint32_t size : {128u, 256u, 512u}) {
    std::vector<uint8_t> out(size * size);
    ASSERT_EQ(sandglass_shadow_resample(shadow.shadow, 0, out.data(), size, nullptr), SANDGLASS_OK);
    for (uint32_t v = 0; v < size; ++v)
      for (uint32_t u = 0; u < size; ++u) {
        const double expected = bilinear(texel, (u + 0.5) * k_size / size - 0.5, (v + 0.5) * k_size / size - 0.5);
        ASSERT_LE(std::fabs(out[v * size + u] - expected), 0.5) << size << ": " << u << " " << v;
      }
  }
  uint8_t byte = 0;
  EXPECT_EQ(sandglass_shadow_resample(shadow.shadow, 0, &byte, 64, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
}

}  // namespace

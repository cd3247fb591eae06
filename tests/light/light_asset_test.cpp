// A lighting file is untrusted. Tested are files that are truncated, damaged, of another kind, or have wrong numbers
// with a right checksum. What is accepted with wrong numbers runs: tests/fuzz/light_file.cpp.
#include "runtime/asset/light_asset.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "models/lighting/light_file.h"
#include "runtime/light/network/network.h"
#include "sandglass/shadow.h"
#include "tests/asset_file.h"
#include "tests/damaged_file.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

const host::LightFile& file() {
  static const host::LightFile made = host::random_light_file(3);
  return made;
}

AssetFile content() {
  static const std::vector<uint8_t> bytes = host::light_file_bytes(file());
  return AssetFile(bytes);
}

// The content with a float network.
AssetFile float_content() {
  static const std::vector<uint8_t> bytes = [] {
    host::LightFile made = file();
    made.float_parameters.assign(k_light_float_parameters, 0.25f);
    return host::light_file_bytes(made);
  }();
  return AssetFile(bytes);
}

sandglass_status open(const AssetFile& words, uint64_t count, std::string* sentence = nullptr) {
  LightAsset asset;
  const char* reason = nullptr;
  const sandglass_status status = open_light_asset(words.data(), count, &asset, &reason);
  EXPECT_EQ(status == SANDGLASS_OK, reason == nullptr);
  if (sentence != nullptr) *sentence = reason == nullptr ? "" : reason;
  return status;
}

TEST(LightAsset, ReadsWhatWasWritten) {
  AssetFile words = content();
  LightAsset asset;
  ASSERT_EQ(open_light_asset(words.data(), words.bytes, &asset, nullptr), SANDGLASS_OK);
  EXPECT_STREQ(asset.name, "random");
  EXPECT_EQ(std::memcmp(asset.wide[57].weights, file().wide[57].weights.data(), file().wide[57].weights.size()), 0);
  EXPECT_EQ(std::memcmp(asset.transition[2].low, file().transition[2].low.data(), 1024), 0);
  EXPECT_EQ(asset.heads_bias[9], file().heads_bias[9]);
  EXPECT_EQ(asset.seed, 3u);
  EXPECT_EQ(asset.float_parameters, nullptr);
}

TEST(LightAsset, ReadsAFloatNetworkWhereThereIsOne) {
  // Keras counts 6,953,856 trainable numbers in DenseNet-121 without its classifier, two for each of 41,824 normalised
  // channels. Those of the stem and of the bottlenecks are normalised behind a convolution.
  constexpr uint32_t k_normalised = 41'824, k_behind = 64 + 58 * 128;
  constexpr uint32_t k_biases = k_behind + 58 * 32 + 128 + 256 + 512;
  EXPECT_EQ(k_light_float_parameters,
            3 + 6'953'856 - 2 * k_normalised + k_biases + 2 * (k_normalised - k_behind) + 2 * 1024 + 1024 * 512 + 512);
  AssetFile words = float_content();
  LightAsset asset;
  ASSERT_EQ(open_light_asset(words.data(), words.bytes, &asset, nullptr), SANDGLASS_OK);
  ASSERT_NE(asset.float_parameters, nullptr);
  EXPECT_EQ(asset.float_parameters[k_light_float_parameters - 1], 0.25f);
  EXPECT_EQ(asset.seed, 3u);
}

TEST(LightAsset, TruncationsAndChangedBitsAreRefused) {
  for (const AssetFile& words : {content(), float_content()})
    expect_only_whole_taken(
        std::vector<uint8_t>(words.data(), words.data() + words.bytes),
        [](const auto& bytes) { return open(AssetFile(bytes), bytes.size()) == SANDGLASS_OK; },
        SANDGLASS_EMULATED ? 2 : 4);
}

TEST(LightAsset, OtherKindsGetTheirSentence) {
  AssetFile words = content();
  std::string sentence;
  std::memcpy(words.data() + 4, "SGSH", 4);  // a shadow's
  EXPECT_NE(open(words, words.bytes, &sentence), SANDGLASS_OK);
  EXPECT_NE(sentence.find("not a lighting network"), std::string::npos) << sentence;
  AssetFile light = content();
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  const char* reason = nullptr;
  EXPECT_NE(sandglass_shadow_inspect(light.data(), light.bytes, &info, &reason), SANDGLASS_OK);
  EXPECT_NE(std::string(reason).find("not a baked shadow"), std::string::npos) << reason;
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
  EXPECT_NE(open(AssetFile(std::vector<uint8_t>(pointer.begin(), pointer.end())), pointer.size(), &sentence),
            SANDGLASS_OK);
  EXPECT_NE(sentence.find("Git LFS pointer"), std::string::npos) << sentence;
  EXPECT_NE(open_light_asset(nullptr, 100, nullptr, nullptr), SANDGLASS_OK);
  EXPECT_NE(open_light_asset(light.data() + 1, light.bytes - 1, nullptr, nullptr), SANDGLASS_OK);
}

TEST(LightAsset, WrongNumbersBehindARightChecksumAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  struct Case {
    const char* sentence;
    std::function<void(host::LightFile*)> spoil;
  };
  const Case cases[] = {
      {"multiplier", [&](host::LightFile* f) { f->narrow[5].multiplier[7] = nan; }},
      {"multiplier", [&](host::LightFile* f) { f->wide[57].multiplier[31] = -1; }},
      {"multiplier", [&](host::LightFile* f) { f->stem.multiplier.clear(); }},
      {"weight of -128", [](host::LightFile* f) { f->transition[1].weights[3] = -128; }},
      {"wrong size", [](host::LightFile* f) { f->narrow[0].weights.pop_back(); }},
      {"bias of the wrong size", [](host::LightFile* f) { f->wide[2].bias.push_back(1); }},
      {"beyond 2^29", [](host::LightFile* f) { f->stem.bias[0] = -(1 << 30); }},
      {"clamp whose low end",
       [](host::LightFile* f) {
         f->narrow[9].low[4] = 9;
         f->narrow[9].high[4] = 8;
       }},
      {"clamp of the wrong size", [](host::LightFile* f) { f->last_high.clear(); }},
      {"heads", [&](host::LightFile* f) { f->feature_scale[1023] = infinity; }},
      {"heads", [&](host::LightFile* f) { f->latent_scale[0] = nan; }},
      {"heads", [](host::LightFile* f) { f->heads_weights.pop_back(); }},
      {"errors are not numbers", [&](host::LightFile* f) { f->angle_deg = nan; }},
      {"float network", [](host::LightFile* f) { f->float_parameters = {1}; }},
      {"float network",
       [&](host::LightFile* f) {
         f->float_parameters.assign(k_light_float_parameters, 0);
         f->float_parameters.back() = nan;
       }},
      {"float network",
       [](host::LightFile* f) {
         f->float_parameters.assign(k_light_float_parameters, 0);
         f->float_parameters.front() = -1.1e9f;
       }},
  };
  for (const Case& c : cases) {
    host::LightFile spoilt = file();
    c.spoil(&spoilt);
    AssetFile words(host::light_file_bytes(spoilt));
    std::string sentence;
    EXPECT_EQ(open(words, words.bytes, &sentence), SANDGLASS_ERROR_INVALID_ARGUMENT) << c.sentence;
    EXPECT_NE(sentence.find(c.sentence), std::string::npos) << sentence;
  }
}

}  // namespace

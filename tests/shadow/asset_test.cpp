// A shadow file is untrusted. Tested are every truncation, changed bits, and wrong numbers with a right checksum. What is
// accepted with wrong numbers runs: tests/fuzz/shadow_file.cpp.
#include "runtime/asset/file.h"
#include "runtime/asset/shadow_asset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/damaged_file.h"
#include "tests/shadow/shadow_fixture.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

constexpr RandomShadow k_small = {4, 1, 1, 1, 5};

// The same with an ambient shadow and a surface.
RandomShadow with_ambient() {
  RandomShadow what = k_small;
  what.version = 2;
  what.ambient_side = 16;
  what.components = 3;
  what.surface_vertices = 5;
  return what;
}

sandglass_status open(const AssetFile& file, std::string* sentence = nullptr) {
  ShadowAsset asset;
  const char* reason = nullptr;
  const sandglass_status status = open_shadow_asset(file.data(), file.bytes, &asset, &reason);
  EXPECT_EQ(status == SANDGLASS_OK, reason == nullptr);
  if (sentence != nullptr && reason != nullptr) *sentence = reason;
  return status;
}

TEST(ShadowAsset, ReadsWhatWasWritten) {
  const AssetFile file = make_shadow_file({96, 3, 10, 4, 2});
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_shadow_inspect(file.data(), file.bytes, &info, &reason), SANDGLASS_OK) << reason;
  EXPECT_EQ(info.width, 96u);
  EXPECT_EQ(info.layers, 3u);
  EXPECT_EQ(info.macs_per_texel, 96u * (3 * 96 + 1));
  EXPECT_FLOAT_EQ(info.origin[2], 3.0f);
  EXPECT_FLOAT_EQ(info.height, 0.5f);
}

TEST(ShadowAsset, VersionTwoHasAnAmbientShadowAndVersionOneSaysThatItHasNone) {
  RandomShadow what = with_ambient();
  sandglass_shadow_info info = {};
  for (const uint16_t version : {uint16_t{2}, uint16_t{1}}) {
    what.version = version;
    const AssetFile file = make_shadow_file(what);
    const bool has = version == 2;  // an older file's tables are not looked at
    info.struct_size = sizeof info;
    ASSERT_EQ(sandglass_shadow_inspect(file.data(), file.bytes, &info, nullptr), SANDGLASS_OK);
    EXPECT_EQ(info.version, version);
    EXPECT_EQ(info.ambient_texels, has ? 16u : 0u);
    EXPECT_EQ(info.ambient_half, has ? 1.5f : 0.0f);
    EXPECT_EQ(info.ambient_components, has ? 3u : 0u);
    EXPECT_EQ(info.ambient_rmse, has ? 0.02f : 0.0f);
    EXPECT_EQ(info.surface_vertices, has ? 5u : 0u);
  }
}

TEST(ShadowAsset, EveryTruncationAndChangedBitIsRefused) {
  const AssetFile file = make_shadow_file(with_ambient());
  expect_only_whole_taken(std::vector<uint8_t>(file.data(), file.data() + file.bytes),
                          [](const auto& bytes) { return open(AssetFile(bytes)) == SANDGLASS_OK; });
}

TEST(ShadowAsset, RefusesNumbersThatNoBakingWrites) {
  const auto refused = [](RandomShadow what, const char* part, void (*spoil)(RandomShadow&)) {
    spoil(what);
    std::string sentence;
    EXPECT_NE(open(make_shadow_file(what), &sentence), SANDGLASS_OK) << part;
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  };
  refused(k_small, "not a number", [](RandomShadow& s) { s.forced_first = NAN; });
  refused(k_small, "not a number", [](RandomShadow& s) { s.forced_first = INFINITY; });
  refused(k_small, "-128", [](RandomShadow& s) { s.forced_weight = -128; });
  refused(k_small, "another version", [](RandomShadow& s) { s.version = 3; });
  refused(k_small, "wider than 256", [](RandomShadow& s) { s.width = 257; });
  refused(k_small, "1 to 8", [](RandomShadow& s) { s.layers = 9; });
  refused(k_small, "16 frequencies", [](RandomShadow& s) { s.texel_frequencies = 17; });
  refused(with_ambient(), "in steps of 16", [](RandomShadow& s) { s.ambient_side = 24; });
  refused(with_ambient(), "16 to 256 texels", [](RandomShadow& s) {
    s.ambient_side = 272;
    s.components = 1;
  });
  refused(with_ambient(), "1 to 32 components", [](RandomShadow& s) { s.components = 33; });
  refused(with_ambient(), "not a number in -1..1", [](RandomShadow& s) { s.forced_mixing = NAN; });
  refused(with_ambient(), "not a number in -1..1", [](RandomShadow& s) { s.forced_mixing = 1.5f; });
  refused(with_ambient(), "wrong size", [](RandomShadow& s) { s.missing_texels = 1; });
  refused(with_ambient(), "not in order", [](RandomShadow& s) { s.unsorted_surface = true; });
}

TEST(ShadowAsset, RefusesWhatIsNoFileAtAll) {
  const AssetFile file = make_shadow_file(k_small);
  ShadowAsset asset;
  const char* reason = nullptr;
  EXPECT_NE(open_shadow_asset(nullptr, 100, &asset, &reason), SANDGLASS_OK);
  EXPECT_NE(open_shadow_asset(file.data() + 4, file.bytes - 4, &asset, &reason), SANDGLASS_OK);
  EXPECT_NE(std::string(reason).find("aligned"), std::string::npos);
}

}  // namespace

// One pair of textures on every instruction set.
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "runtime/math/hash.h"
#include "tests/cast/cast_scene.h"

namespace {

using namespace sandglass::tests;
using sandglass::hash_bytes;

constexpr uint64_t k_golden_light = 9354677186882402299u, k_golden_ambient = 13227487374963246401u;
constexpr uint64_t k_masked_light = 11740255921287245747u;  // where the main light's share is not told
constexpr uint64_t k_virtual_light = 11816735309424607936u,
                   k_virtual_ambient = 18222647050159184682u;  // without what is real
constexpr uint64_t k_layered_light = 231108006817373538u,
                   k_layered_ambient = 1671331291642172352u;  // three layers, with it

TEST(Cast, OneHashOnEveryInstructionSet) {
  const Mixed scene;
  for (uint32_t i = 0; i < 10; ++i) {
    const bool with_table = i % 2 != 0;
    constexpr sandglass_isa k_isas[] = {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_AVX2,
                                        SANDGLASS_ISA_AVX512, SANDGLASS_ISA_WASM};
    sandglass_cast_desc desc = sandglass::cast_desc();
    desc.isa = k_isas[i / 2];
    uint64_t bytes = 0;
    if (sandglass_cast_bytes(&desc, &bytes, nullptr) == SANDGLASS_ERROR_UNSUPPORTED) continue;
    std::vector<sandglass_cast_mesh> meshes = scene.meshes();
    if (!with_table) meshes.pop_back();
    sandglass::Cast cast = lit(meshes, towards(35, 70), 0.4f, desc);
    const Bytes masked = light_of(cast);
    EXPECT_EQ(hash_bytes(masked.data(), masked.size()), with_table ? k_masked_light : k_virtual_light) << i;
    EXPECT_TRUE(cast.set_cells(uneven_cells()));
    cast.run();
    const Bytes light = light_of(cast), ambient = bytes_of(cast.ambient());
    EXPECT_EQ(hash_bytes(light.data(), light.size()), with_table ? k_golden_light : k_virtual_light) << i;
    EXPECT_EQ(hash_bytes(ambient.data(), ambient.size()), with_table ? k_golden_ambient : k_virtual_ambient) << i;
    // The control: a flat texture would prove little.
    EXPECT_GT(std::set<uint8_t>(light.begin(), light.end()).size(), 100u);
    EXPECT_GT(std::set<uint8_t>(ambient.begin(), ambient.end()).size(), 50u);
    if (!with_table) continue;
    desc.layers = 3;
    const auto [layered_light, layered_ambient] = both_of(lit(meshes, towards(35, 70), 0.4f, desc));
    EXPECT_EQ(hash_bytes(layered_light.data(), layered_light.size()), k_layered_light) << i;
    EXPECT_EQ(hash_bytes(layered_ambient.data(), layered_ambient.size()), k_layered_ambient) << i;
  }
}

}  // namespace

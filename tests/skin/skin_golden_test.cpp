// One skin on every instruction set.
#include "tests/skin/skin_scene.h"

namespace {

// On every instruction set, compiler and number of items in a unit.
TEST(Skin, OneHashOnEveryInstructionSet) {
  constexpr uint64_t k_golden = 6307555062531105163u;
  for (const sandglass_isa isa : {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_AVX2, SANDGLASS_ISA_AVX512})
    for (const uint32_t unit : {64u, 1024u}) {
      if (sandglass_isa_available(isa) == 0) continue;
      sandglass_scene_desc desc = rough(1000);
      desc.isa = isa;
      desc.unit_items = unit;
      Sand sand(desc);
      sand.scene.add_floor();
      sand.scene.colliders.push_back(sandglass::sphere(0.1f, 0.02f, 0.1f, 0.05f));
      sand.scene.add(block(10, 10, 10));
      uint64_t hash = 0;
      for (int i = 0; i < 40; ++i) {
        sand.frame();
        hash = hash * 31 + sand.skin.hash();
      }
      EXPECT_EQ(hash, k_golden) << sandglass_isa_name(isa) << " " << unit;
    }
}

}  // namespace

// Compares the shadow of the shot's pile with rays at the grains that are drawn: the numbers that the documentation
// gives.
#include <gtest/gtest.h>

#include "models/laboratory/shot/verify_shot.h"

namespace {

using namespace sandglass::host;

TEST(PileShadowStudy, HoldsAndItsControlsDoNot) {
#ifndef SANDGLASS_HAVE_EMBREE
  GTEST_SKIP() << "needs Embree";
#endif
  const std::vector<PileShadowError> lights = study_pile_shadow();
  ASSERT_EQ(lights.size(), 9u);
  const PileShadowError whole = whole_of(lights);
  EXPECT_TRUE(holds(whole)) << pile_shadow_text(lights);
  // With the light from the other side, the error falls by far less than two thirds.
  PileShadowError mirrored = whole;
  for (PileShadowError::Part* part : {&mirrored.clear, &mirrored.among_grains, &mirrored.on_sand})
    part->rmse = part->mirrored, part->mirrored = 1.0, part->particles = 1.0;
  EXPECT_FALSE(holds(mirrored));
  EXPECT_GT(mirrored.clear.rmse, 0.5 * mirrored.clear.without);
}

}  // namespace

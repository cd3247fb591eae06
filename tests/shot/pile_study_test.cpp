// The shadow of the shot's heap against rays at the grains that are drawn: what the README says of it.
#include <gtest/gtest.h>

#include "models/shot/verify_shot.h"

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
  // The light from the other side takes nothing like two thirds of the error away.
  PileShadowError mirrored = whole;
  for (PileShadowError::Part* part : {&mirrored.clear, &mirrored.among_grains, &mirrored.on_sand})
    part->rmse = part->mirrored, part->mirrored = 1.0, part->particles = 1.0;
  EXPECT_FALSE(holds(mirrored));
  EXPECT_GT(mirrored.clear.rmse, 0.5 * mirrored.clear.without);
}

}  // namespace

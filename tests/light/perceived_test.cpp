// The errors of pictures against numbers computed by hand, and the perceived ones against values that their papers give:
// the ends of the scale and the knee.
#include <gtest/gtest.h>

#include <cmath>

#include "models/compositing/image_errors.h"

namespace {

using namespace sandglass::host;

RadianceMap filled(Vec3 colour, int width = 64, int height = 48) {
  RadianceMap map(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) map.set(x, y, colour);
  return map;
}

RadianceMap with_square(double grey, double square, int from, int side) {
  RadianceMap map = filled({grey, grey, grey});
  for (int y = from; y < from + side; ++y)
    for (int x = from; x < from + side; ++x) map.set(x, y, {square, square, square});
  return map;
}

TEST(Flip, GreenAndBlueAreOneApart) {
  EXPECT_NEAR(flip(filled({0, 1, 0}), filled({0, 0, 1})), 1.0, 1e-9);
  EXPECT_EQ(flip(filled({0.3, 0.5, 0.1}), filled({0.3, 0.5, 0.1})), 0.0);
}

// Even greys differ in lightness alone and have neither edges nor points, so only the formula is left. Its scale, the
// distance of green and blue to the power 0.7, is 41.2760: L*a*b* of (87.735, -86.183, 83.180) and (32.297, 79.188,
// -107.860) by CIE 1976, colour axes times L*/100, |dL| + |d(a, b)| = 203.3.
TEST(Flip, EvenGreysFollowTheFormula) {
  const double scale = 41.2760, knee = 0.4 * scale;
  const double lightness = 116.0 * std::cbrt(0.2) - 16.0;
  const double small = 0.95 / knee * std::pow(lightness - (116.0 * std::cbrt(0.15) - 16.0), 0.7);
  EXPECT_NEAR(flip(filled({0.2, 0.2, 0.2}), filled({0.15, 0.15, 0.15})), small, 1e-4);
  const double black_white = std::pow(100.0, 0.7);
  EXPECT_NEAR(flip(filled({0, 0, 0}), filled({1, 1, 1})), 0.95 + 0.05 * (black_white - knee) / (scale - knee), 1e-4);
}

TEST(Flip, SeesWhatTheEyeSees) {
  const RadianceMap plain = with_square(0.2, 0.2, 20, 8), square = with_square(0.2, 0.4, 20, 8);
  EXPECT_NEAR(flip(plain, square), flip(square, plain), 1e-12);
  // At 67 pixels a degree the eye does not resolve a checker of single pixels, but it does resolve a coarse one.
  RadianceMap fine = filled({0.2, 0.2, 0.2}), coarse = fine;
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const double f = (x + y) % 2 == 0 ? 0.15 : 0.25, c = (x / 16 + y / 16) % 2 == 0 ? 0.15 : 0.25;
      fine.set(x, y, {f, f, f});
      coarse.set(x, y, {c, c, c});
    }
  EXPECT_LT(flip(plain, fine), 0.5 * flip(plain, coarse));
}

TEST(StructuralSimilarity, EndsAndTheConstantTerm) {
  const RadianceMap square = with_square(0.2, 0.4, 20, 8);
  EXPECT_NEAR(structural_similarity(square, square), 1.0, 1e-12);
  // In even pictures only the term of the means is left, (2ab + c)/(a^2 + b^2 + c).
  const double a = 1.055 * std::pow(0.5, 1.0 / 2.4) - 0.055, b = 1.055 * std::pow(0.1, 1.0 / 2.4) - 0.055;
  EXPECT_NEAR(structural_similarity(filled({0.5, 0.5, 0.5}), filled({0.1, 0.1, 0.1})),
              (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-6);
  // The negative of a structure is worse than no structure.
  const RadianceMap inverse = with_square(0.4, 0.2, 20, 8), none = with_square(0.3, 0.3, 20, 8);
  EXPECT_LT(structural_similarity(square, inverse), structural_similarity(square, none));
}

TEST(RootMeanSquareError, ByHand) {
  RadianceMap truth(2, 1), picture(2, 1);
  truth.set(0, 0, {1, 0, 0});
  picture.set(0, 0, {0, 1, 0});
  EXPECT_NEAR(root_mean_square_error(truth, picture), std::sqrt(2.0 / 6.0), 1e-12);
  EXPECT_EQ(root_mean_square_error(truth, truth), 0.0);
}

}  // namespace

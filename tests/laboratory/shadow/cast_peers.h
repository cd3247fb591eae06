// What apps draw today, as transparencies of a floor under one soft light: shadow maps with percentage-closer soft shadows, in
// two kinds, and an ellipse by formula.
#pragma once

#include <memory>

#include "models/baking/truth.h"

namespace sandglass::host {

// Depths of a mesh as the light's middle sees it: a shadow map of 512 x 512 texels that just holds the object and its
// shadow's rectangle.
class ShadowMap {
 public:
  ShadowMap(const Mesh& mesh, const ShadowRectangle& rectangle, const Direction& light, double half_angle);
  ~ShadowMap();
  ShadowMap(const ShadowMap&) = delete;
  ShadowMap& operator=(const ShadowMap&) = delete;

  // Fernando 2005: `taps` places look for blockers in what the light's width can hide; as many more count those that hide the
  // receiver, over the width that the blockers' mean depth gives.
  double percentage_closer(double x, double z, uint32_t taps) const;
  // The same on exponential variance maps (Lauritzen 2008), which are blurred instead of counted: blockers by Chebyshev's
  // bound over the search width, then the bound over the penumbra's width.
  double exponential_variance(double x, double z) const;

 private:
  struct Maps;
  std::unique_ptr<Maps> maps_;
};

// A dark ellipse at the object's foot, moved and stretched along the light, as wide as the box, blurred by the penumbra
// of the box's middle.
double ellipse(const ShadowBox& box, const Direction& light, double half_angle, double x, double z);

}  // namespace sandglass::host

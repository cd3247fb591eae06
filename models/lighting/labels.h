// The light of a warped panorama in ten numbers (5.1): the direction towards the light, its colour, the colour of the
// rest, and the contrast. The highlight is all that is at least 5 % as bright as the brightest pixel; the rest is
// ambient. All sums are weighted by solid angle (5.23). Where the dissertation is silent or wrong, these are the choices
// whose pictures were nearest to path-traced ones, of 56 (models/RESULTS.md).
//
// Colours: the mean of tone-mapped colours, divided by its greatest channel where that is above 1. Scaling by a ratio of
// luminances (5.4) leaves channels above 1. The ambient colour is weighted by solid angle.
// Contrast: the highlight's share of the irradiance of the level floor under the object, which is the opacity of the
// umbra. (5.24) as it is printed gives almost no contrast. See the corrections in runtime/README.md.
#pragma once

#include "models/rooms/panorama.h"

namespace sandglass::host {

constexpr double k_highlight_share = 0.05;  // of the greatest luminance

struct LightLabels {
  Vec3 direction;       // towards the light, in the frame that was asked for; up if there is none
  Vec3 light, ambient;  // linear, tone mapped
  double contrast;
  bool has_direction;
  // The length of the highlight's mean direction: nearly 1 for light from one lamp, 0 for lamps all around. It is the
  // share of the highlight that its one direction stands for. The rest comes from other directions that cancel out.
  double concentration = 1.0;
};

// `up` is the world's up in the panorama's frame, the normal of the floor. `white` is the luminance that is tone mapped
// to 1: the greatest of the panorama before it was warped, so that image and labels share one exposure.
LightLabels labels_of(const RadianceMap& panorama, Vec3 up, double white);

}  // namespace sandglass::host

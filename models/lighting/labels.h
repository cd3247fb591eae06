// The light of a warped panorama in ten numbers: direction towards the light, its colour, the colour of the rest, and
// the contrast (5.1). The highlight is what is at least 5 % as bright as the brightest pixel; everything else is
// ambient. All sums are weighted by solid angle (5.23). Where the source is silent or wrong there are variants, and the
// label ceiling (ceiling.h) decides between them; `labels_of` is the decision.
#pragma once

#include "models/rooms/panorama.h"

namespace sandglass::host {

constexpr double k_highlight_share = 0.05;  // of the greatest luminance

// How a mean of tone-mapped colours gets into [0, 1]: scaling by a ratio of luminances (5.4) leaves channels above 1.
enum class Range { none, pixels, mean, mean_keeping_hue };
// What the ambient colour's mean is weighted by ("the same weighting", says the source).
enum class AmbientWeight { luminance, solid_angle };
// printed: (5.24) as it stands. factor_above: ERRATUM (5.24), the factor 0.05 on the numerator. irradiance: the share
// of the highlight in the irradiance of the level floor under the object, which is what the opacity of its umbra is.
enum class Contrast { printed, factor_above, irradiance };
constexpr int k_ranges = 4, k_ambient_weights = 2, k_contrasts = 3;

struct LightLabels {
  Vec3 direction;       // towards the light, in the frame asked for; up where there is none
  Vec3 light, ambient;  // linear, tone mapped
  double contrast;
  bool has_direction;
  // Length of the highlight's mean direction, 0..1: of light from one lamp nearly 1, of lamps all around 0. The share
  // of the highlight that its one direction stands for; the rest of it comes from elsewhere and cancels out.
  double concentration = 1.0;
};

struct LabelVariants {
  Vec3 direction;  // in the panorama's frame
  bool has_direction;
  double concentration;
  Vec3 light[k_ranges], ambient[k_ranges][k_ambient_weights];
  double contrast[k_contrasts];
  LightLabels chosen(Range range, AmbientWeight weight, Contrast which) const;
};

// `up`: the world's up in the panorama's frame, the normal of the floor. `white`: luminance that is tone mapped to 1,
// the greatest of the panorama before it was warped, so that image and labels share one exposure.
LabelVariants label_variants(const RadianceMap& panorama, Vec3 up, double white);

// The variant that the label ceiling chose.
LightLabels labels_of(const RadianceMap& panorama, Vec3 up, double white);

// A spherical Gaussian of the light's colour about its direction, sharpness 2 pi, with the ambient colour blended over
// it (5.27 - 5.29): the parameters as a panorama for the eye.
RadianceMap environment_of(const LightLabels& labels, int width, int height);

}  // namespace sandglass::host

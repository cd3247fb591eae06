// How far a picture is from its truth, and how different the two look: structural similarity of what is displayed (Wang et al. 2004), and FLIP (Andersson et al.
// 2020), the difference that an observer sees when flipping between them. For the latter two, pictures have equal size
// and linear BT.709 values in 0..1; values outside are clamped, as on a display.
#pragma once

#include "models/rooms/panorama.h"

namespace sandglass::host {

double root_mean_square_error(const RadianceMap& truth, const RadianceMap& picture);  // (5.30)

// Of the sRGB-encoded luma, with a Gaussian window of deviation 1.5 pixels; the mean over the picture. 1: no
// difference.
double structural_similarity(const RadianceMap& truth, const RadianceMap& picture);

// An observer 0.7 m from a 0.7 m wide display of 3840 pixels, as the paper takes.
constexpr double k_pixels_per_degree = 67.0206;

// FLIP for each pixel, 0..1: contrast-filtered colours in a Hunt-adjusted L*a*b* compared by HyAB, sharpened where
// edges or points differ.
std::vector<double> flip_map(const RadianceMap& truth, const RadianceMap& picture,
                             double pixels_per_degree = k_pixels_per_degree);
double flip(const RadianceMap& truth, const RadianceMap& picture);  // its mean

}  // namespace sandglass::host

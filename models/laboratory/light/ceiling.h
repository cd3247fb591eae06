// The label ceiling: how well the true labels light an object. No network can beat its labels, so the ceiling bounds
// what training can reach. It decides, before anything is trained, between the variants of labels.h and between the
// rules that turn labels into radiance.
//
// For each view the probe scene is path traced under the warped panorama, exposed by the panorama's own tone map. It is
// also traced under a directional and an ambient light of strength 1; every variant's picture is a sum of these two.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "models/compositing/image_errors.h"
#include "models/lighting/labels.h"
#include "models/mesh/mesh.h"

namespace sandglass::host {

// How strong the directional light of colour c is, as irradiance on a facing surface, beside ambient radiance a:
//   plain            pi c
//   contrast_scaled  pi c o / (1 - o)
//   floor_share      as much as makes its share of the level floor's irradiance o (in luminance)
enum class Radiometry { plain, contrast_scaled, floor_share };
constexpr int k_radiometries = 3;
constexpr Radiometry k_chosen_radiometry = Radiometry::floor_share;  // the ceiling's choice

// Multiples of (directional light of irradiance pi, ambient light of radiance 1) that a radiometry asks for; the
// labels' direction with y up.
struct Strengths {
  Vec3 directional, ambient;
};
Strengths strengths_of(const LightLabels& labels, Radiometry radiometry);

// The picture in a light of these strengths, from the pictures in the two lights of strength 1. No channel is above 1.
RadianceMap lit_by(const Strengths& strengths, const RadianceMap& directional, const RadianceMap& ambient);
// What a camera with this tone map shows of it. No channel is above 1.
RadianceMap shown_by(RadianceMap radiance, double white);

struct CeilingVariant {
  Range range;
  AmbientWeight weight;
  Radiometry radiometry;
  Contrast contrast;  // unused by plain
  ImageErrors mean;   // over all views
};

struct ContrastError {
  double shadow_rmse =
      0.0;              // of the floor's shadow (1 - visibility) o against the traced one, where either is in shadow
  double offset = 0.0;  // mean of |o - best o|; the best is found by least squares on each view
  double low = 1.0, high = 0.0, mean = 0.0;  // of o
};

struct Ceiling {
  size_t panoramas = 0, views = 0;
  std::vector<CeilingVariant> variants;  // best RMSE first
  ContrastError contrasts[k_contrasts];
  double best_contrast_rmse = 0.0;  // with the best o of each view: the least error that one soft light can have
  // Shares of the views whose light is more than 45, 70 and 90 degrees from the zenith.
  double lights_beyond_45 = 0.0, lights_beyond_70 = 0.0, lights_below_horizon = 0.0;
};

struct CeilingOptions {
  std::vector<std::string> panoramas;
  Mesh object;
  int views = 8;     // of each panorama's eight
  int samples = 48;  // paths a pixel
  uint64_t seed = 1;
  uint32_t threads = 1;
};

Ceiling measure_ceiling(const CeilingOptions& options);

const char* name_of(Range range);
const char* name_of(AmbientWeight weight);
const char* name_of(Contrast contrast);
const char* name_of(Radiometry radiometry);

}  // namespace sandglass::host

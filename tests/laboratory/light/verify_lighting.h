// The evaluation of lighting. For views of panoramas, an estimator's light is compared with the labels, beside three
// estimators that learn nothing or look at nothing:
//   mean light   the mean of the labels of all panoramas of other folds and places
//   brightest    the brightest visible region: its mean direction and colour, the rest's mean colour as ambient
//   grey world   the image's mean colour; the light straight above the camera
// The latter two take the contrast, which an image does not show, from the mean light. The control is the estimate as in
// a mirror.
//
// Differences are paired and bootstrapped over places: views of one place are not independent.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "models/files/image.h"
#include "models/lighting/labels.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// The light in the camera's frame (x right, y down, z forward) of a 256 x 192 image; `name` is that of the data set's
// image, without .png. Called from one thread.
using LightEstimator = std::function<LightLabels(const Picture& image, const std::string& name)>;

// A table of estimates as train.py writes it: image, direction_x .. contrast. Anything else is refused with a Failure.
LightEstimator estimates_of_csv(const std::string& text, const std::string& path);

// Estimates that need no training: from the image alone, with a given contrast.
LightLabels brightest_region(const Picture& image, double contrast);
LightLabels grey_world(const Picture& image, double contrast);

struct LightingVerdictOptions {
  std::vector<std::string> panoramas;
  std::string manifest;  // places and folds; empty: each file is its own place
  LightEstimator estimator;
  uint64_t seed = 1;
  uint32_t threads = 1;
};

// Eight views of each panorama. Empty when it was interrupted.
std::vector<Verdict> verify_lighting(const LightingVerdictOptions& options);

}  // namespace sandglass::host

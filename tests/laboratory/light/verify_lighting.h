// The evaluation of lighting. For views of panoramas, an estimator's light is compared with the labels, and an object
// on a plane is path traced under the warped panorama and under the estimate. The same is done for the labels
// themselves (no network can beat them) and for three estimators that learn nothing or look at nothing:
//   mean light   the mean of the labels of all panoramas of other folds and places
//   brightest    the brightest visible region: its mean direction and colour, the rest's mean colour as ambient
//   grey world   the image's mean colour; the light straight above the camera
// The latter two take the contrast, which an image does not show, from the mean light.
//
// Differences to the baselines are paired and bootstrapped over places: views of one place are not independent.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "models/compositing/image_errors.h"
#include "models/files/image.h"
#include "models/lighting/labels.h"
#include "models/mesh/mesh.h"
#include "models/rooms/excerpt.h"
#include "tests/laboratory/interval.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// The light in the camera's frame (x right, y down, z forward) of a 256 x 192 image; `name` is that of the data set's
// image, without .png. Called from one thread.
using LightEstimator = std::function<LightLabels(const Picture& image, const std::string& name)>;

// A table of estimates as train.py writes it: image, direction_x .. contrast. Anything else is refused with a Failure.
LightEstimator estimates_of_csv(const std::string& text, const std::string& path);

// The panoramas in that table: "room_7" for the image "room_7_0.png".
std::set<std::string> panoramas_of_estimates(const std::string& text);

// Estimates that need no training: from the image alone, with a given contrast.
LightLabels brightest_region(const Picture& image, double contrast);
LightLabels grey_world(const Picture& image, double contrast);

struct LightErrors {
  double angle_deg = 0.0, light = 0.0, ambient = 0.0, contrast = 0.0;  // mean absolute differences of the latter three
  ImageErrors image;
};

enum class Contender { labels, estimate, mean, brightest, grey };
constexpr int k_light_sources = 5;
const char* name_of(Contender source);

struct LightView {
  std::string name, panorama, path, location;
  View view;
  LightLabels lights[k_light_sources];  // in the camera's frame; of those that there are
  LightErrors errors[k_light_sources];
};

struct LightingVerdicts {
  std::vector<LightView> views;
  bool has_estimate = false, has[k_light_sources] = {};  // the mean light needs other places
  bool rendered = false;                                 // if not, no view has image errors
  std::vector<Verdict> rows;                             // claims: pass or not
  std::vector<Picture> pictures;  // one view of each panorama: image with arrows; truth, labels, estimate, baselines
};

struct LightingVerdictOptions {
  std::vector<std::string> panoramas;
  std::string manifest;      // places and folds; empty: each file is its own place
  LightEstimator estimator;  // may be empty: only ceiling and baselines
  Mesh object;
  int views = 8;     // of each panorama's eight
  int samples = 48;  // paths a pixel; 0 renders nothing
  uint64_t seed = 1;
  uint32_t threads = 1;
};

LightingVerdicts verify_lighting(const LightingVerdictOptions& options);

// As text: means over all views by source; and by panorama as CSV.
std::string lighting_table(const LightingVerdicts& verdicts);
std::string lighting_csv(const LightingVerdicts& verdicts);
// The estimates themselves, as estimates_of_csv reads them.
std::string estimates_csv(const LightingVerdicts& verdicts);

}  // namespace sandglass::host

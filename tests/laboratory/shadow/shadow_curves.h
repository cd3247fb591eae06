// Error against time for bakes of one object. The curves vary the threshold of the adaptive mode, the size of the
// network, bytes or float, the size of the texture, and the plane: one that follows the light, or a fixed one.
//
// Planes and texture sizes are compared in the world. The truth is traced at the texel centres of the rectangle that is
// fitted to the light. A texture is read there by linear interpolation, as a GPU does; outside its own rectangle it is
// lit. Textures have 256 x 256 texels unless they are resampled.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "models/drawing/plot.h"
#include "models/mesh/mesh.h"
#include "sandglass/shadow.h"

namespace sandglass::host {

struct ShadowCurvePoint {
  std::string name;
  double ms = 0;      // of one texture, CPU time of one thread: the median over the lights of each light's best
  double rmse = 0;    // in the world, against ray tracing, the mean over the lights
  double number = 0;  // of the curve: threshold, parameters, texels a side
};

struct ShadowCurve {
  std::string name;  // thresholds, sizes_int8, sizes_adaptive, float, textures, fixed
  std::vector<ShadowCurvePoint> points;
};

struct NamedShadow {
  std::string name;  // of the file
  std::vector<uint8_t> bytes;
};

// `files`: bakes of `mesh`. Thresholds and texture sizes are measured on the first. The lights are those for which all
// were baked. `go_on` gets the steps done of `total`; if it returns false, the result is empty.
std::vector<ShadowCurve> measure_shadow_curves(const std::vector<NamedShadow>& files, const Mesh& mesh,
                                               sandglass_isa isa,
                                               const std::function<bool(uint32_t done, uint32_t total)>& go_on);

Plot shadow_curve_plot(const std::vector<ShadowCurve>& curves, const std::string& object);

}  // namespace sandglass::host

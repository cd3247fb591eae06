// What one estimate of the lighting network costs and how true it is by every back end that this build has, on one
// thread of this machine, through the API that an app calls: the project's own kernels and, where it is installed,
// XNNPACK, on the same file and the same image.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "models/lighting/excerpts.h"
#include "sandglass/light.h"

namespace sandglass::host {

struct LightingBenchRow {
  std::string name;            // int8, xnnpack_f32, xnnpack_int8
  double ms = 0;               // of this thread's CPU time, the best of some repeats: the machine may be shared
  double gmac_per_s = 0;       // of the network's 2.549 G, whatever padding is computed besides
  double fraction = 0;         // of this CPU's measured peak, f32 or int8
  double arena_bytes = 0;      // weights and activations: the block, and what XNNPACK holds of its region
  double activations = 0;      // of them; own kernels only
  double longest_unit_ms = 0;  // the largest of the units' best times
  // Against the float network, medians over the images; 0 where it is not known what that says.
  double angle_deg = 0;                // of the direction
  double difference = 0;               // the greatest of colours and contrast
  std::vector<LightValues> estimates;  // of each image
  struct Part {
    std::string name;
    double ms;
  };
  std::vector<Part> parts;  // by kind of operator
};

// Resampling a camera's image to what the network sees, which is mandatory in the frame that brings the image.
struct LightingImageRow {
  std::string name;       // 640x480_nv12 ...
  double megapixels = 0;  // of the camera's image
  uint32_t units = 0;
  double ms = 0;               // the sum of the units' best times
  double longest_unit_ms = 0;  // the largest of them
};

struct LightingBench {
  std::vector<LightingBenchRow> rows;
  std::vector<LightingImageRow> images;
  std::vector<LightingBenchRow::Part> layers;  // of own bytes, by operator, in order
  double int8_peak = 0, f32_peak = 0;          // GMAC/s
  bool has_xnnpack = false;                    // in this build
  bool compared = false;                       // to float, and not interrupted
};

// `file`: the bytes of a lighting network's file. `excerpts`: images, and what the file's float network says of them;
// the first is timed. None: a wall with a lamp on it, made from a formula, and truth is what xnnpack_f32 says, which is
// the float network where the file carries it, else the file's weights without further rounding. `go_on` gets the steps
// done of `total`.
LightingBench bench_lighting(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                             const std::vector<Excerpt>& excerpts,
                             const std::function<bool(uint32_t done, uint32_t total)>& go_on);

}  // namespace sandglass::host

// What one estimate of the lighting network costs and how exact it is, for every back end of this build: the library's
// own kernels and, if it is installed, XNNPACK. All run the same file on the same images, on one thread, through the
// API that an app calls.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "models/lighting/excerpts.h"
#include "sandglass/estimate.h"

namespace sandglass::host {

struct LightingBenchRow {
  std::string name;            // int8, xnnpack_f32, xnnpack_int8
  double ms = 0;               // CPU time of the thread, the best of some repeats: the machine may be shared
  double gmac_per_s = 0;       // of the network's 2.549 G multiplications; padding does not count
  double arena_bytes = 0;      // weights and activations: the block, and what XNNPACK holds of its region
  double longest_unit_ms = 0;  // the largest of the work units' best times
  // Against the float network, medians over the images.
  double angle_deg = 0;                // of the direction
  double difference = 0;               // the greatest of colours and contrast
  std::vector<LightValues> estimates;  // of each image
};

struct LightingBench {
  std::vector<LightingBenchRow> rows;
  bool has_xnnpack = false;  // in this build
  bool compared = false;     // to float, and not interrupted
};

// `file`: the bytes of a lighting network's file. `excerpts`: images with the estimates of the file's float network;
// the first one is timed. `go_on` gets the steps done of `total`.
LightingBench bench_lighting(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                             const std::vector<Excerpt>& excerpts,
                             const std::function<bool(uint32_t done, uint32_t total)>& go_on);

}  // namespace sandglass::host

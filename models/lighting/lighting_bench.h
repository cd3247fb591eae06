// What one estimate of the lighting network costs for every way of computing it, on one thread of this machine: the
// project's own kernels, the plain float network and, where XNNPACK is installed, XNNPACK on the same file.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

struct LightingBenchRow {
  std::string name;            // int8, f32, xnnpack_f32, xnnpack_int8
  double ms = 0;               // of this thread's CPU time, the best of some repeats: the machine may be shared
  double gmac_per_s = 0;       // of the network's 2.549 G, whatever padding is computed besides
  double fraction = 0;         // of this CPU's measured peak, f32 or int8
  double arena_bytes = 0;      // weights and activations; own kernels: the block
  double activations = 0;      // of them; own kernels only
  double longest_unit_ms = 0;  // the largest of the units' best times; of a peer, of an operator
  double relative_error = 0;   // of the 1024 features, against the own bytes
  struct Part {
    std::string name;
    double ms;
  };
  std::vector<Part> parts;  // by kind of operator
};

struct LightingBench {
  std::vector<LightingBenchRow> rows;
  std::vector<LightingBenchRow::Part> layers;  // of own bytes, by operator, in order
  double int8_peak = 0, f32_peak = 0;          // GMAC/s
  bool has_xnnpack = false;
};

// `file`: the bytes of a lighting network's file. `go_on` gets the steps done of `total`.
LightingBench bench_lighting(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                             const std::function<bool(uint32_t done, uint32_t total)>& go_on);

}  // namespace sandglass::host

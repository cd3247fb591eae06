// What one texture costs and how wrong it is, for every way of computing it, on one thread of this machine.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/baking/network.h"
#include "models/baking/training_set.h"
#include "models/mesh/mesh.h"
#include "sandglass/shadow.h"

namespace sandglass::host {

struct ShadowBenchRow {
  std::string name;       // f32, int8, int8_adaptive
  double ms = 0;          // CPU time of the thread: each light's best of some repeats, the median over the lights
  double gmac_per_s = 0;  // of what it computes
  double rmse = 0;        // against the float network
  double rmse_truth = 0;  // against ray tracing
  double evaluated = 1;   // share of the texels that the network was asked for
};

struct ShadowBench {
  std::vector<ShadowBenchRow> rows;
  // Of one ambient shadow: CPU time, and the error that the file states. 0: the file has none.
  double ambient_ms = 0, ambient_rmse = 0;
};

// A baked file and the mesh that it was made from.
struct BakedShadow {
  LightGeometry geometry;
  FloatNetwork network;     // without parameters where the file does not carry them
  double ambient_rmse = 0;  // that the file states; 0: it has no ambient shadow
};

// A Failure says that the file is damaged, or that it was baked from another mesh.
BakedShadow open_baked_shadow(std::span<const uint8_t> file, const std::string& name, const Mesh& mesh);

// `file` must contain its float network; `mesh` is what it was baked from. `go_on` gets the steps done of `total`.
ShadowBench bench_shadow(std::span<const uint8_t> file, const std::string& name, const Mesh& mesh, sandglass_isa isa,
                         const std::function<bool(uint32_t done, uint32_t total)>& go_on);

}  // namespace sandglass::host

// How much of each cell of light an object hides from the floor around it, by rays.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/tracing/embree_scene.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

// The square of the floor that is looked at: its middle is the footprint's centre.
struct FloorSquare {
  double half = 0;    // half its edge, in the unit of the mesh
  uint32_t side = 0;  // texels
};

// Each cell has 4 x 4 strata of equal cosine-weighted solid angle: first along its azimuth, then upwards.
constexpr uint32_t k_strata_side = 4, k_cell_strata = k_strata_side * k_strata_side;
enum class HiddenOf { cells, strata };

// 1 - visibility for each texel (rows along z) and, within it, each cell or each stratum of each cell: the
// cosine-weighted share that the object hides, averaged over the texel. The floor is y = 0. After every few rows
// `go_on` is called with the number of rows done; when it returns false, tracing stops and the result is empty.
std::vector<float> trace_hidden(const EmbreeScene& object, const FloorSquare& square, HiddenOf parts, uint64_t seed,
                                ThreadPool& pool, const std::function<bool(uint32_t)>& go_on);

}  // namespace sandglass::host

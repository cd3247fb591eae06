// The cells of light of types.h: their geometry, and what is expected of a room that nobody has seen.
#pragma once

#include <cstdint>

#include "sandglass/types.h"

namespace sandglass {

constexpr uint32_t k_light_cells = SANDGLASS_LIGHT_CELLS;
constexpr uint32_t k_cell_sectors = 16;  // of azimuth, 22.5 degrees each, the first from +x towards +z
constexpr uint32_t k_cell_rings = k_light_cells / k_cell_sectors;

// The sine of the elevation at the lower edge of each ring: the square root of ring / 4. Every ring has the same
// cosine-weighted solid angle, pi / 4.
constexpr double k_ring_sines[k_cell_rings + 1] = {0.0, 0.5, 0.7071067811865476, 0.8660254037844386, 1.0};

// The share of each cell of a ring in a room that nobody has seen. An even sky is as good a guess as any that was
// fitted to captured interiors (models/RESULTS.md).
constexpr float k_prior_ring_shares[k_cell_rings] = {1.0f / 64, 1.0f / 64, 1.0f / 64, 1.0f / 64};

}  // namespace sandglass

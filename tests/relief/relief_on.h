// Reliefs of any heights, as a test or the laboratory shapes them, and sand on one.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "runtime/relief/relief.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::tests {

// Shows the heights at the middles of cells, metres, at places in the plane.
inline void shape(Relief* relief, const std::function<double(double x, double z)>& height) {
  ReliefState* r = &relief->get()->relief;
  for (uint32_t i = 0; i < relief_cells(*r); ++i) {
    const double cell = static_cast<double>(r->desc.cell),
                 x = cell * (i % r->desc.cells[0] + 0.5 - 0.5 * r->desc.cells[0]),
                 z = cell * (i / r->desc.cells[0] + 0.5 - 0.5 * r->desc.cells[1]);
    relief_set_cell(r, i, static_cast<int16_t>(std::lround(height(x, z) * 4000)));
  }
  relief_end_change(r);
  ++r->version;
}

// Metres between four middles of cells, over a plane that is not turned. Beyond the outer ones: as at them.
inline double height_at(const Relief& relief, double x, double z) {
  const sandglass_heights h = relief.heights();
  const double p[2] = {x, z};
  double at[2];
  for (int k = 0; k < 2; ++k)
    at[k] = std::clamp((p[k] - static_cast<double>(h.corner[2 * k])) / static_cast<double>(h.cell) - 0.5, 0.0,
                       h.cells[k] - 1.001);
  const auto i = static_cast<uint32_t>(at[0]), j = static_cast<uint32_t>(at[1]);
  const double u = at[0] - i, v = at[1] - j;
  const auto node = [&](uint32_t a, uint32_t b) { return static_cast<double>(h.heights[b * h.cells[0] + a]); };
  return (1 - v) * ((1 - u) * node(i, j) + u * node(i + 1, j)) +
         v * ((1 - u) * node(i, j + 1) + u * node(i + 1, j + 1));
}

}  // namespace sandglass::tests

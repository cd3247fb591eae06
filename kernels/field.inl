// A collider whose surface is the zero of a grid of signed distances: trilinear interpolation and its gradient. Nothing
// is fetched where no lane is within the grid. The result of a lane does not depend on the other lanes.

// The value at a share of the way through a cell, and the gradient in cells.
SANDGLASS_INLINE Float field_value(const FieldGrid& grid, const Float cell[3], const Float share[3],
                                   Float gradient[3]) {
  const Float nx = broadcast(static_cast<float>(grid.counts[0])), ny = broadcast(static_cast<float>(grid.counts[1]));
  const Int base = to_int(cell[0] + nx * (cell[1] + ny * cell[2]));
  Float corner[2][2][2];  // [z][y][x]
  for (uint32_t k = 0; k < 8; ++k) {
    const uint32_t dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
    const uint32_t step = dx + grid.counts[0] * (dy + grid.counts[1] * dz);
    corner[dz][dy][dx] = gather(grid.values + step, base);
  }
  const Float u = share[0], v = share[1], w = share[2];
  Float edge[2][2], slope[2][2];  // along x
  for (int dz = 0; dz < 2; ++dz) {
    for (int dy = 0; dy < 2; ++dy) {
      slope[dz][dy] = corner[dz][dy][1] - corner[dz][dy][0];
      edge[dz][dy] = corner[dz][dy][0] + u * slope[dz][dy];
    }
  }
  const Float low = edge[0][0] + v * (edge[0][1] - edge[0][0]), high = edge[1][0] + v * (edge[1][1] - edge[1][0]);
  const Float slope_low = slope[0][0] + v * (slope[0][1] - slope[0][0]);
  const Float slope_high = slope[1][0] + v * (slope[1][1] - slope[1][0]);
  gradient[0] = slope_low + w * (slope_high - slope_low);
  gradient[1] = (edge[0][1] - edge[0][0]) + w * ((edge[1][1] - edge[1][0]) - (edge[0][1] - edge[0][0]));
  gradient[2] = high - low;
  return low + w * (high - low);
}

SANDGLASS_INLINE Surface field_surface(const ColliderFrame& c, Float x, Float y, Float z) {
  const FieldGrid& grid = c.field;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  Float cell[3], share[3], out[3], out2 = zero;
  for (int k = 0; k < 3; ++k) {
    const Float local = dot3(x, y, z, broadcast(c.axes[k][0]), broadcast(c.axes[k][1]), broadcast(c.axes[k][2]));
    const Float at = (local - broadcast(grid.low[k])) * broadcast(grid.inverse_spacing);
    const Float last = broadcast(static_cast<float>(grid.counts[k] - 1));
    const Float within = minimum(maximum(at, zero), last);
    out[k] = (at - within) * broadcast(grid.spacing);
    out2 = out2 + out[k] * out[k];
    cell[k] = minimum(to_float(to_int(within)), last - one);
    share[k] = within - cell[k];
  }
  const Mask beyond = zero < out2;
  const Float distance_out = square_root(select(beyond, out2, one));
  Float value = zero, gradient[3] = {zero, zero, zero};
  if (!all(beyond)) value = field_value(grid, cell, share, gradient);
  // Beyond the grid: the surface is at least as far from the grid's faces as the border value says. With free space
  // around the grid that bounds the distance from below, with solid around it the depth.
  const Float border = broadcast(grid.border), outward = broadcast(grid.outward);
  const Float far = grid.outward > 0.0f ? maximum(distance_out, border) : border - distance_out;
  Float length2 = zero;
  for (int k = 0; k < 3; ++k) {
    gradient[k] = select(beyond, outward * out[k], gradient[k]);
    length2 = length2 + gradient[k] * gradient[k];
  }
  // Without a gradient, as on a ridge, the normal is local y, as at the centre of a sphere. With solid around the grid it
  // leads to the middle: in a container's corner, and on an edge of the grid, nodes are equally deep.
  const Float flat = broadcast(1e-12f);
  if (grid.outward < 0.0f && !all(flat < length2)) {
    const Mask keeps = flat < length2;
    length2 = zero;
    for (int k = 0; k < 3; ++k) {
      const Float middle = broadcast(0.5f * static_cast<float>(grid.counts[k] - 1));
      const Float inward = (middle - (cell[k] + share[k])) * broadcast(grid.spacing) - out[k];
      gradient[k] = select(keeps, gradient[k], inward);
      length2 = length2 + gradient[k] * gradient[k];
    }
  }
  const Mask steep = flat < length2;
  const Float scale = one / square_root(select(steep, length2, one));
  for (int k = 0; k < 3; ++k) gradient[k] = select(steep, gradient[k] * scale, k == 1 ? one : zero);
  Float n[3];
  for (int k = 0; k < 3; ++k) {
    n[k] = gradient[0] * broadcast(c.axes[0][k]) + gradient[1] * broadcast(c.axes[1][k]) +
           gradient[2] * broadcast(c.axes[2][k]);
  }
  return {select(beyond, far, value), n[0], n[1], n[2]};
}

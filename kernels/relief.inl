// A collider whose surface is a map of heights over local x and z: bilinear interpolation. The distance is that from the
// plane which touches the surface above or below the point; on steep ground that is short of the vertical one by the
// cosine. Nodes are an array as a field's values, with counts[1] = 1. The result of a lane does not depend on the others.

// Metres below local y = 0: so far the face goes down in which the map ends, over the cell beyond its outer nodes.
constexpr float k_relief_face = 0.05f;

// Where the height over points is, and its slope along x and z, metres a cell.
struct HeightAt {
  Float height, slope[2];
};

SANDGLASS_INLINE HeightAt height_at(const FieldGrid& grid, const Float cell[2], const Float share[2]) {
  const float width = static_cast<float>(grid.counts[0]);
  const float *nodes = grid.values, *next = nodes + grid.counts[0];
  const Int base = to_int(cell[0] + broadcast(width) * cell[1]);
  const Float a = gather(nodes, base), b = gather(nodes + 1, base), c = gather(next, base), d = gather(next + 1, base);
  const Float near = b - a, far = d - c;
  const Float low = a + share[0] * near, high = c + share[0] * far;
  return {low + share[1] * (high - low), {near + share[1] * (far - near), high - low}};
}

// Beyond the outer nodes: the height falls to the face's foot over a cell. `out`: cells beyond, along x and z.
SANDGLASS_INLINE HeightAt fall_off(const HeightAt& at, const Float out[2]) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const Float x = absolute(out[0]), z = absolute(out[1]), far = minimum(maximum(x, z), one);
  const Float deep = at.height + broadcast(k_relief_face);
  HeightAt fallen = {at.height - far * deep, {at.slope[0], at.slope[1]}};
  const Mask aside[2] = {z < x, x <= z}, beyond = zero < far;
  for (int k = 0; k < 2; ++k) {
    const Float down = select(out[k] < zero, deep, zero - deep),
                along = keep(out[k] == zero, (one - far) * at.slope[k]);
    fallen.slope[k] = select(beyond, select(aside[k], down, along), at.slope[k]);
  }
  return fallen;
}

SANDGLASS_INLINE Surface relief_surface(const ColliderFrame& c, Float x, Float y, Float z) {
  constexpr float k_nothing = 1e4f;  // metres: farther than anything is
  const FieldGrid& grid = c.field;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), inverse = broadcast(grid.inverse_spacing);
  Float cell[2], share[2], out[2];
  for (int k = 0; k < 2; ++k) {
    const float* axis = c.axes[2 * k];
    const Float local = dot3(x, y, z, broadcast(axis[0]), broadcast(axis[1]), broadcast(axis[2]));
    const Float at = (local - broadcast(grid.low[2 * k])) * inverse;
    const Float last = broadcast(static_cast<float>(grid.counts[2 * k] - 1));
    const Float within = minimum(maximum(at, zero), last);
    out[k] = at - within;
    cell[k] = minimum(to_float(to_int(within)), last - one);
    share[k] = within - cell[k];
  }
  HeightAt at = height_at(grid, cell, share);
  Mask nothing = zero < zero;
  if (any((zero < absolute(out[0])) | (zero < absolute(out[1])))) {
    at = fall_off(at, out);
    nothing = (one < absolute(out[0])) | (one < absolute(out[1]));
  }
  const float* up = c.axes[1];
  const Float above = dot3(x, y, z, broadcast(up[0]), broadcast(up[1]), broadcast(up[2])) - at.height;
  const Float slope[2] = {at.slope[0] * inverse, at.slope[1] * inverse};
  const Float cosine = one / square_root(one + (slope[0] * slope[0] + slope[1] * slope[1]));
  const Float down[2] = {cosine * slope[0], cosine * slope[1]};
  Float n[3];
  for (int k = 0; k < 3; ++k) {
    const Float level = down[0] * broadcast(c.axes[0][k]) + down[1] * broadcast(c.axes[2][k]);
    n[k] = cosine * broadcast(up[k]) - level;
  }
  const Float offset = broadcast(c.offset), distance = (above - offset) * cosine + offset;
  return {select(nothing, broadcast(k_nothing), distance), n[0], n[1], n[2]};
}

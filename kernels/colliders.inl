// Signed distance (positive outside) and outward normal of a collider at k_width points.

struct Surface {
  Float distance;
  Float nx, ny, nz;
};

SANDGLASS_INLINE Float dot3(Float ax, Float ay, Float az, Float bx, Float by, Float bz) {
  return ax * bx + ay * by + az * bz;
}

// A ball whose centre lies at minus (x, y, z) from the point. At the centre, where no direction is outward, the normal
// is `axis`.
SANDGLASS_INLINE Surface ball(Float x, Float y, Float z, float radius, const float axis[3]) {
  const Float length2 = dot3(x, y, z, x, y, z);
  const Mask away = broadcast(1e-24f) < length2;
  const Float length = square_root(select(away, length2, broadcast(1.0f)));
  const Float inverse = broadcast(1.0f) / length;
  return {keep(away, length) - broadcast(radius), select(away, x * inverse, broadcast(axis[0])),
          select(away, y * inverse, broadcast(axis[1])), select(away, z * inverse, broadcast(axis[2]))};
}

SANDGLASS_INLINE Surface box(const ColliderFrame& c, Float x, Float y, Float z) {
  Float inside_depth = broadcast(-3e38f);
  Float inside_n[3] = {broadcast(0.0f), broadcast(0.0f), broadcast(0.0f)};
  Float out[3];
  for (int a = 0; a < 3; ++a) {
    const float* axis = c.axes[a];
    const Float local = dot3(x, y, z, broadcast(axis[0]), broadcast(axis[1]), broadcast(axis[2]));
    const Float half = broadcast(c.size[a]);
    out[a] = local - minimum(maximum(local, broadcast(-c.size[a])), half);
    const Float depth = absolute(local) - half;  // negative inside; the face of least depth is nearest
    const Mask nearest = inside_depth < depth;
    const Float sign = select(local < broadcast(0.0f), broadcast(-1.0f), broadcast(1.0f));
    inside_depth = select(nearest, depth, inside_depth);
    for (int k = 0; k < 3; ++k) inside_n[k] = select(nearest, sign * broadcast(axis[k]), inside_n[k]);
  }
  const Float length2 = dot3(out[0], out[1], out[2], out[0], out[1], out[2]);
  const Mask outside = broadcast(1e-24f) < length2;
  const Float length = square_root(select(outside, length2, broadcast(1.0f)));
  const Float inverse = broadcast(1.0f) / length;
  Surface s;
  s.distance = select(outside, length, inside_depth);
  Float n[3];
  for (int k = 0; k < 3; ++k) {
    const Float world =
        out[0] * broadcast(c.axes[0][k]) + out[1] * broadcast(c.axes[1][k]) + out[2] * broadcast(c.axes[2][k]);
    n[k] = select(outside, world * inverse, inside_n[k]);
  }
  s.nx = n[0];
  s.ny = n[1];
  s.nz = n[2];
  return s;
}

#include "kernels/field.inl"
#include "kernels/relief.inl"

// One copy for all kernels: together they are a quarter of their code.
SANDGLASS_NOINLINE Surface bounded_surface(const ColliderFrame& c, Float x, Float y, Float z) {
  const float* up = c.axes[1];
  switch (c.shape) {
    case SANDGLASS_SHAPE_CAPSULE: {
      const Float along = dot3(x, y, z, broadcast(up[0]), broadcast(up[1]), broadcast(up[2]));
      const Float t = minimum(maximum(along, broadcast(-c.size[1])), broadcast(c.size[1]));
      return ball(x - t * broadcast(up[0]), y - t * broadcast(up[1]), z - t * broadcast(up[2]), c.size[0], c.axes[0]);
    }
    case SANDGLASS_SHAPE_BOX:
      return box(c, x, y, z);
    case SANDGLASS_SHAPE_FIELD:
      return field_surface(c, x, y, z);
    case SANDGLASS_SHAPE_RELIEF:
      return relief_surface(c, x, y, z);
    default:
      return ball(x, y, z, c.size[0], up);
  }
}

SANDGLASS_INLINE Surface collider_surface(const ColliderFrame& c, Float px, Float py, Float pz) {
  const Float x = px - broadcast(c.position[0]), y = py - broadcast(c.position[1]), z = pz - broadcast(c.position[2]);
  if (c.shape != SANDGLASS_SHAPE_HALF_SPACE) return bounded_surface(c, x, y, z);
  const float* up = c.axes[1];
  return {dot3(x, y, z, broadcast(up[0]), broadcast(up[1]), broadcast(up[2])), broadcast(up[0]), broadcast(up[1]),
          broadcast(up[2])};
}

// Whether all lanes are far from a box, a capsule or a ball, or above a relief by `margin`, which is its offset. What is
// rounded away is less than the hundredth more.
SANDGLASS_INLINE bool far_from(const ColliderFrame& c, const Float position[3], float margin) {
  if (c.shape == SANDGLASS_SHAPE_HALF_SPACE || c.shape == SANDGLASS_SHAPE_FIELD) return false;
  const Float x = position[0] - broadcast(c.position[0]), y = position[1] - broadcast(c.position[1]),
              z = position[2] - broadcast(c.position[2]), more = broadcast(1.001f * margin);
  if (c.shape == SANDGLASS_SHAPE_RELIEF) {
    const float* up = c.axes[1];
    const Float above = dot3(x, y, z, broadcast(up[0]), broadcast(up[1]), broadcast(up[2]));
    return all(broadcast(1.001f * greatest_height(c.field)) + more < above);
  }
  if (all((broadcast(c.extent[0]) + more < absolute(x)) | (broadcast(c.extent[1]) + more < absolute(y)) |
          (broadcast(c.extent[2]) + more < absolute(z))))
    return true;
  if (c.shape == SANDGLASS_SHAPE_BOX) {
    const Float zero = broadcast(0.0f);
    Float beyond2 = zero;
    for (int a = 0; a < 3; ++a) {
      const float* axis = c.axes[a];
      const Float local = dot3(x, y, z, broadcast(axis[0]), broadcast(axis[1]), broadcast(axis[2]));
      const Float beyond = maximum(absolute(local) - broadcast(c.size[a]), zero);
      beyond2 = beyond2 + beyond * beyond;
    }
    const float reach = 1.01f * margin;
    return all(broadcast(reach * reach) < beyond2);
  }
  const float reach = 1.001f * (c.size[0] + (c.shape == SANDGLASS_SHAPE_CAPSULE ? c.size[1] : 0.0f) + margin);
  return all(broadcast(reach * reach) < dot3(x, y, z, x, y, z));
}

// The velocity of a rigid motion at a point, m/s.
SANDGLASS_INLINE void motion_at(const float linear[3], const float angular[3], Float x, Float y, Float z, Float v[3]) {
  const Float wx = broadcast(angular[0]), wy = broadcast(angular[1]), wz = broadcast(angular[2]);
  v[0] = broadcast(linear[0]) + (wy * z - wz * y);
  v[1] = broadcast(linear[1]) + (wz * x - wx * z);
  v[2] = broadcast(linear[2]) + (wx * y - wy * x);
}

// Velocity of the collider's material at a point of its surface, m/s. Along the normal only what its pose goes counts.
SANDGLASS_INLINE void collider_velocity(const ColliderFrame& c, Float px, Float py, Float pz, const Float normal[3],
                                        Float v[3]) {
  const Float x = px - broadcast(c.position[0]), y = py - broadcast(c.position[1]), z = pz - broadcast(c.position[2]);
  motion_at(c.linear, c.angular, x, y, z, v);
  if (c.slides == 0) return;
  Float slide[3];
  motion_at(c.slide, c.slide_turn, x, y, z, slide);
  const Float out = dot3(slide[0], slide[1], slide[2], normal[0], normal[1], normal[2]);
  for (int k = 0; k < 3; ++k) v[k] = v[k] - out * normal[k];
}

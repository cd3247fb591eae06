// What a collider, still or in motion, does to a particle: it pushes it out and takes it along by friction. Its mass is
// infinite. Both contact schemes end with it.

// The static coefficient squared; the kinetic one.
struct FrictionTerms {
  Float static2, kinetic;
};

template <class Args>
SANDGLASS_INLINE FrictionTerms friction_terms(const Args* a) {
  return {broadcast(a->static_friction * a->static_friction), broadcast(a->kinetic_friction)};
}

// How much of a tangential displacement t friction takes against a normal correction of this length. It sticks while
// |t| <= mu_s |normal|; else it slides with mu_k |normal| / |t|, at most 1 (4.24-4.27).
SANDGLASS_INLINE Float friction_grip(const FrictionTerms& c, Float t2, Float normal, Mask touch) {
  const Float one = broadcast(1.0f);
  const Mask slides = c.static2 * (normal * normal) < t2;
  if (!any(slides & touch)) return one;
  const Float longest = square_root(maximum(t2, broadcast(1e-30f)));
  return select(slides, minimum((c.kinetic * absolute(normal)) / longest, one), one);
}

// Pushes particles out of the colliders one after another: their displacement while solving, else their position.
//
// What is deeper in a collider than this sub-step's own motion leaves it with the collider's velocity plus a limited
// speed (leave_max): a collider that jumped, or that appeared in sand, throws nothing. Since a push always undoes the
// motion into the collider, a particle gets no deeper into the last collider that pushes it, whatever the others did.
template <bool k_solve>
SANDGLASS_INLINE void leave_colliders(const CompleteArgs* a, const FrictionTerms& t, Float position[3],
                                      Float displacement[3]) {
  for (uint32_t c = 0; c < a->collider_count; ++c) {
    const ColliderFrame& collider = a->colliders[c];
    const Float px = position[0] + displacement[0], py = position[1] + displacement[1],
                pz = position[2] + displacement[2];
    const Float place[3] = {px, py, pz};
    if (far_from(collider, place, a->radius)) continue;
    const Surface surface = collider_surface(collider, px, py, pz);
    const Float depth = broadcast(a->radius) - surface.distance;
    const Mask hit = broadcast(0.0f) < depth;
    if (!any(hit)) continue;
    const Float normal[3] = {surface.nx, surface.ny, surface.nz};
    if (!k_solve) {
      for (int k = 0; k < 3; ++k) position[k] = position[k] + keep(hit, depth * normal[k]);
      continue;
    }
    Float v[3];
    collider_velocity(collider, px, py, pz, normal, v);
    const Float step = broadcast(a->step);
    // The collider's displacement minus the particle's, without its normal part. The particle makes up all of it.
    const Float rx = step * v[0] - displacement[0], ry = step * v[1] - displacement[1],
                rz = step * v[2] - displacement[2];
    const Float along = dot3(rx, ry, rz, surface.nx, surface.ny, surface.nz);
    const Float tangent[3] = {rx - along * surface.nx, ry - along * surface.ny, rz - along * surface.nz};
    const Float t2 = dot3(tangent[0], tangent[1], tangent[2], tangent[0], tangent[1], tangent[2]);
    const Float push = minimum(depth, maximum(along + broadcast(a->leave_max), broadcast(0.0f)));
    const Float grip = friction_grip(t, t2, push, hit);
    for (int k = 0; k < 3; ++k) displacement[k] = displacement[k] + keep(hit, push * normal[k] + grip * tangent[k]);
  }
}

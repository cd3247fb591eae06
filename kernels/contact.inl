// One Jacobi pass. Every particle gathers the corrections of its contacts from the positions before the pass, by
// (4.14)-(4.27) of the dissertation. It adds them with a fixed factor or averaged (4.37), and is then pushed out of the
// colliders, whose mass is infinite. Where the equations differ from the printed ones, runtime/README.md says why
// ("Corrections").
//
// A particle holds the position at the start of the sub-step and the displacement since then. Predicted positions are
// never stored (correction to Alg. 4): a relative position is (x_j - x_i) + (displacement_j - displacement_i), exact to
// the last bits of the small quantities. With one iteration the whole sub-step is this one pass.

// Height weighting (correction to 4.38): 1/(1 + exp(k c)) - 1/2 as a cubic of c = n . up, which says how much more than
// half of a correction this particle takes. One side takes more by what the other takes less, so every contact lifts
// the pair. That lift carries the layers above. It must not exceed their weight, or towers jump and impacts throw. So
// the sum that weighting adds to a particle is limited to a multiple of gravity's own displacement (lift_max).
SANDGLASS_INLINE Float height_share(const ContactArgs* a, Float nx, Float ny, Float nz) {
  const Float c = dot3(nx, ny, nz, broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2]));
  return c * (broadcast(a->weight_linear) + broadcast(a->weight_cubic) * (c * c));
}

// Coincident particles part along a fixed direction that both sides agree on: a unit vector chosen by the indices of
// the pair.
SANDGLASS_INLINE void part_coincident(uint32_t first, const uint32_t* index, Mask coincident, Float* nx, Float* ny,
                                      Float* nz) {
  alignas(64) float ux[k_lane_group], uy[k_lane_group], uz[k_lane_group];
  for (uint32_t l = 0; l < k_width; ++l) {
    const uint32_t i = first + l, j = index[l * k_list_slots];
    const float side = i < j ? 1.0f : -1.0f;
    ux[l] = ((i + j) & 1u) != 0 ? side * 0.36f : side * -0.36f;  // 0.36^2 + 0.8^2 + 0.48^2 = 1
    uy[l] = side * 0.8f;
    uz[l] = ((i + j) & 2u) != 0 ? side * 0.48f : side * -0.48f;
  }
  *nx = select(coincident, load(ux), *nx);
  *ny = select(coincident, load(uy), *ny);
  *nz = select(coincident, load(uz), *nz);
}

// Particles of one rigid body do not touch each other: the upper bits of the number name the body.
SANDGLASS_INLINE Mask same_body(Float a, Float b) {
  const Int body = as_int(a) & broadcast(static_cast<int32_t>(~k_number_mask));
  return and_not(body == (as_int(b) & broadcast(static_cast<int32_t>(~k_number_mask))), body == broadcast(0));
}

template <bool k_solve, bool k_weighted>
SANDGLASS_INLINE void contact_pass(const ContactArgs* a, uint32_t begin, uint32_t end, ContactExtent* extent) {
  const Float zero = broadcast(0.0f), half = broadcast(0.5f), one = broadcast(1.0f), tiny = broadcast(1e-30f);
  const Float scale = broadcast(a->scale);
  const Float gx = broadcast(a->gravity[0]), gy = broadcast(a->gravity[1]), gz = broadcast(a->gravity[2]);
  const Float diameter = broadcast(a->diameter), diameter2 = diameter * diameter;
  const Float static2 = broadcast(a->static_friction * a->static_friction), kinetic = broadcast(a->kinetic_friction);
  const Float omega = broadcast(a->relaxation);
  const float huge = 3e38f;
  Float speed2 = zero;
  Float low[3], high[3], move_low[3], move_high[3];
  for (int k = 0; k < 3; ++k) low[k] = move_low[k] = broadcast(huge), high[k] = move_high[k] = broadcast(-huge);
  uint32_t quarantined = 0;

  for (uint32_t item = begin; item < end; item += k_width) {
    const uint32_t i = a->groups[item / k_lane_group] * k_lane_group + item % k_lane_group;
    Float self[k_record_floats];
    load_records(floats_of(a->in + i), self);
    const Float w = self[k_mobility];
    const Mask moves = zero < w;
    const Float pull = keep(moves, one);  // gravity acts on what moves
    // Displacement of this particle over the sub-step so far.
    Float dx = zero, dy = zero, dz = zero;
    if (k_solve)
      dx = scale * self[k_vx] + gx * pull, dy = scale * self[k_vy] + gy * pull, dz = scale * self[k_vz] + gz * pull;
    Mask wakes = zero < zero;

    Float sx = zero, sy = zero, sz = zero, contacts = zero;
    Float lx = zero, ly = zero, lz = zero;  // what height weighting adds
    uint32_t slots = 0;
    for (uint32_t l = 0; l < k_width; ++l) slots = a->counts[i + l] > slots ? a->counts[i + l] : slots;
    const uint32_t* row = a->lists + static_cast<uint64_t>(i) * k_list_slots;
    for (uint32_t s = 0; s < slots; ++s) {
      Float other[k_record_floats];
      load_records(floats_of(a->in), row + s, k_list_slots, other);
      Float rx = zero, ry = zero, rz = zero;  // relative displacement (correction to 4.17)
      Float ex = other[k_x] - self[k_x], ey = other[k_y] - self[k_y], ez = other[k_z] - self[k_z];
      const Mask free = zero < other[k_mobility];
      if (k_solve) {
        const Float relative_pull = keep(free, one) - pull;
        rx = scale * (other[k_vx] - self[k_vx]) + gx * relative_pull;
        ry = scale * (other[k_vy] - self[k_vy]) + gy * relative_pull;
        rz = scale * (other[k_vz] - self[k_vz]) + gz * relative_pull;
        ex = ex + rx, ey = ey + ry, ez = ez + rz;
      }
      const Float d2 = dot3(ex, ey, ez, ex, ey, ez);
      Mask touch = d2 < diameter2;
      if (a->bodies != 0) touch = and_not(touch, same_body(self[k_identity], other[k_identity]));
      if (!any(touch)) continue;
      const Float d = square_root(maximum(d2, tiny));  // no lane divides by zero, touching or not
      const Float inverse = one / d;
      Float nx = ex * inverse, ny = ey * inverse, nz = ez * inverse;
      const Mask coincident = touch & (d2 < broadcast(1e-24f));
      if (any(coincident)) part_coincident(i, row + s, coincident, &nx, &ny, &nz);
      Float overlap = d - diameter;  // negative
      Float along = zero;
      if (k_solve) {
        // The speed at which an overlap drives a pair apart is limited; the rest of the overlap goes in later
        // sub-steps.
        along = dot3(rx, ry, rz, nx, ny, nz);
        overlap =
            maximum(overlap, broadcast(a->inverse_relaxation) * minimum(along - broadcast(a->separation_max), zero));
      }
      // Share of the correction: all of it against what does not move or is asleep, else by inverse mass.
      Float mine = select(free, half, one);
      Float lift = zero;
      if (k_weighted) lift = height_share(a, nx, ny, nz);
      if (a->bodies != 0 && any(touch & free & ((w < other[k_mobility]) | (other[k_mobility] < w)))) {
        const Mask unequal = moves & free & ((w < other[k_mobility]) | (other[k_mobility] < w));
        const Float heavy = w * (half + lift), light = other[k_mobility] * (half - lift);
        const Float share = w / select(unequal, w + other[k_mobility], one);
        mine = select(unequal, share, mine);
        if (k_weighted) lift = select(unequal, heavy / select(unequal, heavy + light, one) - share, lift);
      }
      if (k_weighted) {
        const Float weighted = overlap * keep(free & touch, lift);
        lx = lx + weighted * nx, ly = ly + weighted * ny, lz = lz + weighted * nz;
      }
      const Float push = mine * overlap;
      Float cx = push * nx, cy = push * ny, cz = push * nz;
      if (k_solve) {
        const Float tx = mine * (rx - along * nx), ty = mine * (ry - along * ny), tz = mine * (rz - along * nz);
        const Float t2 = dot3(tx, ty, tz, tx, ty, tz);
        const Float normal = mine * overlap;
        // Sticks while |t| <= mu_s |normal|; else slides with mu_k |normal| / |t|, at most 1 (4.24-4.27).
        const Mask slides = static2 * (normal * normal) < t2;
        Float grip = one;
        if (any(slides & touch))
          grip = select(slides, minimum((kinetic * absolute(normal)) / square_root(maximum(t2, tiny)), one), one);
        cx = cx + grip * tx, cy = cy + grip * ty, cz = cz + grip * tz;
      }
      sx = sx + keep(touch, cx), sy = sy + keep(touch, cy), sz = sz + keep(touch, cz);
      contacts = contacts + keep(touch, one);
      wakes = wakes | (touch & (other[k_mobility] < zero));
    }

    Float factor = omega;
    if (a->averaged != 0) {
      factor = minimum(omega / maximum(contacts, one), one);
    } else {
      // At most twelve equal spheres touch one. More contacts come from coincident particles, whose corrections must
      // not add up.
      const Float crowd = minimum(broadcast(12.0f) / maximum(contacts, one), one);
      const Float crowd2 = crowd * crowd;
      factor = omega * (crowd2 * crowd2);
    }
    sx = factor * sx, sy = factor * sy, sz = factor * sz;
    if (k_weighted) {
      lx = factor * lx, ly = factor * ly, lz = factor * lz;
      const Float rise = dot3(lx, ly, lz, broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2]));
      const Float lift_max = broadcast(a->lift_max);
      const Float part = select(lift_max < rise, lift_max / maximum(rise, tiny), one);
      sx = sx + part * lx, sy = sy + part * ly, sz = sz + part * lz;
    }
    Float x = self[k_x], y = self[k_y], z = self[k_z];
    if (k_solve) {
      dx = dx + sx, dy = dy + sy, dz = dz + sz;
    } else {
      x = x + sx, y = y + sy, z = z + sz;
    }

    for (uint32_t c = 0; c < a->collider_count; ++c) {
      const ColliderFrame& collider = a->colliders[c];
      const Float px = x + dx, py = y + dy, pz = z + dz;
      const Surface surface = collider_surface(collider, px, py, pz);
      const Float depth = broadcast(a->radius) - surface.distance;
      const Mask hit = zero < depth;
      if (!any(hit)) continue;
      Float cx = depth * surface.nx, cy = depth * surface.ny, cz = depth * surface.nz;
      if (k_solve) {
        Float v[3];
        collider_velocity(collider, px, py, pz, v);
        const Float step = broadcast(a->step);
        // The collider's displacement minus the particle's, without its normal part. The particle makes up all of it.
        const Float rx = step * v[0] - dx, ry = step * v[1] - dy, rz = step * v[2] - dz;
        const Float along = dot3(rx, ry, rz, surface.nx, surface.ny, surface.nz);
        const Float tx = rx - along * surface.nx, ty = ry - along * surface.ny, tz = rz - along * surface.nz;
        const Float t2 = dot3(tx, ty, tz, tx, ty, tz);
        const Mask slides = static2 * (depth * depth) < t2;
        Float grip = one;
        if (any(slides & hit))
          grip = select(slides, minimum((kinetic * depth) / square_root(maximum(t2, tiny)), one), one);
        cx = cx + grip * tx, cy = cy + grip * ty, cz = cz + grip * tz;
        dx = dx + keep(hit, cx), dy = dy + keep(hit, cy), dz = dz + keep(hit, cz);
      } else {
        x = x + keep(hit, cx), y = y + keep(hit, cy), z = z + keep(hit, cz);
      }
    }

    Float out[k_record_floats];
    out[k_mobility] = w;
    out[k_identity] = self[k_identity];
    if (!k_solve) {
      // Stabilisation moves the start positions only. A move beyond the CFL limit is left out.
      const Float mx = x - self[k_x], my = y - self[k_y], mz = z - self[k_z];
      const Float m2 = dot3(mx, my, mz, mx, my, mz);
      const Float limit = broadcast(a->displacement_max);
      const Mask calm = (m2 <= limit * limit) & moves;
      out[k_x] = select(calm, x, self[k_x]), out[k_y] = select(calm, y, self[k_y]),
      out[k_z] = select(calm, z, self[k_z]);
      out[k_vx] = self[k_vx], out[k_vy] = self[k_vy], out[k_vz] = self[k_vz];
      store_records(floats_of(a->out + i), out);
      continue;
    }

    const Mask inside =
        lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->particle_count));
    const Mask live = inside & moves;
    Float move2 = dot3(dx, dy, dz, dx, dy, dz);
    const Mask sound = move2 < broadcast(1e12f);  // false for NaN and Inf: such a particle stays where it is
    dx = keep(sound, dx), dy = keep(sound, dy), dz = keep(sound, dz);
    move2 = keep(sound, move2);
    if (a->last != 0) {
      const Float limit = broadcast(a->displacement_max);
      const Mask fast = limit * limit < move2;
      if (any(fast)) {
        const Float slow = select(fast, limit / square_root(maximum(move2, tiny)), one);
        dx = dx * slow, dy = dy * slow, dz = dz * slow;
        move2 = select(fast, limit * limit, move2);
      }
      const Float step = broadcast(a->step);
      out[k_x] = select(live, x + dx, self[k_x]), out[k_y] = select(live, y + dy, self[k_y]),
      out[k_z] = select(live, z + dz, self[k_z]);
      // A division: multiplying by 1/dt would err by the same sign in every sub-step.
      out[k_vx] = keep(live, dx / step), out[k_vy] = keep(live, dy / step), out[k_vz] = keep(live, dz / step);
      // Out of bounds, or not a number: back to where it was, with velocity 0. A coordinate that was no better becomes
      // 0.
      const Float bound = broadcast(k_coordinate_bound);
      const Mask legal = (absolute(out[k_x]) < bound) & (absolute(out[k_y]) < bound) & (absolute(out[k_z]) < bound);
      const Mask bad = and_not(live, sound & legal);
      if (any(bad)) {
        quarantined += count(bad);
        for (int k = 0; k < 3; ++k) {
          const Mask number = absolute(self[k]) < bound;
          out[k] = select(bad, keep(number, self[k]), out[k]);
          out[k_vx + k] = select(bad, zero, out[k_vx + k]);
        }
      }
      if (any(wakes & live & (broadcast(a->wake_displacement * a->wake_displacement) < move2))) {
        a->touched[i / k_lane_group] = 1;
        extent->touched = 1;
      }
      speed2 = maximum(keep(live, move2 / (step * step)), speed2);
      const Float position[3] = {out[k_x], out[k_y], out[k_z]}, move[3] = {dx, dy, dz};
      for (int k = 0; k < 3; ++k) {
        low[k] = select(live, minimum(position[k], low[k]), low[k]),
        high[k] = select(live, maximum(position[k], high[k]), high[k]);
        move_low[k] = select(live, minimum(move[k], move_low[k]), move_low[k]);
        move_high[k] = select(live, maximum(move[k], move_high[k]), move_high[k]);
      }
    } else {
      out[k_x] = self[k_x], out[k_y] = self[k_y], out[k_z] = self[k_z];
      out[k_vx] = keep(live, dx), out[k_vy] = keep(live, dy), out[k_vz] = keep(live, dz);
    }
    store_records(floats_of(a->out + i), out);
  }

  if (k_solve && a->last != 0) {
    extent->speed_squared = lane_maximum(speed2);
    for (int k = 0; k < 3; ++k) {
      extent->low[k] = lane_minimum(low[k]), extent->high[k] = lane_maximum(high[k]);
      extent->displacement_low[k] = lane_minimum(move_low[k]),
      extent->displacement_high[k] = lane_maximum(move_high[k]);
    }
    extent->quarantined = quarantined;
  }
}

static void contact_stabilise(const ContactArgs* args, uint32_t begin, uint32_t end, ContactExtent* extent) {
  if (args->weight_linear != 0.0f) contact_pass<false, true>(args, begin, end, extent);
  else contact_pass<false, false>(args, begin, end, extent);
}

static void contact_solve(const ContactArgs* args, uint32_t begin, uint32_t end, ContactExtent* extent) {
  if (args->weight_linear != 0.0f) contact_pass<true, true>(args, begin, end, extent);
  else contact_pass<true, false>(args, begin, end, extent);
}

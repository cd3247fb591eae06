// What depends on the distance to a shape: particles and grains that sleep near a moving collider wake up, before the
// sub-step in which it would run into them (wake_near); which points lie inside any of several shapes (find_inside);
// distance and normal of one collider (surface_at).

static void wake_near(const WakeArgs* a, uint32_t begin, uint32_t end, uint32_t* woken) {
  const Float zero = broadcast(0.0f);
  *woken = 0;
  for (uint32_t i = begin; i < end; i += k_width) {
    float* sleeper = floats_of(a->sleepers + i);
    Float r[k_record_floats];
    load_records(sleeper, r);
    const Mask asleep = (r[k_mobility] < zero) & (lane_index() + broadcast(static_cast<int32_t>(i)) <
                                                  broadcast(static_cast<int32_t>(a->sleeper_count)));
    if (!any(asleep)) continue;
    Mask near = zero < zero;
    for (uint32_t c = 0; c < a->collider_count; ++c) {
      const Float reach = broadcast(a->margins[c]) + r[k_radius];
      near = near | (collider_surface(a->colliders[c], r[k_x], r[k_y], r[k_z]).distance < reach);
    }
    near = near & asleep;
    if (!any(near)) continue;
    *woken += count(near);
    r[k_mobility] = select(near, zero - r[k_mobility], r[k_mobility]);
    store_records(sleeper, r);
  }
}

static void find_inside(const InsideArgs* a, uint32_t begin, uint32_t end, uint32_t* found) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  *found = 0;
  for (uint32_t i = begin; i < end; i += k_width) {
    Float r[k_record_floats];
    load_records(floats_of(a->records + i), r);
    Mask inside = zero < zero;
    for (uint32_t c = 0; c < a->shape_count; ++c)
      inside = inside | (collider_surface(a->shapes[c], r[k_x], r[k_y], r[k_z]).distance < zero);
    inside =
        inside & (lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->record_count)));
    *found += count(inside);
    alignas(64) float flags[k_lane_group];
    store(flags, keep(inside, one));
    for (uint32_t l = 0; l < k_width; ++l) a->inside[i - begin + l] = flags[l] != 0.0f ? 1 : 0;
  }
}

static void surface_at(const SurfaceArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  for (uint32_t i = begin; i < end; i += k_width) {
    float* point = floats_of(a->points + i);
    Float r[k_record_floats];
    load_records(point, r);
    const Surface surface = collider_surface(*a->collider, r[k_x], r[k_y], r[k_z]);
    r[k_distance] = surface.distance;
    r[k_normal] = surface.nx;
    r[k_normal + 1] = surface.ny;
    r[k_normal + 2] = surface.nz;
    store_records(point, r);
  }
}

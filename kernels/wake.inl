// What depends on the distance to a shape: particles and grains that sleep near a moving collider wake up, before the
// sub-step in which it would run into them (wake_near); which points lie inside any of several shapes (find_inside);
// distance and normal of one collider (surface_at).

static void wake_near(const WakeArgs* a, uint32_t begin, uint32_t end, uint32_t* woken) {
  const Float zero = broadcast(0.0f);
  *woken = 0;
  for (uint32_t i = begin; i < end; i += k_width) {
    float* record = a->records + static_cast<uint64_t>(i) * k_record_floats;
    Float r[8];
    load_records(record, r);
    const Mask asleep = (r[3] < zero) & (lane_index() + broadcast(static_cast<int32_t>(i)) <
                                         broadcast(static_cast<int32_t>(a->record_count)));
    if (!any(asleep)) continue;
    Mask near = zero < zero;
    for (uint32_t c = 0; c < a->collider_count; ++c)
      near = near | (collider_surface(a->colliders[c], r[0], r[1], r[2]).distance < broadcast(a->margins[c]) + r[4]);
    near = near & asleep;
    if (!any(near)) continue;
    *woken += count(near);
    r[3] = select(near, zero - r[3], r[3]);
    store_records(record, r);
  }
}

static void find_inside(const InsideArgs* a, uint32_t begin, uint32_t end, uint32_t* found) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  *found = 0;
  for (uint32_t i = begin; i < end; i += k_width) {
    Float r[8];
    load_records(a->records + static_cast<uint64_t>(i) * k_record_floats, r);
    Mask inside = zero < zero;
    for (uint32_t c = 0; c < a->shape_count; ++c)
      inside = inside | (collider_surface(a->shapes[c], r[0], r[1], r[2]).distance < zero);
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
    float* record = a->records + static_cast<uint64_t>(i) * k_record_floats;
    Float r[8];
    load_records(record, r);
    const Surface surface = collider_surface(*a->collider, r[0], r[1], r[2]);
    r[3] = surface.distance;
    r[4] = surface.nx, r[5] = surface.ny, r[6] = surface.nz;
    store_records(record, r);
  }
}

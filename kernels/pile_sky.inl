// How much of the light of a room the columns of sand leave to the receivers of one row. The upper hemisphere is cut
// into sectors of azimuth and rings of elevation. Along the middle of each sector the columns hide one interval of
// elevations, as in pile_light.inl, and the interval's share of each ring is taken from the ring's light. Elevations
// are compared as sin^2, in which every ring is a quarter.
//
// A step is the same shift for all texels of the row, so with lane = texel the loads are consecutive. Distant steps
// read wide columns, each of which stands for a square of them.

static void pile_sky(const PileSkyArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), four = broadcast(4.0f);
  const Float steepest = broadcast(1e6f), shortest = broadcast(1e-6f), cap = broadcast(a->cap);
  const Float edges[4] = {zero, one, broadcast(2.0f), broadcast(3.0f)};
  for (uint32_t i = begin; i < end; i += k_width) {
    const int32_t first = static_cast<int32_t>(i), last = first + static_cast<int32_t>(k_width) - 1;
    const Float receiver = load(a->receivers + i);
    Float left = one;
    for (uint32_t k = 0; k < a->sector_count; ++k) {
      const PileSector& sector = a->sectors[k];
      Float high = zero, low = steepest, reached = zero;
      for (uint32_t s = sector.first_step; s < sector.last_step; ++s) {
        const PileSkyStep& step = a->steps[s];
        if (last < step.first || first > step.last) continue;
        const int64_t at = static_cast<int64_t>(step.at) + first;
        const Float inverse = broadcast(step.inverse_distance);
        const Float slope = (load(a->tops + at) - receiver) * inverse;
        high = maximum(slope, high);
        reached = reached + load(a->fills + at) * maximum(minimum(slope, cap) - reached, zero);
        low = minimum((load(a->bottoms + at) - receiver) * inverse, low);
      }
      const Float dark = minimum(reached / maximum(minimum(high, cap), shortest), one);
      high = minimum(high, steepest), low = maximum(low, zero);
      const Float high_square = high * high, low_square = low * low;
      const Float to = four * (high_square / (one + high_square));
      const Float from = minimum(four * (low_square / (one + low_square)), to);
      Float hidden = zero;
      for (uint32_t ring = 0; ring < 4; ++ring) {
        const Float above = minimum(maximum(to - edges[ring], zero), one);
        const Float below = minimum(maximum(from - edges[ring], zero), one);
        hidden = hidden + broadcast(sector.shares[ring]) * (above - below);
      }
      left = left - hidden * dark;
    }
    store(a->lights + i, maximum(left, zero));
  }
}

// How much of the light of a room the columns of sand leave to the receivers of one row. The upper hemisphere is cut
// into sectors of azimuth and rings of elevation. Along the middle of each sector the columns hide one interval of
// elevations, as in pile_light.inl, and the interval's share of each ring is taken from the ring's light. Elevations
// are compared as sin^2, in which every ring is a quarter.
//
// A step is the same shift for all texels of the row, so with lane = texel the loads are consecutive. Distant steps
// read wide columns, each of which stands for a square of them. Several vectors are walked together, because what is
// the same for all texels of a step costs as much as the texels do.

constexpr uint32_t k_sky_vectors = k_width < 4 ? 1 : k_lane_group / k_width;

// The interval that a sector hides from each receiver, as slopes, and how far up it is dark.
struct HiddenSlopes {
  Float low[k_sky_vectors], high[k_sky_vectors], reached[k_sky_vectors];
};

// The light of a sector below a slope of at least 0. A ring's light is even in sin^2, so the sum is a line that bends
// where rings meet.
static SANDGLASS_INLINE Float light_below(const PileSector& sector, Float slope) {
  const Float square = slope * slope, rings = broadcast(4.0f) * (square / (broadcast(1.0f) + square));
  Float light = broadcast(sector.bends[0]) * rings;
  for (uint32_t ring = 1; ring < 4; ++ring)
    light =
        light + broadcast(sector.bends[ring]) * maximum(rings - broadcast(static_cast<float>(ring)), broadcast(0.0f));
  return light;
}

static void pile_sky(const PileSkyArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  constexpr uint32_t k_texels = k_sky_vectors * k_width;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const Float steepest = broadcast(1e6f), shortest = broadcast(1e-6f), cap = broadcast(a->cap);
  for (uint32_t i = begin; i < end; i += k_texels) {
    const int32_t first = static_cast<int32_t>(i), last = first + static_cast<int32_t>(k_texels) - 1;
    Float receiver[k_sky_vectors], left[k_sky_vectors];
    for (uint32_t v = 0; v < k_sky_vectors; ++v) {
      receiver[v] = load(a->receivers + i + v * k_width);
      left[v] = one;
    }
    for (uint32_t k = 0; k < a->sector_count; ++k) {
      const PileSector& sector = a->sectors[k];
      HiddenSlopes hides;
      for (uint32_t v = 0; v < k_sky_vectors; ++v) {
        hides.low[v] = steepest;
        hides.high[v] = hides.reached[v] = zero;
      }
      bool met = false;
      for (uint32_t s = sector.first_step; s < sector.last_step; ++s) {
        const PileSkyStep& step = a->steps[s];
        if (last < step.first || first > step.last) continue;
        met = true;
        const int64_t at = static_cast<int64_t>(step.at) + first;
        const Float inverse = broadcast(step.inverse_distance);
        for (uint32_t v = 0; v < k_sky_vectors; ++v) {
          const int64_t here = at + v * k_width;
          const Float slope = (load(a->tops + here) - receiver[v]) * inverse, reached = hides.reached[v];
          hides.high[v] = maximum(slope, hides.high[v]);
          hides.reached[v] = reached + load(a->fills + here) * maximum(minimum(slope, cap) - reached, zero);
        }
        if (sector.in_air == 0) continue;
        for (uint32_t v = 0; v < k_sky_vectors; ++v)
          hides.low[v] = minimum((load(a->bottoms + at + v * k_width) - receiver[v]) * inverse, hides.low[v]);
      }
      if (!met) continue;
      for (uint32_t v = 0; v < k_sky_vectors; ++v) {
        const Float high = hides.high[v], dark = hides.reached[v] / maximum(minimum(high, cap), shortest);
        Float hidden = light_below(sector, high);
        if (sector.in_air != 0) hidden = hidden - light_below(sector, minimum(maximum(hides.low[v], zero), high));
        left[v] = left[v] - hidden * dark;
      }
    }
    for (uint32_t v = 0; v < k_sky_vectors; ++v) store(a->lights + i + v * k_width, maximum(left[v], zero));
  }
}

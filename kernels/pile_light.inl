// How much of a soft light columns of sand leave to the receivers of one row: for each azimuth the interval of
// elevations that the columns along it hide, against the light's own. A step along an azimuth is the same shift for all
// texels, so that lane = texel reads consecutive columns. Elevations are compared as sin^2, which is what their cosine-
// weighted share of the light is linear in: s = t^2 / (1 + t^2) of the slope t.
static void pile_light(const PileLightArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), steepest = broadcast(1e6f);
  const Float inverse_total = broadcast(a->inverse_total);
  for (uint32_t i = begin; i < end; i += k_width) {
    const Float receiver = load(a->receivers + i);
    Float sum = zero;
    for (uint32_t k = 0; k < a->azimuth_count; ++k) {
      const PileAzimuth& azimuth = a->azimuths[k];
      Float high = zero, low = steepest;
      for (uint32_t s = azimuth.first_step; s < azimuth.last_step; ++s) {
        const PileStep& step = a->steps[s];
        const int32_t row = a->row + step.rows, column = static_cast<int32_t>(i) + step.columns;
        if (row < a->sand_rows[0] || row > a->sand_rows[1] || column > a->sand_columns[1] ||
            column + static_cast<int32_t>(k_width) <= a->sand_columns[0])
          continue;
        const int64_t at = static_cast<int64_t>(row) * a->pitch + column;
        const Float inverse = broadcast(step.inverse_distance);
        high = maximum((load(a->tops + at) - receiver) * inverse, high);
        low = minimum((load(a->bottoms + at) - receiver) * inverse, low);
      }
      high = minimum(high, steepest), low = maximum(low, zero);
      const Float high_square = high * high, low_square = low * low;
      const Float from = maximum(low_square / (one + low_square), broadcast(azimuth.low));
      const Float to = minimum(high_square / (one + high_square), broadcast(azimuth.high));
      const Float hidden = maximum(to - from, zero);
      sum = sum + broadcast(azimuth.weight) * (broadcast(azimuth.high - azimuth.low) - hidden);
    }
    store(a->shares + i, minimum(sum * inverse_total, one));
  }
}

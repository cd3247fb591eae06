// How much of a soft light the columns of sand leave to the receivers of one row. For each azimuth, the elevations that
// the columns along it hide form one interval, which is compared with the interval of the light. A step along an
// azimuth is the same shift for all texels, so with lane = texel the loads are consecutive. Elevations are compared as
// sin^2, because the cosine-weighted share of the light is linear in it: s = t^2 / (1 + t^2) of the slope t.
//
// Sand that does not fill its texel lets light through. `reached` begins at the light's lower edge. Each column moves
// it towards the column's top by the share of the texel that the column fills. Full columns therefore make it the
// highest top; n columns that cover the whole light and fill f of their texels leave (1 - f)^n of the interval between.
// The share of it that is reached is the share of the hidden interval that is dark. The walk is from far to near: for
// columns of one height, whose slopes then rise, the result is exactly the mean over the elevations below each top.
//
// On the floor the receiver's own column is no step but a factor (PileAzimuth::own). Its sand is nearer than any
// distance that could stand for it.

// What the receiver's own column leaves of an azimuth.
struct OwnColumn {
  Float fourth_root, root, open, square, bottom;  // of the share that is open
};
static SANDGLASS_INLINE OwnColumn own_column(const PileLightArgs* a, uint32_t texel) {
  const int64_t at = static_cast<int64_t>(a->row) * a->pitch + texel;
  const Float open = broadcast(1.0f) - load(a->fills + at), root = square_root(open);
  return {square_root(root), root, open, open * open, load(a->bottoms + at) - load(a->receivers + texel)};
}
static SANDGLASS_INLINE Float left_by(const OwnColumn& own, const PileAzimuth& azimuth) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const Float change = broadcast(azimuth.own[0]) + broadcast(azimuth.own[1]) * own.fourth_root +
                       broadcast(azimuth.own[2]) * own.root + broadcast(azimuth.own[3]) * own.open +
                       broadcast(azimuth.own[4]) * own.square;
  const Float near = broadcast(azimuth.near_from) - own.bottom * broadcast(azimuth.near_per_metre);
  return maximum(minimum(one + minimum(maximum(near, zero), one) * change, one), zero);
}

static void pile_light(const PileLightArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), steepest = broadcast(1e6f), shortest = broadcast(1e-6f);
  const Float inverse_total = broadcast(a->inverse_total);
  for (uint32_t i = begin; i < end; i += k_width) {
    const Float receiver = load(a->receivers + i);
    const OwnColumn own = own_column(a, i);
    Float sum = zero;
    for (uint32_t k = 0; k < a->azimuth_count; ++k) {
      const PileAzimuth& azimuth = a->azimuths[k];
      Float high = zero, low = steepest, reached = broadcast(azimuth.foot);
      const Float cap = broadcast(azimuth.cap);
      const uint32_t thin = a->on_floor & azimuth.thin, nearest = azimuth.first_step + thin;
      for (uint32_t s = azimuth.last_step; s-- > nearest;) {
        const PileStep& step = a->steps[s];
        const int32_t row = a->row + step.rows, column = static_cast<int32_t>(i) + step.columns;
        if (row < a->sand_rows[0] || row > a->sand_rows[1] || column > a->sand_columns[1] ||
            column + static_cast<int32_t>(k_width) <= a->sand_columns[0])
          continue;
        const int64_t at = static_cast<int64_t>(row) * a->pitch + column;
        const Float inverse = broadcast(step.inverse_distance);
        const Float slope = (load(a->tops + at) - receiver) * inverse;
        high = maximum(slope, high);
        reached = reached + load(a->fills + at) * maximum(minimum(slope, cap) - reached, zero);
        low = minimum((load(a->bottoms + at) - receiver) * inverse, low);
      }
      const Float foot = broadcast(azimuth.foot), hides = maximum(minimum(high, cap) - foot, shortest);
      const Float dark = minimum((reached - foot) / hides, one);
      high = minimum(high, steepest);
      low = maximum(low, zero);
      const Float high_square = high * high, low_square = low * low;
      const Float from = maximum(low_square / (one + low_square), broadcast(azimuth.low));
      const Float to = minimum(high_square / (one + high_square), broadcast(azimuth.high));
      const Float hidden = maximum(to - from, zero) * dark;
      const Float open = broadcast(azimuth.high - azimuth.low) - hidden;
      sum = sum + broadcast(azimuth.weight) * (thin != 0 ? open * left_by(own, azimuth) : open);
    }
    store(a->shares + i, minimum(sum * inverse_total, one));
  }
}

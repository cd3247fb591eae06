// The shadow that triangles throw onto a plane, as an image of one bit a texel, and the filter that makes of the count of
// such images a soft shadow without bands.
//
// Lane = triangle while triangles are projected, then lane = edge of one triangle. A row's span ends where three edges cut
// it: of a triangle that turns against the clock (u to the right, v down) edges that go down bound it on the left, edges
// that go up on the right. Beside the three stands the triangle's own extent, so that the bounds of a row are the greatest
// and the smallest of four.

// Where four bounds are in a triangle's first row, and how far each moves from row to row. What bounds nothing lies beyond
// the image.
struct alignas(32) CastBounds {
  float at[4], step[4];
};

// Both ends of a span of bits are in it.
static SANDGLASS_INLINE void fill_span(uint64_t* row, uint32_t from, uint32_t to) {
  const uint64_t first = ~uint64_t{0} << (from & 63), last = ~uint64_t{0} >> (63 - (to & 63));
  uint32_t word = from >> 6;
  const uint32_t end = to >> 6;
  if (word == end) {
    row[word] |= first & last;
    return;
  }
  row[word] |= first;
  for (++word; word < end; ++word) row[word] |= ~uint64_t{0};
  row[end] |= last;
}

// The bounds of row j: the same bits however many lanes there are, because maximum and minimum are exact.
static SANDGLASS_INLINE float left_bound(const CastBounds& b, float j) {
  if constexpr (k_width == 4) return lane_maximum(load(b.at) + load(b.step) * broadcast(j));
  float largest = b.at[3];
  for (uint32_t e = 0; e < 3; ++e) {
    const float x = b.at[e] + b.step[e] * j;
    largest = x > largest ? x : largest;
  }
  return largest;
}
static SANDGLASS_INLINE float right_bound(const CastBounds& b, float j) {
  if constexpr (k_width == 4) return lane_minimum(load(b.at) + load(b.step) * broadcast(j));
  float smallest = b.at[3];
  for (uint32_t e = 0; e < 3; ++e) {
    const float x = b.at[e] + b.step[e] * j;
    smallest = x < smallest ? x : smallest;
  }
  return smallest;
}

// Returns how many texels it covers.
static SANDGLASS_INLINE uint32_t fill_rows(const CastBounds& left, const CastBounds& right, uint32_t rows,
                                           uint64_t* row, uint32_t words) {
  uint32_t texels = 0;
  float j = 0;
  for (uint32_t i = 0; i < rows; ++i, j += 1.0f, row += words) {
    const float l = left_bound(left, j), r = right_bound(right, j);
    if (!(l <= r)) continue;  // from here on both lie in the image
    const uint32_t whole = to_whole<uint32_t>(l), from = whole + (static_cast<float>(whole) < l ? 1 : 0);
    const uint32_t to = to_whole<uint32_t>(r);
    if (from > to) continue;
    texels += to - from + 1;
    fill_span(row, from, to);
  }
  return texels;
}

// Where the edges of triangles cut the middles of row `first`, as the left and the right of CastBounds.
static SANDGLASS_INLINE void edge_bounds(const Float u[3], const Float v[3], Float first, Float side, Float left[8],
                                         Float right[8]) {
  const Float zero = broadcast(0.0f), before = broadcast(-1.0f), steepest = broadcast(1e9f);
  for (uint32_t e = 0; e < 3; ++e) {
    const uint32_t to = e == 2 ? 0 : e + 1;
    const Float rise = v[to] - v[e], divisor = select(rise == zero, broadcast(1.0f), rise);  // a level edge has none
    const Float slope = maximum(minimum((u[to] - u[e]) / divisor, steepest), zero - steepest);
    const Float cut = u[e] + (first - v[e]) * slope;
    const Mask down = v[e] < v[to], up = v[to] < v[e];
    left[e] = select(down, cut, before);
    left[4 + e] = keep(down, slope);
    right[e] = select(up, cut, side);
    right[4 + e] = keep(up, slope);
  }
}

static void cast_triangles(const CastTrianglesArgs* a, uint32_t begin, uint32_t end, CastExtent* extent) {
  const Float zero = broadcast(0.0f), before = broadcast(-1.0f);
  const Float side = broadcast(static_cast<float>(a->texels)), last = broadcast(static_cast<float>(a->texels - 1));
  CastExtent seen = *extent;
  for (uint32_t at = begin; at < end; at += k_width) {
    Float u[3], v[3];
    for (uint32_t c = 0; c < 3; ++c) {
      const Float height = load(a->corners[3 * c + 1] + at);
      u[c] = load(a->corners[3 * c] + at) * broadcast(a->scale[0]) - height * broadcast(a->shear[0]) +
             broadcast(a->offset[0]);
      v[c] = load(a->corners[3 * c + 2] + at) * broadcast(a->scale[1]) - height * broadcast(a->shear[1]) +
             broadcast(a->offset[1]);
    }
    const Float area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    const Mask turned = zero < area;
    Mask kept = a->closed != 0 ? area < zero : (area < zero) | turned;
    if (!any(kept)) continue;
    // The first and the last middle of a texel that each may cover, within the image.
    const Float low_u = minimum(minimum(u[0], u[1]), u[2]), high_u = maximum(maximum(u[0], u[1]), u[2]);
    const Float low_v = minimum(minimum(v[0], v[1]), v[2]), high_v = maximum(maximum(v[0], v[1]), v[2]);
    const Int row = broadcast(0) - floor_int(zero - minimum(maximum(low_v, zero), side));
    const Int column = broadcast(0) - floor_int(zero - minimum(maximum(low_u, zero), side));
    const Int last_row = floor_int(maximum(minimum(high_v, last), before));
    const Int last_column = floor_int(maximum(minimum(high_u, last), before));
    kept = kept & (row < last_row + broadcast(1)) & (column < last_column + broadcast(1));
    if (!any(kept)) continue;
    if (a->closed == 0) {
      const Float u1 = u[1], v1 = v[1];
      u[1] = select(turned, u[2], u1);
      v[1] = select(turned, v[2], v1);
      u[2] = select(turned, u1, u[2]);
      v[2] = select(turned, v1, v[2]);
    }
    Float left[8], right[8];
    edge_bounds(u, v, to_float(row), side, left, right);
    left[3] = to_float(column);
    right[3] = to_float(last_column);
    left[7] = right[7] = zero;
    CastBounds of_left[k_width], of_right[k_width];
    store_records(of_left[0].at, left);
    store_records(of_right[0].at, right);
    uint32_t rows[k_width], last_rows[k_width], lanes[2 * k_width];
    store(rows, row);
    store(last_rows, last_row);
    const uint32_t count = compress_store(lanes, lane_index(), kept);
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t lane = lanes[i], from = rows[lane], to = last_rows[lane];
      seen.texels += fill_rows(of_left[lane], of_right[lane], to - from + 1, a->image + from * a->words, a->words);
      seen.rows += to - from + 1;
      seen.first_row = from < seen.first_row ? from : seen.first_row;
      seen.last_row = to > seen.last_row ? to : seen.last_row;
    }
  }
  *extent = seen;
}

// Along a row: the smallest, the largest and the sum of 2 radius + 1 values about each texel.
static void cast_window(const CastWindowArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  for (uint32_t at = begin; at < end; at += k_width) {
    const float* from = a->row + at - a->radius;
    Float low = load(from), high = low, sum = low;
    for (uint32_t k = 1; k <= 2 * a->radius; ++k) {
      const Float x = load(from + k);
      low = minimum(low, x);
      high = maximum(high, x);
      sum = sum + x;
    }
    store(a->low + at, low);
    store(a->high + at, high);
    store(a->sum + at, sum);
  }
}

// Across rows: where all values of the window differ by at most half of difference_max, a texel becomes their mean;
// where they differ by difference_max or more, it stays; in between it is blended.
static void cast_calm(const CastCalmArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const float area = static_cast<float>(a->rows * a->rows);
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), two = broadcast(2.0f);
  const Float inverse_area = broadcast(1.0f / area), slope = broadcast(2.0f / a->difference_max);
  for (uint32_t at = begin; at < end; at += k_width) {
    Float low = load(a->low[0] + at), high = load(a->high[0] + at), sum = load(a->sum[0] + at);
    for (uint32_t k = 1; k < a->rows; ++k) {
      low = minimum(low, load(a->low[k] + at));
      high = maximum(high, load(a->high[k] + at));
      sum = sum + load(a->sum[k] + at);
    }
    const Float share = minimum(maximum(two - (high - low) * slope, zero), one), x = load(a->row + at);
    store(a->row + at, x + share * (sum * inverse_area - x));
  }
}

// The shadow that triangles throw onto a plane, as an image of one bit a texel, and the filter that makes of the count of
// such images a soft shadow without bands.
//
// Lane = triangle while triangles are projected, then lane = row of one triangle. A row's span ends where three edges
// cut it: of a triangle that turns against the clock (u to the right, v down) edges that go down bound it on the left,
// edges that go up on the right.

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
  while (++word < end) row[word] = ~uint64_t{0};
  row[end] |= last;
}

// For each of three edges: where it is in the first row, and how far it moves from row to row. What bounds nothing lies
// at the rim of the image.
struct CastEdges {
  float left[3][k_width], left_step[3][k_width], right[3][k_width], right_step[3][k_width];
  float first[k_width], column[k_width], last_column[k_width];
  uint32_t row[k_width], last_row[k_width];
};

static void fill_rows(const CastTrianglesArgs* a, const CastEdges& edges, uint32_t lane, CastExtent* extent) {
  const uint32_t rows = edges.last_row[lane] - edges.row[lane] + 1;
  const Float side = broadcast(static_cast<float>(a->texels)), before = broadcast(-1.0f), zero = broadcast(0.0f);
  uint64_t* row = a->image + static_cast<uint64_t>(edges.row[lane]) * a->words;
  for (uint32_t begin = 0; begin < rows; begin += k_width) {
    const Float j = to_float(lane_index() + broadcast(static_cast<int32_t>(begin)));
    Float left = broadcast(edges.column[lane]), right = broadcast(edges.last_column[lane]);
    for (uint32_t e = 0; e < 3; ++e) {
      left = maximum(broadcast(edges.left[e][lane]) + j * broadcast(edges.left_step[e][lane]), left);
      right = minimum(broadcast(edges.right[e][lane]) + j * broadcast(edges.right_step[e][lane]), right);
    }
    uint32_t from[k_width], to[k_width];
    store(from, broadcast(0) - floor_int(zero - minimum(left, side)));
    store(to, floor_int(maximum(right, before)));
    const uint32_t count = rows - begin < k_width ? rows - begin : k_width;
    for (uint32_t i = 0; i < count; ++i, row += a->words) {
      if (static_cast<int32_t>(from[i]) > static_cast<int32_t>(to[i])) continue;
      extent->texels += to[i] - from[i] + 1;
      fill_span(row, from[i], to[i]);
    }
  }
  extent->rows += rows;
  if (edges.row[lane] < extent->first_row) extent->first_row = edges.row[lane];
  if (edges.last_row[lane] > extent->last_row) extent->last_row = edges.last_row[lane];
}

static void cast_triangles(const CastTrianglesArgs* a, uint32_t begin, uint32_t end, CastExtent* extent) {
  const Float zero = broadcast(0.0f), before = broadcast(-1.0f);
  const Float side = broadcast(static_cast<float>(a->texels)), last = broadcast(static_cast<float>(a->texels - 1));
  for (uint32_t at = begin; at < end; at += k_width) {
    Float u[3], v[3];
    for (uint32_t c = 0; c < 3; ++c) {
      const Float height = load(a->corners[3 * c + 1] + at);
      u[c] = load(a->corners[3 * c] + at) * broadcast(a->scale[0]) - height * broadcast(a->shear[0]) + broadcast(a->offset[0]);
      v[c] = load(a->corners[3 * c + 2] + at) * broadcast(a->scale[1]) - height * broadcast(a->shear[1]) + broadcast(a->offset[1]);
    }
    // The first and the last middle of a texel that each may cover, within the image.
    const Float low_u = minimum(minimum(u[0], u[1]), u[2]), high_u = maximum(maximum(u[0], u[1]), u[2]);
    const Float low_v = minimum(minimum(v[0], v[1]), v[2]), high_v = maximum(maximum(v[0], v[1]), v[2]);
    const Int row = broadcast(0) - floor_int(zero - minimum(maximum(low_v, zero), side));
    const Int column = broadcast(0) - floor_int(zero - minimum(maximum(low_u, zero), side));
    const Int last_row = floor_int(maximum(minimum(high_v, last), before));
    const Int last_column = floor_int(maximum(minimum(high_u, last), before));
    const Float area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    const Mask turned = zero < area;
    Mask kept = (row < last_row + broadcast(1)) & (column < last_column + broadcast(1));
    kept = kept & (a->closed != 0 ? area < zero : (area < zero) | turned);
    if (!any(kept)) continue;
    if (a->closed == 0) {
      const Float u1 = u[1], v1 = v[1];
      u[1] = select(turned, u[2], u1);
      v[1] = select(turned, v[2], v1);
      u[2] = select(turned, u1, u[2]);
      v[2] = select(turned, v1, v[2]);
    }
    CastEdges edges;
    const Float first = to_float(row);
    for (uint32_t e = 0; e < 3; ++e) {
      const uint32_t to = e == 2 ? 0 : e + 1;
      const Float slope = (u[to] - u[e]) / (v[to] - v[e]), cut = u[e] + (first - v[e]) * slope;
      const Mask down = v[e] < v[to], up = v[to] < v[e];
      store(edges.left[e], select(down, cut, before));
      store(edges.left_step[e], keep(down, slope));
      store(edges.right[e], select(up, cut, side));
      store(edges.right_step[e], keep(up, slope));
    }
    store(edges.column, to_float(column));
    store(edges.last_column, to_float(last_column));
    store(edges.row, row);
    store(edges.last_row, last_row);
    uint32_t lanes[2 * k_width];
    const uint32_t count = compress_store(lanes, lane_index(), kept);
    for (uint32_t i = 0; i < count; ++i) fill_rows(a, edges, lanes[i], extent);
  }
}

// Along a row: the least, the greatest and the sum of 2 radius + 1 values about each texel.
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

// Across rows: where all values of the window differ by at most half of `most`, a texel becomes their mean; where they
// differ by `most` or more, it stays; in between it is blended.
static void cast_calm(const CastCalmArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const float area = static_cast<float>(a->rows * a->rows);
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), two = broadcast(2.0f);
  const Float inverse_area = broadcast(1.0f / area), slope = broadcast(2.0f / a->most);
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

// The operators of the lighting network, one row of output at a time. A 1x1 convolution clamps its inputs (a transition
// also averages them) into a few kilobytes on the stack and computes all channels from there. A 3x3 convolution reads
// its pixels where they lie. Pixels are processed in tiles of k_row_texels. The last tile of a row may read beyond the
// row; it writes nothing there.

// Bytes of that buffer: eight pixels of the widest dense layer, or one tile of the widest transition if that is more.
// Stack is scarce, and the buffer has to stay in the first cache.
constexpr uint32_t k_layer_bytes = 8 * 992, k_tile_bytes = k_row_texels * k_convolution_inputs_limit;
constexpr uint32_t k_packed_bytes = k_tile_bytes > k_layer_bytes ? k_tile_bytes : k_layer_bytes;

// Computes all channels of `count` pixels.
SANDGLASS_INT8_INLINE void convolve(const Int8Convolution& c, const uint8_t* in, const Window& window, uint32_t count,
                                    uint8_t* out, uint32_t out_stride) {
  const uint32_t inputs = window.rows * window.row_bytes;
  for (uint32_t panel = 0; panel < c.outputs; panel += k_channel_group)
    for (uint32_t within = 0; within < k_channel_group; within += k_tile_channels) {
      const uint32_t channel = panel + within;
      const int8_t* weights = c.weights + panel * inputs + within * k_pack_depth;
      for (uint32_t t = 0; t < count; t += k_row_texels)
        dense_tile<k_row_texels>(in + t * window.stride, window, weights, c.bias + channel, c.multiplier + channel,
                                 out + t * out_stride + channel, out_stride, count - t);
    }
}

SANDGLASS_INT8_INLINE uint32_t packed_pixels(uint32_t inputs) {
  return k_packed_bytes / inputs / k_row_texels * k_row_texels;
}

static void narrow(const Int8Convolution* convolution, const PixelRow* row) {
  const Int8Convolution& c = *convolution;
  alignas(64) uint8_t packed[k_packed_bytes];
  const Window window = {c.inputs, 1, c.inputs, 0};
  const uint32_t limit = packed_pixels(c.inputs);
  for (uint32_t first = 0; first < row->count; first += limit) {
    const uint32_t count = row->count - first < limit ? row->count - first : limit;
    for (uint32_t t = 0; t < count; ++t) {
      const uint8_t* in = row->in + (first + t) * row->in_stride;
      uint8_t* out = packed + t * c.inputs;
      for (uint32_t i = 0; i < c.inputs; i += k_bytes)
        store_bytes(out + i, minimum(maximum(load_bytes(in + i), load_bytes(c.low + i)), load_bytes(c.high + i)));
    }
    convolve(c, packed, window, count, row->out + first * row->out_stride, row->out_stride);
  }
}

static void transition(const Int8Convolution* convolution, const PixelRow* row) {
  const Int8Convolution& c = *convolution;
  alignas(64) uint8_t packed[k_packed_bytes];
  const Window window = {c.inputs, 1, c.inputs, 0};
  const uint32_t limit = packed_pixels(c.inputs);
  for (uint32_t first = 0; first < row->count; first += limit) {
    const uint32_t count = row->count - first < limit ? row->count - first : limit;
    for (uint32_t t = 0; t < count; ++t) {
      const uint8_t* in = row->in + 2 * (first + t) * row->in_stride;
      uint8_t* out = packed + t * c.inputs;
      for (uint32_t i = 0; i < c.inputs; i += k_bytes) {
        const Bytes low = load_bytes(c.low + i), high = load_bytes(c.high + i);
        Bytes four[4];
        for (uint32_t k = 0; k < 4; ++k)
          four[k] = minimum(maximum(load_bytes(in + k / 2 * row->in_pitch + k % 2 * row->in_stride + i), low), high);
        store_bytes(out + i, average(four));
      }
    }
    convolve(c, packed, window, count, row->out + first * row->out_stride, row->out_stride);
  }
}

// The three columns of a window are neighbours in memory: three rows of 3 x inputs bytes.
static void wide(const Int8Convolution* convolution, const PixelRow* row) {
  const uint32_t inputs = convolution->inputs;
  convolve(*convolution, row->in, {inputs, 3, 3 * inputs, row->in_pitch}, row->count, row->out, row->out_stride);
}

static void stem(const Int8Convolution* convolution, const uint8_t* rgb, const uint8_t border[3], uint32_t width,
                 uint32_t height, uint32_t y, uint8_t* out) {
  constexpr uint32_t k_pad = k_stem_window / 2, k_window_bytes = 3 * k_stem_window;
  constexpr uint32_t k_row_bytes = 3 * (k_stem_pixels_limit + 2 * k_pad) + 16;
  uint8_t rows[k_stem_window][k_row_bytes];
  const uint32_t padded = width + 2 * k_pad;
  for (uint32_t r = 0; r < k_stem_window; ++r) {
    const uint32_t v = 2 * y + r;  // row of the image, plus k_pad
    const bool inside = v >= k_pad && v < height + k_pad;
    for (uint32_t x = 0; x < (inside ? k_pad : padded); ++x) __builtin_memcpy(rows[r] + 3 * x, border, 3);
    for (uint32_t x = width + k_pad; x < padded; ++x) __builtin_memcpy(rows[r] + 3 * x, border, 3);
    if (inside) __builtin_memcpy(rows[r] + 3 * k_pad, rgb + 3 * (v - k_pad) * width, 3 * width);
    __builtin_memset(rows[r] + 3 * padded, 0, k_row_bytes - 3 * padded);
  }
  alignas(64) uint8_t packed[k_row_texels * k_stem_bytes + 16] = {};
  const Window window = {k_stem_bytes, 1, k_stem_bytes, 0};
  for (uint32_t x = 0; x < width / 2; x += k_row_texels) {
    const uint32_t count = width / 2 - x < k_row_texels ? width / 2 - x : k_row_texels;
    // Copies of 24 bytes, three more than a row of the window has: the next copy overwrites them, and those of the last
    // row meet weights of 0.
    for (uint32_t t = 0; t < count; ++t)
      for (uint32_t r = 0; r < k_stem_window; ++r)
        __builtin_memcpy(packed + t * k_stem_bytes + r * k_window_bytes, rows[r] + 6 * (x + t), 24);
    convolve(*convolution, packed, window, count, out + x * k_stem_outputs, k_stem_outputs);
  }
}

static void pool(const uint8_t* rows, uint32_t width, uint32_t height, uint32_t y, uint8_t* out, uint32_t out_stride) {
  // A row or column beyond the edge is replaced by the middle one, which leaves the maximum as it is.
  const uint32_t pitch = width * k_stem_outputs;
  const uint8_t* row[3];
  for (uint32_t r = 0; r < 3; ++r) {
    const uint32_t v = 2 * y + r;  // row of the image, plus 1
    row[r] = rows + (v == 0 || v > height ? 2 * y : v - 1) * pitch;
  }
  for (uint32_t x = 0; x < width / 2; ++x)
    for (uint32_t i = 0; i < k_stem_outputs; i += k_bytes) {
      Bytes largest = load_bytes(row[0] + 2 * x * k_stem_outputs + i);
      for (uint32_t r = 0; r < 3; ++r)
        for (uint32_t s = 0; s < 3; ++s) {
          const uint32_t u = 2 * x + s;  // column of the image, plus 1
          largest = maximum(largest, load_bytes(row[r] + (u == 0 || u > width ? 2 * x : u - 1) * k_stem_outputs + i));
        }
      store_bytes(out + x * out_stride + i, largest);
    }
}

static int32_t dot(const uint8_t* bytes, const int8_t* weights, uint32_t count) {
  return dot_row(bytes, weights, count);
}

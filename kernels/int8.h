// The int8 kernels: shadow networks on any set of texels, and the convolutions of the lighting network. A table per
// instruction set, as for the float kernels, but
// picked apart from them: what counts here is the dot product of bytes, which cores of one family have or lack.
// Everything that reaches a texture is integer, apart from one float multiply and rounding an activation
// (requantisation), so all tables give the same bits.
//
// Requantisation rule, the only one: byte = round to nearest even(clamp(float(sum) * multiplier, 0, 255)), with the sum
// in 32 bits and the conversion and the product each rounded once, to nearest even.
#pragma once

#include <cstdint>

#include "sandglass/shadow.h"

namespace sandglass {

constexpr uint32_t k_texel_block = 48;          // texels that go through the layers together: their bytes stay in L1
constexpr uint32_t k_channel_group = 32;        // widths are padded to multiples of it
constexpr uint32_t k_shadow_width_limit = 256;  // accumulators: 256 * 255 * 127 < 2^24, so floats hold them exactly
constexpr uint32_t k_shadow_layers_limit = 8;
constexpr uint32_t k_coverage_steps = 4096;  // of the output's argument
constexpr float k_coverage_scale = 256.0f;   // steps per 1

struct Int8Layer {
  const int8_t* weights;  // packed by the table's own pack_layer
  const int32_t* bias;
  const float* multiplier;
};

struct ShadowNetwork {
  uint32_t width;   // padded
  uint32_t layers;  // hidden layers after the first
  // The first layer, separated: byte c of texel (u, v) = clamp((columns[u][c] + rows[v][c]) >> shift, 0, 255), the sum
  // saturating at 16 bits. Rows hold light, bias and rounding too.
  const int16_t* columns;
  const int16_t* rows;
  uint32_t shift;
  Int8Layer layer[k_shadow_layers_limit];
  const int8_t* last_weights;  // width bytes, zero beyond the network's own
  int32_t last_bias;
  float last_multiplier;    // to steps of the table
  const uint8_t* coverage;  // k_coverage_steps bytes: 255 * (1 - transparency)
};

struct TexelRange {
  const uint16_t* u;  // `count` texels anywhere in the texture
  const uint16_t* v;
  uint32_t count;
  uint8_t* scratch;   // shadow_scratch_bytes(), aligned to 64
  uint8_t* coverage;  // out, `count` bytes
};

// A convolution over pixels whose channels lie together. Outputs and inputs are multiples of k_channel_group; the sum
// of a window's inputs is at most 65,793, so that 32 bits hold every sum.
struct Int8Convolution {
  const int8_t* weights;  // packed by the table's own pack_layer: outputs x (rows, columns, inputs)
  const int32_t* bias;
  const float* multiplier;
  const uint8_t *low, *high;  // an input byte counts as the nearest one in low..high; null: as it is
  uint32_t inputs;            // of one pixel
  uint32_t outputs;
};

constexpr uint32_t k_convolution_inputs_limit = 1024;  // of one pixel
constexpr uint32_t k_stem_pixels_limit = 256;          // of an image's row
constexpr uint32_t k_stem_window = 7;                  // pixels a side, two apart
constexpr uint32_t k_stem_bytes = 160;                 // 7 x 7 x 3, and zeros up to a multiple of 16
constexpr uint32_t k_stem_outputs = 64;
constexpr uint32_t k_tile_slack = 8;  // pixels behind the last one of a buffer that wide may read, and throws away

// `count` neighbouring pixels of one row.
struct PixelRow {
  const uint8_t* in;
  uint32_t in_stride;  // bytes from pixel to pixel
  uint32_t in_pitch;   // bytes from row to row, where a window has more than one
  uint32_t count;      // of output
  uint8_t* out;        // aligned to 16, as are its strides
  uint32_t out_stride;
};

constexpr uint64_t shadow_scratch_bytes(uint32_t width) { return uint64_t{2} * k_texel_block * width; }

struct Int8Kernels {
  sandglass_isa isa;
  // From outputs x inputs bytes, all inputs of output 0 first, to this table's own order; the bias takes what the
  // table's arithmetic needs. Both are of the same size as before. Outputs are a multiple of k_channel_group, inputs
  // of 16.
  void (*pack_layer)(const int8_t* weights, const int32_t* bias, uint32_t outputs, uint32_t inputs, int8_t* packed,
                     int32_t* packed_bias);
  void (*shadow_texels)(const ShadowNetwork* network, const TexelRange* range);

  // 1x1 on clamped bytes.
  void (*narrow)(const Int8Convolution* convolution, const PixelRow* row);
  // The same after averaging 2x2 clamped bytes: (a + b + c + d + 2) / 4, rounded down. `in` is the upper of two rows.
  void (*transition)(const Int8Convolution* convolution, const PixelRow* row);
  // 3x3 with the pixels' bytes one behind the other (in_stride = inputs); `in` is the window's first pixel.
  void (*wide)(const Int8Convolution* convolution, const PixelRow* row);
  // 7x7, two pixels apart, of an RGB image of width x height; output row y of width / 2 pixels, k_stem_outputs bytes
  // each. Beyond the image lies `border`.
  void (*stem)(const Int8Convolution* convolution, const uint8_t* rgb, const uint8_t border[3], uint32_t width,
               uint32_t height, uint32_t y, uint8_t* out);
  // The greatest of 3x3 pixels, two apart, of rows of width x k_stem_outputs bytes; output row y of width / 2 pixels.
  void (*pool)(const uint8_t* rows, uint32_t width, uint32_t height, uint32_t y, uint8_t* out, uint32_t out_stride);
  // Sum of `count` products, a multiple of 32; both aligned to 64.
  int32_t (*dot)(const uint8_t* bytes, const int8_t* weights, uint32_t count);
};

// The table for `isa` (AUTOMATIC: the fastest that this CPU runs), or null where build or CPU lack it.
const Int8Kernels* select_int8_kernels(sandglass_isa isa);

}  // namespace sandglass

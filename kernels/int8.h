// The int8 kernels: shadow networks on any set of texels, ambient shadows, and the convolutions of the lighting
// network. There is one table per instruction set, as for the float kernels, but it is picked on its own: what counts
// here is the dot product of bytes, which some cores of one family have and others lack. All arithmetic is in integers,
// apart from one float multiply and one rounding for each activation (requantisation), so all tables give the same
// bits.
//
// There is one rule of requantisation:
//   byte = round to nearest even(clamp(float(sum) * multiplier, 0, 255))
// The sum has 32 bits. The conversion and the product are each rounded once, to nearest even.
#pragma once

#include <cstdint>

#include "sandglass/shadow.h"

namespace sandglass {

constexpr uint32_t k_texel_block = 48;    // texels that go through the layers together: their bytes stay in L1
constexpr uint32_t k_channel_group = 32;  // widths are padded to multiples of it
// Channels of a layer. The products of one sum then stay below 2^24 (256 * 255 * 127), and 32 bits hold them beside any
// bias that a file may have.
constexpr uint32_t k_shadow_width_limit = 256;
constexpr uint32_t k_shadow_layers_limit = 8;
// The sigmoid of the output is a table: this many steps, so many for each 1 of its argument.
constexpr uint32_t k_coverage_steps = 4096;
constexpr float k_coverage_scale = 256.0f;

struct Int8Layer {
  const int8_t* weights;  // packed by the table's own pack_layer
  const int32_t* bias;
  const float* multiplier;
};

struct ShadowNetwork {
  uint32_t width;   // padded
  uint32_t layers;  // hidden layers after the first
  // The first layer is the sum of a part of u and a part of v, one table each:
  //   byte c of texel (u, v) = clamp((columns[u][c] + rows[v][c]) >> shift, 0, 255)
  // The sum saturates at 16 bits. The rows also hold the light, the bias and the rounding.
  const int16_t* columns;
  const int16_t* rows;
  uint32_t shift;
  Int8Layer layer[k_shadow_layers_limit];
  const int8_t* last_weights;  // width bytes, zero beyond the network's own
  int32_t last_bias;
  float last_multiplier;    // from the last sum to steps of the coverage table
  const uint8_t* coverage;  // k_coverage_steps bytes: 255 * (1 - transparency)
};

struct TexelRange {
  const uint16_t* u;  // `count` texels anywhere in the texture
  const uint16_t* v;
  uint32_t count;
  uint8_t* scratch;   // shadow_scratch_bytes(), aligned to 64
  uint8_t* coverage;  // out, `count` bytes
};

// The components of an ambient shadow: textures of signed bytes, one after another, and how much of each is taken.
//   byte of texel t = 255 - clamp((2^(shift - 1) + sum over k of weights[k] * texels[k * size + t]) >> shift, 0, 255)
// A sum stays below 2^28 (32 components * 127 * 32767, and the rounding).
struct AmbientComponents {
  const int8_t* texels;    // aligned to 64
  uint32_t size;           // texels in one component, a multiple of k_ambient_group
  uint32_t count;          // even, at most k_ambient_components_limit
  const int16_t* weights;  // one for each component
  uint32_t shift;          // 1..k_ambient_shift_limit
};

constexpr uint32_t k_ambient_components_limit = 32;
constexpr uint32_t k_ambient_shift_limit = 27;
constexpr uint32_t k_ambient_group = 32;  // ranges of texels begin and end at multiples of it

// A convolution over pixels whose channels lie together. Outputs and inputs are multiples of k_channel_group. A window
// has at most 9 * 128 inputs, so its products add up to less than 2^26. A file's biases are at most 2^29 (they are
// checked when it is loaded), so 32 bits hold every sum.
struct Int8Convolution {
  const int8_t* weights;  // packed by the table's own pack_layer: outputs x (rows, columns, inputs)
  const int32_t* bias;
  const float* multiplier;
  // One of each for every input: narrow and transition clamp an input byte to low..high. The others do not read them.
  const uint8_t *low, *high;
  uint32_t inputs;  // channels of one input pixel
  uint32_t outputs;
};

constexpr uint32_t k_convolution_inputs_limit = 1024;  // channels of one input pixel
constexpr uint32_t k_stem_pixels_limit = 256;          // pixels in a row of the image
constexpr uint32_t k_stem_window = 7;                  // pixels a side; windows are two pixels apart
constexpr uint32_t k_stem_bytes = 160;                 // 7 x 7 x 3, and zeros up to a multiple of 16
constexpr uint32_t k_stem_outputs = 64;
// Pixels behind the last one of a buffer: wide may read them and does not use them.
constexpr uint32_t k_tile_slack = 8;

// `count` neighbouring pixels of one row of output, and where their input begins.
struct PixelRow {
  const uint8_t* in;
  uint32_t in_stride;  // bytes from pixel to pixel
  uint32_t in_pitch;   // bytes from row to row, where a window has more than one row
  uint32_t count;
  uint8_t* out;  // aligned to 16, as are its strides
  uint32_t out_stride;
};

constexpr uint64_t shadow_scratch_bytes(uint32_t width) { return uint64_t{2} * k_texel_block * width; }

struct Int8Kernels {
  sandglass_isa isa;
  // Puts outputs x inputs weights (all inputs of output 0 first) into this table's own order, and adds to the biases
  // what the table's arithmetic needs. Neither array changes its size. Outputs are a multiple of k_channel_group,
  // inputs of 16.
  void (*pack_layer)(const int8_t* weights, const int32_t* bias, uint32_t outputs, uint32_t inputs, int8_t* packed,
                     int32_t* packed_bias);
  void (*shadow_texels)(const ShadowNetwork* network, const TexelRange* range);
  // Texels begin..end of an ambient shadow; writes visibility[begin..end].
  void (*ambient_texels)(const AmbientComponents* components, uint32_t begin, uint32_t end, uint8_t* visibility);

  // A 1x1 convolution of clamped bytes.
  void (*narrow)(const Int8Convolution* convolution, const PixelRow* row);
  // The same after averaging 2x2 clamped bytes: (a + b + c + d + 2) / 4, rounded down. `in` is the upper of two rows.
  void (*transition)(const Int8Convolution* convolution, const PixelRow* row);
  // A 3x3 convolution. Pixels lie without gaps (in_stride = inputs); `in` is the first pixel of the first window.
  void (*wide)(const Int8Convolution* convolution, const PixelRow* row);
  // A 7x7 convolution, two pixels apart, of an RGB image of width x height. Writes row y of the output: width / 2
  // pixels of k_stem_outputs bytes. Pixels beyond the image are `border`.
  void (*stem)(const Int8Convolution* convolution, const uint8_t* rgb, const uint8_t border[3], uint32_t width,
               uint32_t height, uint32_t y, uint8_t* out);
  // The greatest of 3x3 pixels, two apart, in an image of width x height pixels of k_stem_outputs bytes. Writes row y
  // of the output: width / 2 pixels.
  void (*pool)(const uint8_t* rows, uint32_t width, uint32_t height, uint32_t y, uint8_t* out, uint32_t out_stride);
  // The sum of `count` products. `count` is a multiple of 32; both arrays are aligned to 64.
  int32_t (*dot)(const uint8_t* bytes, const int8_t* weights, uint32_t count);
};

// The table for `isa` (AUTOMATIC: the fastest that this CPU runs), or null where build or CPU lack it. The tables for
// shadows alone and for light alone have null for the other's kernels and do not link them into the program.
const Int8Kernels* select_int8_kernels(sandglass_isa isa);
const Int8Kernels* select_shadow_kernels(sandglass_isa isa);
const Int8Kernels* select_light_kernels(sandglass_isa isa);

}  // namespace sandglass

// The int8 kernels: shadow networks on any set of texels. A table per instruction set, as for the float kernels, but
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

constexpr uint64_t shadow_scratch_bytes(uint32_t width) { return uint64_t{2} * k_texel_block * width; }

struct Int8Kernels {
  sandglass_isa isa;
  // From width x width bytes, all inputs of output 0 first, to this table's own order; the bias takes what the table's
  // arithmetic needs. Both are of the same size as before.
  void (*pack_layer)(const int8_t* weights, const int32_t* bias, uint32_t width, int8_t* packed, int32_t* packed_bias);
  void (*shadow_texels)(const ShadowNetwork* network, const TexelRange* range);
};

// The table for `isa` (AUTOMATIC: the fastest that this CPU runs), or null where build or CPU lack it.
const Int8Kernels* select_int8_kernels(sandglass_isa isa);

}  // namespace sandglass

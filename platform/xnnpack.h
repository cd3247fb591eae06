// XNNPACK's convolutions behind declarations of our own: xnnpack.cpp is the only file that knows its header, which
// comes in two generations. Until 2023 an operator is created, set up with its image's size and buffers, and run; since
// then it is created, reshaped to that size, which may ask for a workspace, set up with workspace and buffers, and run.
// Here an operator has one size for ever, and buffers from run to run.
//
// Memory: xnn_initialize installs one allocator per process, and its first caller wins. Ours takes from one static
// region of SANDGLASS_XNNPACK_REGION_MIB MiB, never from the heap. Where the app was first, nothing bounds what XNNPACK
// takes: then this refuses to begin. Nothing is taken or given back while an operator runs.
//
// Not for several threads at once: create, prepare and release from one at a time; an operator runs on one.
#pragma once

#include <cstdint>

namespace sandglass {

#ifndef SANDGLASS_XNNPACK_REGION_MIB
#define SANDGLASS_XNNPACK_REGION_MIB 64
#endif
constexpr uint64_t k_xnnpack_region_bytes = uint64_t{SANDGLASS_XNNPACK_REGION_MIB} << 20;
// XNNPACK may read so many bytes behind an input.
constexpr uint32_t k_xnnpack_slack_bytes = 256;

// size x size, `step` pixels apart, over width x height pixels side by side. Left and right of them lie pad_columns of
// the byte 0; above and below nothing: the caller's rows have what is needed there.
struct XnnpackConvolution {
  uint32_t size, step, pad_columns;
  uint32_t inputs, outputs, in_stride, out_stride;  // channels, and values from pixel to pixel
  uint32_t width, height;
};

struct XnnpackOperator;

// Before anything else; may be repeated. False, and one sentence, where the region cannot be had.
bool xnnpack_begin(const char** reason);

// Weights: of output 0 row, column, input; then of output 1. They are copied. NULL, and one sentence: the region is
// full, or this version or CPU cannot do it.
// In float: the sum and the bias, clamped to low..high, which may be infinite.
XnnpackOperator* xnnpack_create(const XnnpackConvolution& shape, const float* weights, const float* bias, float low,
                                float high, const char** reason);
// In bytes, stored as byte - 128: (sum of weight * byte + bias) * multiplier, rounded and clamped to 0..255.
XnnpackOperator* xnnpack_create(const XnnpackConvolution& shape, const int8_t* weights, const int32_t* bias,
                                const float* multipliers, const char** reason);
void xnnpack_release(XnnpackOperator* op);  // NULL: nothing

void xnnpack_run(XnnpackOperator* op, const void* in, void* out);

uint64_t xnnpack_region_used();  // bytes, now

}  // namespace sandglass

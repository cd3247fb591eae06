// XNNPACK's convolutions behind declarations of our own. xnnpack.cpp and xnnpack_create.h are the only files of the
// library that know XNNPACK's header, which comes in two generations. Until 2023 an operator is created, set up with
// the size of its image and its buffers, and run. Since then it is created, reshaped to that size (which may ask for a
// workspace), set up with workspace and buffers, and run. Here an operator keeps one size; the buffers are given for
// each run.
//
// Memory: xnn_initialize installs one allocator per process, and its first caller wins. The allocator here takes from
// one static region of SANDGLASS_XNNPACK_REGION_MIB MiB, never from the heap. If the app called first, nothing bounds
// what XNNPACK takes, and xnnpack_begin refuses. Nothing is taken or given back while an operator runs.
//
// Threads: create and release from one thread at a time. An operator runs on one thread at a time.
#pragma once

#include <cstdint>

namespace sandglass {

#ifndef SANDGLASS_XNNPACK_REGION_MIB
#define SANDGLASS_XNNPACK_REGION_MIB 64
#endif
constexpr uint64_t k_xnnpack_region_bytes = uint64_t{SANDGLASS_XNNPACK_REGION_MIB} << 20;
// XNNPACK may read this many bytes behind an input.
constexpr uint32_t k_xnnpack_slack_bytes = 256;

// Windows of size x size pixels, `step` pixels apart, over an image of width x height pixels. Left and right of the
// image are pad_columns columns of 0. Above and below is no padding: the caller's rows include what a window needs
// there.
struct XnnpackConvolution {
  uint32_t size, step, pad_columns;
  // Channels of a pixel, and values from pixel to pixel.
  uint32_t inputs, outputs, in_stride, out_stride;
  uint32_t width, height;
};

struct XnnpackOperator;

// Call this before the functions below; it may be repeated. Returns false, with a sentence in `reason`, where XNNPACK
// does not run or does not use the region.
bool xnnpack_begin(const char** reason);

// The weights of output 0 come first, by row, column, input; then those of output 1. They are copied. Returns NULL,
// with a sentence in `reason`, if the region is full or this version or CPU cannot do it.
//
// In float: the sum plus the bias, clamped to low..high, which may be infinite.
XnnpackOperator* xnnpack_create(const XnnpackConvolution& shape, const float* weights, const float* bias, float low,
                                float high, const char** reason);
// In bytes, stored as byte - 128: (sum of weight * byte + bias) * multiplier, rounded and clamped to 0..255.
XnnpackOperator* xnnpack_create(const XnnpackConvolution& shape, const int8_t* weights, const int32_t* bias,
                                const float* multipliers, const char** reason);
void xnnpack_release(XnnpackOperator* op);  // NULL is ignored

void xnnpack_run(XnnpackOperator* op, const void* in, void* out);

uint64_t xnnpack_region_used();  // bytes in use now

}  // namespace sandglass

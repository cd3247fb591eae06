/* The functions of XNNPACK that platform/xnnpack.cpp calls, as the generation since 2023 declares them. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "pthreadpool.h"

#ifdef __cplusplus
extern "C" {
#endif

#define XNN_EXTRA_BYTES 128

enum xnn_status {
  xnn_status_success = 0,
  xnn_status_uninitialized = 1,
  xnn_status_invalid_parameter = 2,
  xnn_status_invalid_state = 3,
  xnn_status_unsupported_parameter = 4,
  xnn_status_unsupported_hardware = 5,
  xnn_status_out_of_memory = 6
};

struct xnn_allocator {
  void* context;
  void* (*allocate)(void* context, size_t size);
  void* (*reallocate)(void* context, void* pointer, size_t size);
  void (*deallocate)(void* context, void* pointer);
  void* (*aligned_allocate)(void* context, size_t alignment, size_t size);
  void (*aligned_deallocate)(void* context, void* pointer);
};

typedef struct xnn_operator* xnn_operator_t;
typedef struct xnn_code_cache* xnn_code_cache_t;
typedef struct xnn_weights_cache_provider* xnn_weights_cache_t;

enum xnn_status xnn_initialize(const struct xnn_allocator* allocator);

enum xnn_status xnn_create_convolution2d_nhwc_f32(uint32_t top, uint32_t right, uint32_t bottom, uint32_t left,
                                                  uint32_t kernel_height, uint32_t kernel_width, uint32_t step_y,
                                                  uint32_t step_x, uint32_t dilation_y, uint32_t dilation_x,
                                                  uint32_t groups, size_t inputs, size_t outputs, size_t in_stride,
                                                  size_t out_stride, const float* kernel, const float* bias, float low,
                                                  float high, uint32_t flags, xnn_code_cache_t code,
                                                  xnn_weights_cache_t weights, xnn_operator_t* result);
enum xnn_status xnn_reshape_convolution2d_nhwc_f32(xnn_operator_t op, size_t batch, size_t height, size_t width,
                                                   size_t* workspace_size, size_t* workspace_alignment,
                                                   size_t* out_height, size_t* out_width, pthreadpool_t threads);
enum xnn_status xnn_setup_convolution2d_nhwc_f32(xnn_operator_t op, void* workspace, const float* input, float* output);

enum xnn_status xnn_create_convolution2d_nhwc_qs8_qc8w(
    uint32_t top, uint32_t right, uint32_t bottom, uint32_t left, uint32_t kernel_height, uint32_t kernel_width,
    uint32_t step_y, uint32_t step_x, uint32_t dilation_y, uint32_t dilation_x, uint32_t groups, size_t inputs,
    size_t outputs, size_t in_stride, size_t out_stride, int8_t in_zero, float in_scale, const float* kernel_scale,
    const int8_t* kernel, const int32_t* bias, int8_t out_zero, float out_scale, int8_t low, int8_t high,
    uint32_t flags, xnn_code_cache_t code, xnn_weights_cache_t weights, xnn_operator_t* result);
enum xnn_status xnn_reshape_convolution2d_nhwc_qs8_qc8w(xnn_operator_t op, size_t batch, size_t height, size_t width,
                                                        size_t* workspace_size, size_t* workspace_alignment,
                                                        size_t* out_height, size_t* out_width, pthreadpool_t threads);
enum xnn_status xnn_setup_convolution2d_nhwc_qs8_qc8w(xnn_operator_t op, void* workspace, const int8_t* input,
                                                      int8_t* output);

enum xnn_status xnn_run_operator(xnn_operator_t op, pthreadpool_t threads);
enum xnn_status xnn_delete_operator(xnn_operator_t op);

#ifdef __cplusplus
}
#endif

// XNNPACK's convolutions, computed one sum after another. Calls in an order that XNNPACK would refuse are refused.
// Memory comes from the allocator of the first initialisation.
#include <xnnpack.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "calls.h"

namespace xnnpack_stand_in {
Asked g_asked[k_call_capacity];
size_t g_asked_count = 0, g_create_failures = 0;
bool g_app_was_first = false;
}  // namespace xnnpack_stand_in

using namespace xnnpack_stand_in;

struct xnn_operator {
  uint32_t pad[4];  // top, right, bottom, left
  uint32_t size[2], step[2];
  size_t inputs, outputs, in_stride, out_stride, height = 0, width = 0, out_height = 0, out_width = 0;
  bool bytes = false, reshaped = false, set_up = false;
  int zero = 0, out_zero = 0;
  float low, high;
  void* weights = nullptr;  // kernel, bias, scales
  const void* in = nullptr;
  void* out = nullptr;
};

namespace {

const xnn_allocator* g_allocator = nullptr;
xnn_allocator g_first;

void* system_allocate(void*, size_t size) { return std::malloc(size); }
void* system_reallocate(void*, void* p, size_t size) { return std::realloc(p, size); }
void system_free(void*, void* p) { std::free(p); }
void* system_aligned(void*, size_t alignment, size_t size) {
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

void note(Call call, const void* op) {
  if (g_asked_count < k_call_capacity) g_asked[g_asked_count++] = {call, op};
}

template <class Weight, class Bias>
xnn_status create(const xnn_operator& values, uint32_t dilation, uint32_t groups, const Weight* kernel,
                  const Bias* bias, const float* scales, xnn_code_cache_t code, xnn_weights_cache_t cache,
                  xnn_operator_t* result) {
  if (g_allocator == nullptr) return xnn_status_uninitialized;
  if (dilation != 1 || groups != 1 || code != nullptr || cache != nullptr) return xnn_status_unsupported_parameter;
  if (g_create_failures > 0) {
    --g_create_failures;
    return xnn_status_unsupported_hardware;
  }
  auto* op = static_cast<xnn_operator*>(g_allocator->allocate(g_allocator->context, sizeof(xnn_operator)));
  if (op == nullptr) return xnn_status_out_of_memory;
  *op = values;
  const size_t places = op->size[0] * op->size[1] * op->inputs * op->outputs;
  op->weights = g_allocator->aligned_allocate(g_allocator->context, 64, 4 * (places + 2 * op->outputs));
  if (op->weights == nullptr) {
    g_allocator->deallocate(g_allocator->context, op);
    return xnn_status_out_of_memory;
  }
  auto* packed = static_cast<float*>(op->weights);
  for (size_t i = 0; i < places; ++i) packed[i] = static_cast<float>(kernel[i]);
  std::memcpy(packed + places, bias, 4 * op->outputs);
  for (size_t o = 0; o < op->outputs; ++o) packed[places + op->outputs + o] = scales == nullptr ? 1.0f : scales[o];
  note(Call::create, op);
  *result = op;
  return xnn_status_success;
}

xnn_status reshape(xnn_operator_t op, bool bytes, size_t batch, size_t height, size_t width, size_t* workspace_size,
                   size_t* workspace_alignment, size_t* out_height, size_t* out_width) {
  if (batch != 1 || op->bytes != bytes) return xnn_status_invalid_parameter;
  op->height = height;
  op->width = width;
  op->out_height = *out_height = (height + op->pad[0] + op->pad[2] - op->size[0]) / op->step[0] + 1;
  op->out_width = *out_width = (width + op->pad[1] + op->pad[3] - op->size[1]) / op->step[1] + 1;
  op->reshaped = true;
  op->set_up = false;
  *workspace_size = op->size[0] > 1 ? k_workspace : 0;
  *workspace_alignment = 64;
  note(Call::reshape, op);
  return xnn_status_success;
}

xnn_status set_up(xnn_operator_t op, bool bytes, void* workspace, const void* in, void* out) {
  if (!op->reshaped || op->bytes != bytes) return xnn_status_invalid_state;
  if (op->size[0] > 1) {
    if (workspace == nullptr || reinterpret_cast<uintptr_t>(workspace) % 64 != 0) return xnn_status_invalid_parameter;
    std::memset(workspace, 0xA5, k_workspace);
  }
  op->in = in;
  op->out = out;
  op->set_up = true;
  note(Call::setup, op);
  return xnn_status_success;
}

template <class Value>
void convolve(const xnn_operator& op) {
  const auto* in = static_cast<const Value*>(op.in);
  auto* out = static_cast<Value*>(op.out);
  const auto* kernel = static_cast<const float*>(op.weights);
  const size_t window = op.size[0] * op.size[1] * op.inputs;
  const float *bias = kernel + window * op.outputs, *scales = bias + op.outputs;
  for (size_t y = 0; y < op.out_height; ++y)
    for (size_t x = 0; x < op.out_width; ++x)
      for (size_t o = 0; o < op.outputs; ++o) {
        int32_t whole = 0;
        std::memcpy(&whole, bias + o, sizeof whole);
        double sum = op.bytes ? static_cast<double>(whole) : static_cast<double>(bias[o]);
        for (size_t i = 0; i < op.size[0] * op.size[1]; ++i) {
          const size_t v = y * op.step[0] + i / op.size[1], u = x * op.step[1] + i % op.size[1];  // plus the padding
          if (v < op.pad[0] || v >= op.height + op.pad[0] || u < op.pad[3] || u >= op.width + op.pad[3]) continue;
          const Value* pixel = in + ((v - op.pad[0]) * op.width + (u - op.pad[3])) * op.in_stride;
          const float* weights = kernel + o * window + i * op.inputs;
          for (size_t c = 0; c < op.inputs; ++c)
            sum += static_cast<double>(weights[c]) * (static_cast<double>(pixel[c]) - op.zero);
        }
        double value = op.bytes ? static_cast<double>(static_cast<float>(sum) * scales[o]) : sum;
        value =
            std::clamp(value, static_cast<double>(op.low) - op.out_zero, static_cast<double>(op.high) - op.out_zero);
        if (op.bytes) value = std::nearbyint(value) + op.out_zero;
        out[(y * op.out_width + x) * op.out_stride + o] = static_cast<Value>(value);
      }
}

}  // namespace

xnn_status xnn_initialize(const xnn_allocator* allocator) {
  static const xnn_allocator k_system = {nullptr,     system_allocate, system_reallocate,
                                         system_free, system_aligned,  system_free};
  g_first = g_app_was_first || allocator == nullptr ? k_system : *allocator;
  g_allocator = &g_first;
  note(Call::initialize, nullptr);
  return xnn_status_success;
}

xnn_status xnn_create_convolution2d_nhwc_f32(uint32_t top, uint32_t right, uint32_t bottom, uint32_t left,
                                             uint32_t kernel_height, uint32_t kernel_width, uint32_t step_y,
                                             uint32_t step_x, uint32_t dilation_y, uint32_t dilation_x, uint32_t groups,
                                             size_t inputs, size_t outputs, size_t in_stride, size_t out_stride,
                                             const float* kernel, const float* bias, float low, float high, uint32_t,
                                             xnn_code_cache_t code, xnn_weights_cache_t weights,
                                             xnn_operator_t* result) {
  const xnn_operator op = {.pad = {top, right, bottom, left},
                           .size = {kernel_height, kernel_width},
                           .step = {step_y, step_x},
                           .inputs = inputs,
                           .outputs = outputs,
                           .in_stride = in_stride,
                           .out_stride = out_stride,
                           .low = low,
                           .high = high};
  return create(op, dilation_y * dilation_x, groups, kernel, bias, nullptr, code, weights, result);
}

xnn_status xnn_create_convolution2d_nhwc_qs8_qc8w(
    uint32_t top, uint32_t right, uint32_t bottom, uint32_t left, uint32_t kernel_height, uint32_t kernel_width,
    uint32_t step_y, uint32_t step_x, uint32_t dilation_y, uint32_t dilation_x, uint32_t groups, size_t inputs,
    size_t outputs, size_t in_stride, size_t out_stride, int8_t in_zero, float in_scale, const float* kernel_scale,
    const int8_t* kernel, const int32_t* bias, int8_t out_zero, float out_scale, int8_t low, int8_t high, uint32_t,
    xnn_code_cache_t code, xnn_weights_cache_t weights, xnn_operator_t* result) {
  for (size_t o = 0; o < outputs; ++o)
    if (!(in_scale * kernel_scale[o] / out_scale < 256.0f) || !(kernel_scale[o] > 0))
      return xnn_status_unsupported_parameter;
  const xnn_operator op = {.pad = {top, right, bottom, left},
                           .size = {kernel_height, kernel_width},
                           .step = {step_y, step_x},
                           .inputs = inputs,
                           .outputs = outputs,
                           .in_stride = in_stride,
                           .out_stride = out_stride,
                           .bytes = true,
                           .zero = in_zero,
                           .out_zero = out_zero,
                           .low = static_cast<float>(low),
                           .high = static_cast<float>(high)};
  return create(op, dilation_y * dilation_x, groups, kernel, bias, kernel_scale, code, weights, result);
}

xnn_status xnn_reshape_convolution2d_nhwc_f32(xnn_operator_t op, size_t batch, size_t height, size_t width,
                                              size_t* workspace_size, size_t* workspace_alignment, size_t* out_height,
                                              size_t* out_width, pthreadpool_t) {
  return reshape(op, false, batch, height, width, workspace_size, workspace_alignment, out_height, out_width);
}
xnn_status xnn_reshape_convolution2d_nhwc_qs8_qc8w(xnn_operator_t op, size_t batch, size_t height, size_t width,
                                                   size_t* workspace_size, size_t* workspace_alignment,
                                                   size_t* out_height, size_t* out_width, pthreadpool_t) {
  return reshape(op, true, batch, height, width, workspace_size, workspace_alignment, out_height, out_width);
}
xnn_status xnn_setup_convolution2d_nhwc_f32(xnn_operator_t op, void* workspace, const float* input, float* output) {
  return set_up(op, false, workspace, input, output);
}
xnn_status xnn_setup_convolution2d_nhwc_qs8_qc8w(xnn_operator_t op, void* workspace, const int8_t* input,
                                                 int8_t* output) {
  return set_up(op, true, workspace, input, output);
}

xnn_status xnn_run_operator(xnn_operator_t op, pthreadpool_t) {
  if (!op->set_up) return xnn_status_invalid_state;
  if (op->bytes) convolve<int8_t>(*op);
  else convolve<float>(*op);
  note(Call::run, op);
  return xnn_status_success;
}

xnn_status xnn_delete_operator(xnn_operator_t op) {
  note(Call::remove, op);
  g_allocator->aligned_deallocate(g_allocator->context, op->weights);
  g_allocator->deallocate(g_allocator->context, op);
  return xnn_status_success;
}

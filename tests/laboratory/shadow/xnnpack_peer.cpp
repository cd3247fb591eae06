#include "tests/laboratory/shadow/xnnpack_peer.h"

#ifdef SANDGLASS_HAVE_XNNPACK

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/files/failure.h"
#include "platform/xnnpack_create.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_rows = 512;            // rows in a block; the fastest of 128..65536 with the version of 2022
constexpr int8_t k_zero = -128;             // the byte of activation 0; 0 .. clip become -128 .. 127
constexpr float k_input_step = 1.0f / 127;  // encoded inputs lie in -1..1

void check(xnn_status status) {
  if (status != xnn_status_success)
    throw Failure("cannot compare with XNNPACK: it refuses an operator of the shadow network. Build without it.");
}

// XNNPACK wants the weights by output: first all inputs of output 0.
std::vector<float> by_output(const float* weights, uint32_t inputs, uint32_t outputs) {
  std::vector<float> turned(size_t{inputs} * outputs);
  for (uint32_t i = 0; i < inputs; ++i)
    for (uint32_t o = 0; o < outputs; ++o) turned[size_t{o} * inputs + i] = weights[size_t{i} * outputs + o];
  return turned;
}

#ifdef SANDGLASS_XNNPACK_RESHAPES
// Later versions take one more table before the quantisation of the input. Floats have no quantisation.
template <class... Parameters>
void create_convert(xnn_status (*function)(Parameters...), const xnn_quantization_params& bytes, xnn_operator_t* op) {
  if constexpr (sizeof...(Parameters) == 8)
    check(function(xnn_unary_convert, xnn_datatype_fp32, xnn_datatype_qint8, nullptr, nullptr, &bytes, 0, op));
  else
    check(function(xnn_unary_convert, xnn_datatype_fp32, xnn_datatype_qint8, nullptr, nullptr, nullptr, &bytes, 0, op));
}
#endif

}  // namespace

struct XnnpackPeer::State {
  std::vector<xnn_operator_t> operators;
  xnn_operator_t to_bytes = nullptr;
  std::vector<float> a, b;
  std::vector<int8_t> ba, bb;
  uint32_t width = 0;
  uint32_t rows = 0;    // the number of rows that the operators were last shaped for
  float last_step = 0;  // the step of the int8 output

  // Versions from 2023 on have a call that sets the number of rows whenever it changes. In earlier ones, the call that
  // names the buffers sets it.
  template <class Reshape>
  void shape([[maybe_unused]] Reshape reshape, uint32_t count) {
    if (count == rows) return;
    rows = count;
#ifdef SANDGLASS_XNNPACK_RESHAPES
    for (const xnn_operator_t op : operators) check(reshape(op, rows, nullptr));
#endif
  }
  template <class Setup, class Value>
  void run(Setup setup, xnn_operator_t op, const Value* in, Value* out) const {
#ifdef SANDGLASS_XNNPACK_RESHAPES
    check(setup(op, in, out));
#else
    check(setup(op, rows, in, out, nullptr));
#endif
    check(xnn_run_operator(op, nullptr));
  }
  // Runs all operators on a block of rows. Two arrays take turns as input and output.
  template <class Setup, class Value>
  void run_all(Setup setup, const Value* in, Value* out, Value* other, Value* last) const {
    for (const xnn_operator_t op : operators) {
      if (op == operators.back()) out = last;
      run(setup, op, in, out);
      in = out;
      std::swap(out, other);
    }
  }
};

#ifdef SANDGLASS_XNNPACK_RESHAPES
#define SANDGLASS_RESHAPE(kind) &xnn_reshape_fully_connected_nc_##kind
#else
#define SANDGLASS_RESHAPE(kind) nullptr
#endif

XnnpackPeer::XnnpackPeer(const FloatNetwork& network, const std::vector<float>& clips, bool quantised)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  check(xnn_initialize(nullptr));
  const NetworkShape& shape = network.shape;
  s.width = shape.width;
  s.a.resize(size_t{k_rows} * shape.width + XNN_EXTRA_BYTES);
  s.b = s.a;
  s.ba.resize(size_t{k_rows} * shape.width + XNN_EXTRA_BYTES);
  s.bb = s.ba;
  float step = k_input_step;
  int8_t zero = 0;
  const auto add = [&](const float* weights, const float* bias, uint32_t inputs, uint32_t outputs, float clip) {
    const std::vector<float> kernel = by_output(weights, inputs, outputs);
    const bool last = outputs == 1;
    xnn_operator_t op = nullptr;
    if (!quantised) {
      check(xnnpack_create_operator(&xnn_create_fully_connected_nc_f32, &op, inputs, outputs, inputs, outputs,
                                    kernel.data(), bias, last ? -std::numeric_limits<float>::infinity() : 0.0f,
                                    std::numeric_limits<float>::infinity(), 0u));
    } else {
      float largest = 0;
      for (const float w : kernel) largest = std::max(largest, std::fabs(w));
      const float kernel_step = largest / 127;
      std::vector<int8_t> bytes;
      for (const float w : kernel) bytes.push_back(static_cast<int8_t>(std::nearbyint(w / kernel_step)));
      std::vector<int32_t> biases;
      for (uint32_t o = 0; o < outputs; ++o)
        biases.push_back(static_cast<int32_t>(std::nearbyint(bias[o] / (kernel_step * step))));
      s.last_step = 8.0f / 127;  // the sigmoid's argument in -8..8
      const float out_step = last ? s.last_step : clip / 255;
      check(xnnpack_create_operator(&xnn_create_fully_connected_nc_qs8, &op, inputs, outputs, inputs, outputs, zero,
                                    step, kernel_step, bytes.data(), biases.data(), last ? int8_t{0} : k_zero, out_step,
                                    int8_t{-128}, int8_t{127}, 0u));
      step = out_step;
      zero = k_zero;
    }
    s.operators.push_back(op);
  };
  if (quantised) {
#ifdef SANDGLASS_XNNPACK_RESHAPES
    const xnn_quantization_params bytes = {0, k_input_step};
    create_convert(&xnn_create_unary_elementwise_nc, bytes, &s.to_bytes);
#else
    check(xnn_create_convert_nc_f32_qs8(k_inputs, k_inputs, k_inputs, k_input_step, 0, -127, 127, 0, &s.to_bytes));
#endif
  }
  add(network.first_weights(), network.first_bias(), k_inputs, shape.width, clips[0]);
  for (uint32_t layer = 0; layer < shape.layers; ++layer)
    add(network.weights(layer), network.bias(layer), shape.width, shape.width, clips[layer + 1]);
  add(network.last_weights(), network.last_bias(), shape.width, 1, 0);
}

XnnpackPeer::~XnnpackPeer() {
  for (const xnn_operator_t op : state_->operators) xnn_delete_operator(op);
  if (state_->to_bytes != nullptr) xnn_delete_operator(state_->to_bytes);
}

void XnnpackPeer::run(const float* input, uint32_t texels, float* output) {
  State& s = *state_;
  for (uint32_t first = 0; first < texels; first += k_rows) {
    const uint32_t rows = std::min(k_rows, texels - first);
    s.shape(SANDGLASS_RESHAPE(f32), rows);
    s.run_all(&xnn_setup_fully_connected_nc_f32, input + size_t{first} * k_inputs, s.a.data(), s.b.data(),
              output + first);
  }
  for (uint32_t i = 0; i < texels; ++i) output[i] = 1 / (1 + std::exp(-output[i]));
}

void XnnpackPeer::round_inputs(const float* input, uint32_t texels, int8_t* bytes) {
#ifdef SANDGLASS_XNNPACK_RESHAPES
  check(xnn_reshape_unary_elementwise_nc(state_->to_bytes, texels, k_inputs, k_inputs, k_inputs, nullptr));
  check(xnn_setup_unary_elementwise_nc(state_->to_bytes, input, bytes));
#else
  check(xnn_setup_convert_nc_f32_qs8(state_->to_bytes, texels, input, bytes, nullptr));
#endif
  check(xnn_run_operator(state_->to_bytes, nullptr));
}

void XnnpackPeer::run_bytes(const int8_t* input, uint32_t texels, float* output) {
  State& s = *state_;
  float sigmoid[256];
  for (int i = 0; i < 256; ++i) sigmoid[i] = 1 / (1 + std::exp(-static_cast<float>(i - 128) * s.last_step));
  std::vector<int8_t> last(k_rows + XNN_EXTRA_BYTES);
  for (uint32_t first = 0; first < texels; first += k_rows) {
    const uint32_t rows = std::min(k_rows, texels - first);
    s.shape(SANDGLASS_RESHAPE(qs8), rows);
    s.run_all(&xnn_setup_fully_connected_nc_qs8, input + size_t{first} * k_inputs, s.ba.data(), s.bb.data(),
              last.data());
    for (uint32_t i = 0; i < rows; ++i) output[first + i] = sigmoid[last[i] + 128];
  }
}

}  // namespace sandglass::host

#endif

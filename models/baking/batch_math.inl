// See batch_math.h. This file is included once per instruction set, with SANDGLASS_BATCH_SET defined. Each set renames
// Eigen's namespace, so that the linker cannot merge two sets' instances of one template.
#include <cmath>
#define Eigen SANDGLASS_BATCH_EIGEN
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wclass-memaccess"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#endif
#include <Eigen/Core>

#include "models/baking/batch_math.h"

namespace sandglass::host::SANDGLASS_BATCH_SET {

using Matrix = Eigen::Map<Eigen::MatrixXf>;
using Constant = Eigen::Map<const Eigen::MatrixXf>;
using Column = Eigen::Map<const Eigen::VectorXf>;

static float sigmoid(float x) { return 1.0f / (1.0f + std::exp(-x)); }

// Turns a layer's sums (width x samples) into what the next layer sees: applies ReLU and, with a clip, rounding.
static void activate(float* values, uint64_t count, const float* clip) {
  if (clip == nullptr) {
    for (uint64_t i = 0; i < count; ++i) values[i] = values[i] > 0 ? values[i] : 0;
    return;
  }
  const float top = *clip, scale = 255.0f / top, step = top / 255.0f;
  constexpr float k_round = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer
  for (uint64_t i = 0; i < count; ++i) {
    float x = values[i] > 0 ? values[i] : 0;
    x = x < top ? x : top;
    values[i] = ((x * scale + k_round) - k_round) * step;
  }
}

static void forward(const Batch& b, float* output) {
  const uint32_t w = b.width;
  const uint64_t count = uint64_t{w} * b.samples;
  const float* p = b.parameters;
  const float* in = b.input;
  uint32_t depth = b.inputs;
  for (uint32_t layer = 0; layer <= b.layers; ++layer) {
    float* values = b.scratch + layer * count;
    Matrix z(values, w, b.samples);
    z.colwise() = Column(p + uint64_t{w} * depth, w);
    z.noalias() += Constant(p, w, depth) * Constant(in, depth, b.samples);
    activate(values, count, b.clips == nullptr ? nullptr : b.clips + layer);
    p += uint64_t{w} * (depth + 1);
    in = values;
    depth = w;
  }
  Eigen::Map<Eigen::VectorXf> out(output, b.samples);
  out.noalias() = Constant(in, w, b.samples).transpose() * Column(p, w);
  for (uint32_t s = 0; s < b.samples; ++s) output[s] = sigmoid(output[s] + p[w]);
}

static double gradient(const Batch& b, const float* target, const float* weight, float* grad) {
  const uint32_t w = b.width;
  const uint64_t count = uint64_t{w} * b.samples;
  float* delta = b.scratch + (b.layers + 1) * count;
  float* other = delta + count;
  float* output = other + count;
  forward(b, output);
  double loss = 0;
  for (uint32_t s = 0; s < b.samples; ++s) {
    const float error = output[s] - target[s];
    loss += static_cast<double>(weight[s] * error * error);
    output[s] = 2.0f * weight[s] * error * output[s] * (1.0f - output[s]);  // derivative by the sigmoid's argument
  }
  uint64_t at = uint64_t{w} * (b.inputs + 1) + uint64_t{b.layers} * w * (w + 1);
  const float* top = b.scratch + b.layers * count;
  Eigen::Map<Eigen::VectorXf> out(output, b.samples);
  Eigen::Map<Eigen::VectorXf>(grad + at, w).noalias() += Constant(top, w, b.samples) * out;
  grad[at + w] += out.sum();
  Matrix(delta, w, b.samples).noalias() = Column(b.parameters + at, w) * out.transpose();

  for (uint32_t layer = b.layers + 1; layer-- > 0;) {
    const float* values = b.scratch + layer * count;
    const float limit = b.clips == nullptr ? 3.0e38f : b.clips[layer];
    for (uint64_t i = 0; i < count; ++i) delta[i] = values[i] > 0 && values[i] < limit ? delta[i] : 0;
    const uint32_t depth = layer == 0 ? b.inputs : w;
    const float* in = layer == 0 ? b.input : b.scratch + (layer - 1) * count;
    at -= uint64_t{w} * (depth + 1);
    Matrix d(delta, w, b.samples);
    Matrix(grad + at, w, depth).noalias() += d * Constant(in, depth, b.samples).transpose();
    Eigen::Map<Eigen::VectorXf>(grad + at + uint64_t{w} * depth, w) += d.rowwise().sum();
    if (layer == 0) break;
    Matrix(other, w, b.samples).noalias() = Constant(b.parameters + at, w, w).transpose() * d;
    float* swap = delta;
    delta = other;
    other = swap;
  }
  return loss;
}

static void adam(const AdamStep& a, uint32_t begin, uint32_t end) {
  constexpr uint32_t k_part = 256;
  float sum[k_part];
  for (uint32_t first = begin; first < end; first += k_part) {
    const uint32_t count = end - first < k_part ? end - first : k_part;
    for (uint32_t i = 0; i < count; ++i) sum[i] = 0;
    for (uint32_t lane = 0; lane < a.lanes; ++lane) {
      const float* gradient = a.gradients[lane] + first;
      for (uint32_t i = 0; i < count; ++i) sum[i] += gradient[i];
    }
    float *p = a.parameters + first, *m = a.mean + first, *v = a.variance + first;
    for (uint32_t i = 0; i < count; ++i) {
      const float g = sum[i] * a.per_sample;
      m[i] = a.mean_decay * m[i] + (1 - a.mean_decay) * g;
      v[i] = a.variance_decay * v[i] + (1 - a.variance_decay) * g * g;
      p[i] -= a.mean_scale * m[i] / (std::sqrt(a.variance_scale * v[i]) + a.epsilon);
    }
  }
}

extern const BatchMath k_batch_math;
const BatchMath k_batch_math = {forward, gradient, adam};

}  // namespace sandglass::host::SANDGLASS_BATCH_SET

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

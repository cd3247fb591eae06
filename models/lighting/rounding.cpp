#include "models/lighting/rounding.h"

#include <algorithm>
#include <cmath>

namespace sandglass::host {

namespace {

// So many samples wait together. A row of products is then read from memory once for all of them.
constexpr size_t k_waiting = 32;

}  // namespace

void InputProducts::add(const float* values, size_t size) {
  if (inputs == 0) {
    inputs = size;
    sums.assign(size, 0), products.assign(size * size, 0);
  }
  waiting.insert(waiting.end(), values, values + size);
  ++count;
  for (size_t i = 0; i < size; ++i) sums[i] += static_cast<double>(values[i]);
  if (waiting.size() == k_waiting * size) flush();
}

void InputProducts::flush() {
  for (size_t i = 0; i < inputs; ++i) {
    float* row = products.data() + i * inputs;
    for (size_t sample = 0; sample < waiting.size(); sample += inputs) {
      const float* x = waiting.data() + sample;
      const float a = x[i];
      if (a == 0) continue;
      for (size_t k = 0; k <= i; ++k) row[k] += a * x[k];
    }
  }
  waiting.clear();
}

std::vector<float> triangular_factor(const InputProducts& p, const std::vector<double>& units, double ridge) {
  const size_t n = p.inputs;
  const double count = static_cast<double>(p.count);
  std::vector<float> h(n * n);  // lower triangle
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k <= i; ++k) {
      const double covariance =
          static_cast<double>(p.products[i * n + k]) / count - p.sums[i] / count * (p.sums[k] / count);
      const double unit = units[i % units.size()] * units[k % units.size()];
      h[i * n + k] = static_cast<float>((unit == 0 ? 0 : covariance / unit) + (i == k ? ridge : 0));
    }
  // This goes from the last input to the first. Column j of M overwrites row j, mirrored.
  for (size_t j = n; j-- > 0;) {
    float* column = h.data() + j * n;
    const float d = std::max(column[j], static_cast<float>(ridge));
    for (size_t i = 0; i < j; ++i) {
      const float factor = column[i] / d;
      if (factor == 0) continue;
      float* row = h.data() + i * n;
      for (size_t k = 0; k <= i; ++k) row[k] -= factor * column[k];
    }
    for (size_t i = 0; i < j; ++i) column[i] /= d;
  }
  return h;
}

std::vector<int8_t> rounded(const std::vector<double>& weights, double scale, const std::vector<float>& factor) {
  const size_t n = weights.size();
  std::vector<int8_t> integers(n);
  std::vector<float> errors(n);  // the rounding errors of the weights before
  for (size_t k = 0; k < n; ++k) {
    double aim = weights[k] / scale;
    if (!factor.empty()) {
      const float* column = factor.data() + k * n;
      float sum = 0;
      for (size_t j = 0; j < k; ++j) sum += errors[j] * column[j];
      aim -= static_cast<double>(sum);
    }
    const double integer = std::clamp(std::nearbyint(aim), -127.0, 127.0);
    errors[k] = static_cast<float>(integer - weights[k] / scale);
    integers[k] = static_cast<int8_t>(integer);
  }
  return integers;
}

}  // namespace sandglass::host

// Rounding a convolution's weights so that its outputs change least. To nearest is best for each weight; for their sum
// it is better to let each weight make up for what the ones before it did, as far as their inputs vary together. With
// the inputs' covariance H = M D M^T, M unit upper triangular, the error e of a row of weights costs e H e^T = sum_k
// D_k ((e M)_k)^2, so weight k aims at w_k - sum_{j<k} e_j M_jk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sandglass::host {

// Sums of what a window's inputs were, and of their products.
struct InputProducts {
  size_t inputs = 0;
  uint64_t count = 0;
  std::vector<double> sums;
  std::vector<float> products;  // inputs x inputs, lower triangle
  std::vector<float> waiting;   // samples that are not yet in the products

  void add(const float* values, size_t size);
  void flush();
};

// M, of inputs divided by `units` (0: an input that does not count); `ridge` is added to every variance.
std::vector<float> triangular_factor(const InputProducts& products, const std::vector<double>& units, double ridge);

// Integers in -127..127 for `weights` in units of `scale`; `factor` empty: each to nearest.
std::vector<int8_t> rounded(const std::vector<double>& weights, double scale, const std::vector<float>& factor);

}  // namespace sandglass::host

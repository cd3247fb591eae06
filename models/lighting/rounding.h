// Rounds the weights of a convolution so that its outputs change least. Rounding to nearest is best for each weight
// alone. For their sum it is better that each weight makes up for the errors of those before it, as far as their inputs
// vary together. With the inputs' covariance H = M D M^T, where M is unit upper triangular, the error e of a row of
// weights costs e H e^T = sum_k D_k ((e M)_k)^2. So weight k aims at w_k - sum_{j<k} e_j M_jk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sandglass::host {

// Sums of the inputs of observed windows, and of their products.
struct InputProducts {
  size_t inputs = 0;
  uint64_t count = 0;
  std::vector<double> sums;
  std::vector<float> products;  // inputs x inputs, lower triangle
  std::vector<float> waiting;   // samples that are not yet in the products

  void add(const float* values, size_t size);
  void flush();
};

// M for inputs divided by `units` (0: an input that does not count). `ridge` is added to every variance.
std::vector<float> triangular_factor(const InputProducts& products, const std::vector<double>& units, double ridge);

// Integers in -127..127 for `weights` in units of `scale`. If `factor` is empty, each is rounded to nearest.
std::vector<int8_t> rounded(const std::vector<double>& weights, double scale, const std::vector<float>& factor);

}  // namespace sandglass::host

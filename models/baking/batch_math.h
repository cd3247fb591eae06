// The arithmetic of training on a batch of samples: one body (batch_math.inl) over Eigen, compiled for the instruction
// sets that pay on a workstation. Results differ in the last digits between sets, as everything on the host side may;
// on one machine they depend on the arguments alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace sandglass::host {

// Floats that begin at a cache line. Eigen adds up in an order that depends on where an array begins, so every array of
// a batch must begin alike for sums to repeat to the bit.
template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  bool operator==(const LineAllocator&) const { return true; }
};
using Floats = std::vector<float, LineAllocator<float>>;

struct Batch {
  uint32_t inputs, width, layers, samples;  // layers after the first
  const float* parameters;                  // as in FloatNetwork
  const float* input;                       // inputs * samples, sample by sample
  // Quantisation-aware: the largest value of the activations after each of the 1 + layers ReLUs. They are rounded to
  // 1/255 of it and clipped at it; gradients pass as if they were not rounded. NULL: not quantised.
  const float* clips;
  float* scratch;  // batch_scratch() floats
};

// One step of Adam for the mean of several sums of gradients, added up in order.
struct AdamStep {
  const float* const* gradients;  // `lanes` of them
  uint32_t lanes;
  float per_sample;                  // factor of their sum
  float mean_scale, variance_scale;  // with the correction for the first steps; mean_scale with the rate too
  float mean_decay, variance_decay, epsilon;
  float *parameters, *mean, *variance;
};

struct BatchMath {
  // output[s] = network(sample s).
  void (*forward)(const Batch& batch, float* output);
  // Adds the gradient of sum_s weight_s (output_s - target_s)^2 to `gradient` and returns that sum.
  double (*gradient)(const Batch& batch, const float* target, const float* weight, float* gradient);
  // Parameters begin..end - 1.
  void (*adam)(const AdamStep& step, uint32_t begin, uint32_t end);
};

uint64_t batch_scratch(uint32_t width, uint32_t layers, uint32_t samples);

// The fastest that this CPU has.
const BatchMath& batch_math();

}  // namespace sandglass::host

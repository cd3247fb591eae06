// The arithmetic of training on a batch of samples. One body of code over Eigen (batch_math.inl) is compiled for each
// instruction set that pays on a workstation. Results differ in the last digits between instruction sets. On one
// machine they depend on the arguments alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace sandglass::host {

// Allocates arrays that begin at a cache line. Eigen's order of summation depends on where an array begins. So every
// array of a batch must begin alike, or sums would not repeat to the bit.
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
  // `layers` counts the hidden layers after the first.
  uint32_t inputs, width, layers, samples;
  const float* parameters;  // as in FloatNetwork
  const float* input;       // inputs * samples, sample by sample
  // For quantisation-aware training: one largest activation for each of the 1 + layers ReLUs. Activations are clipped
  // at this value and rounded to 1/255 of it. Gradients pass as if nothing were rounded. NULL: not quantised.
  const float* clips;
  float* scratch;  // batch_scratch() floats
};

// One step of Adam. Its gradient is the mean of several lanes' sums, which are added up in order.
struct AdamStep {
  const float* const* gradients;  // one array per lane
  uint32_t lanes;
  float per_sample;  // the factor that turns the sum into a mean
  // Both hold Adam's correction for the first steps. mean_scale also holds the learning rate.
  float mean_scale, variance_scale;
  float mean_decay, variance_decay, epsilon;
  float *parameters, *mean, *variance;
};

struct BatchMath {
  // output[s] = network(sample s).
  void (*forward)(const Batch& batch, float* output);
  // The loss is sum_s weight_s (output_s - target_s)^2. Adds its gradient to `gradient` and returns it.
  double (*gradient)(const Batch& batch, const float* target, const float* weight, float* gradient);
  // Updates the parameters begin..end - 1.
  void (*adam)(const AdamStep& step, uint32_t begin, uint32_t end);
};

// The number of floats that Batch::scratch needs.
uint64_t batch_scratch(uint32_t width, uint32_t layers, uint32_t samples);

// The fastest version that this CPU can run.
const BatchMath& batch_math();

}  // namespace sandglass::host

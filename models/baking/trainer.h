// Trains a shadow network with Adam on mini-batches. The result depends on the seed and not on the number of threads: a
// batch is split into a fixed number of lanes, each lane adds up its samples in order, and the lanes are added up in
// order.
//
// Samples are denser in the penumbra: half of them are drawn evenly from all texels, the other half from the penumbra.
// A sample's weight is the inverse of the density that it was drawn with. So the expected loss is still the mean
// squared error over all texels, (6.21) of the dissertation. Only its noise is smaller.
#pragma once

#include <cstdint>
#include <vector>

#include "models/baking/network.h"
#include "models/baking/training_set.h"

namespace sandglass::host {

struct TrainingPlan {
  // The learning rate follows half a cosine from `rate` to `rate_end`.
  uint32_t float_steps = 0;
  // These steps follow. They use rounded weights and activations. Their rate falls from `rate_quantised` to `rate_end`.
  uint32_t quantised_steps = 0;
  uint32_t batch = 8192;
  double rate = 3e-3, rate_end = 1e-5, rate_quantised = 2e-4;
  double penumbra_share = 0.5;
  uint64_t seed = 1;
};

struct TrainingState {
  uint32_t step = 0;
  FloatNetwork network;   // the network in training
  Floats mean, variance;  // Adam's running averages
  // A copy of the network from the moment when the float steps ended; empty before.
  FloatNetwork float_network;
  // The largest activation of each ReLU layer, for quantisation; empty until the float steps end.
  std::vector<float> clips;
  double loss = 0;  // running mean
};

class Trainer {
 public:
  Trainer(const TrainingSet& set, const TrainingPlan& plan, ThreadPool& pool);
  ~Trainer();
  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

  void step(TrainingState* state);
  bool finished(const TrainingState& state) const { return state.step >= plan_.float_steps + plan_.quantised_steps; }

 private:
  struct Work;
  void begin_quantisation(TrainingState* state);

  const TrainingSet& set_;
  TrainingPlan plan_;
  ThreadPool& pool_;
  std::unique_ptr<Work> work_;
};

TrainingState start_training(const NetworkShape& shape, uint64_t seed);

// Rounds the weights to 255 steps per output, as the runtime stores them. The step of an output is its largest
// magnitude / 127. The first layer stays as it is, since the runtime keeps it as tables of 16 bits.
void round_weights(const FloatNetwork& network, float* rounded);

// A bound for the activations of each ReLU layer. The share `beyond` of the activations lies above it and is clipped.
std::vector<float> activation_clips(const FloatNetwork& network, const Floats& input, uint32_t samples, double beyond);

}  // namespace sandglass::host

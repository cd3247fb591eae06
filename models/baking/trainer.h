// Adam on mini-batches, deterministic for a seed on any number of threads: a batch is split into a fixed number of
// lanes, each lane adds up its samples in order, and the lanes are added up in order.
//
// Samples are denser where the penumbra is: one half is drawn evenly from all texels, the other from the penumbra.
// Each counts with the inverse of the density that it was drawn with, so the expected loss is that of all texels
// equally, the mean squared error (6.21); only its noise is smaller.
#pragma once

#include <cstdint>
#include <vector>

#include "models/baking/network.h"
#include "models/baking/training_set.h"

namespace sandglass::host {

struct TrainingPlan {
  uint32_t float_steps = 0;      // learning rate: half a cosine from `rate` to `rate_end`
  uint32_t quantised_steps = 0;  // after them: with rounded weights and activations, from rate_quantised downward
  uint32_t batch = 8192;
  double rate = 3e-3, rate_end = 1e-5, rate_quantised = 2e-4;
  double penumbra_share = 0.5;
  uint64_t seed = 1;
};

// All that has to be kept to go on.
struct TrainingState {
  uint32_t step = 0;
  FloatNetwork network;        // what is being trained
  Floats mean, variance;       // Adam's
  FloatNetwork float_network;  // as it was when the float steps ended; empty before
  std::vector<float> clips;    // largest activations for quantisation, one a ReLU layer; empty before
  double loss = 0;             // running mean
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

// Weights rounded to 255 steps per output, as the runtime stores them: scale of an output = largest magnitude / 127.
// The first layer stays as it is (the runtime keeps it as tables of 16 bits).
void round_weights(const FloatNetwork& network, float* rounded);

// The largest activation of each ReLU layer, apart from a share of `beyond` that is clipped.
std::vector<float> activation_clips(const FloatNetwork& network, const Floats& input, uint32_t samples, double beyond);

}  // namespace sandglass::host

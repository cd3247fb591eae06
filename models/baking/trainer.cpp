// See trainer.h.
#include "models/baking/trainer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "models/baking/batch_math.h"
#include "models/work/random.h"

namespace sandglass::host {

namespace {

// A batch is split into lanes, which the threads share. Their number is fixed, so that the order of every sum is fixed.
constexpr uint32_t k_lanes = 8;
constexpr uint32_t k_chunk = 256;  // the activations of this many samples fit into the second-level cache
constexpr float k_mean_decay = 0.9f, k_variance_decay = 0.99f, k_epsilon = 1e-8f;
constexpr double k_beyond = 1e-3;       // the share of activations that is clipped
constexpr uint32_t k_probe = 16384;     // the clips are measured on this many samples, a multiple of k_chunk
constexpr double k_loss_decay = 0.998;  // decay of the running mean of the loss

}  // namespace

struct Trainer::Work {
  std::vector<float> positions;    // encoded texel coordinates, one row per index
  std::vector<float> lights;       // encoded lights
  uint32_t step = 0, samples = 0;  // samples of one lane
  const float* parameters = nullptr;
  const float* clips = nullptr;
  NetworkShape shape;
  Floats rounded;
  Floats gradients[k_lanes];
  Floats input[k_lanes], target[k_lanes], weight[k_lanes], scratch[k_lanes];
  double loss[k_lanes] = {};
  const Trainer* trainer = nullptr;

  void draw(uint32_t step_number, uint32_t first, uint32_t count, float* in, float* nu, float* share) const;
  void run_lane(uint32_t lane);
};

Trainer::Trainer(const TrainingSet& set, const TrainingPlan& plan, ThreadPool& pool)
    : set_(set), plan_(plan), pool_(pool), work_(std::make_unique<Work>()) {
  Work& w = *work_;
  w.trainer = this;
  w.positions.resize(size_t{set.size} * k_texel_inputs);
  for (uint32_t i = 0; i < set.size; ++i)
    encode(texel_centre(i, set.size), k_texel_frequencies, &w.positions[i * k_texel_inputs]);
  w.lights.resize(set.lights.size() * 3 * k_light_inputs);
  for (size_t i = 0; i < set.lights.size(); ++i) encode_light(set.lights[i], &w.lights[i * 3 * k_light_inputs]);
  w.samples = plan.batch / k_lanes;
}

Trainer::~Trainer() = default;

// Draws the samples first..first + count - 1 of a step. Each sample picks its texel by its own random number. Texels
// lie all over memory, so the indices come first and all of them are prefetched together.
void Trainer::Work::draw(uint32_t step_number, uint32_t first, uint32_t count, float* in, float* nu,
                         float* share) const {
  const TrainingSet& set = trainer->set_;
  const uint64_t all = set.values.size(), edge = set.penumbra.size();
  const double part = edge == 0 ? 0 : trainer->plan_.penumbra_share;
  const double denser = edge == 0 ? 0 : part * static_cast<double>(all) / static_cast<double>(edge);
  const float in_edge = static_cast<float>(1 / (1 - part + denser));
  const float elsewhere = static_cast<float>(1 / (1 - part));
  uint64_t index[k_chunk];
  bool from_edge[k_chunk];
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t counter = random_mix(trainer->plan_.seed) + (uint64_t{step_number} << 32) + first + i;
    const uint64_t random = random_mix(counter);
    from_edge[i] = random_unit(random + 2) < part;
    index[i] = static_cast<uint64_t>(random_unit(random + 1) * static_cast<double>(from_edge[i] ? edge : all));
    if (from_edge[i]) __builtin_prefetch(&set.penumbra[index[i]]);
  }
  for (uint32_t i = 0; i < count; ++i) {
    if (from_edge[i]) index[i] = set.penumbra[index[i]];
    __builtin_prefetch(&set.values[index[i]]);
    const float* light = &lights[size_t{set.texel(index[i]).light} * 3 * k_light_inputs];
    __builtin_prefetch(light);
    __builtin_prefetch(light + 3 * k_light_inputs - 1);
  }
  for (uint32_t i = 0; i < count; ++i) {
    share[i] = set.in_penumbra[index[i]] ? in_edge : elsewhere;
    nu[i] = static_cast<float>(set.transparency(index[i]));
    const TrainingSet::Texel texel = set.texel(index[i]);
    float* x = in + size_t{i} * k_inputs;
    std::memcpy(x, &positions[size_t{texel.u} * k_texel_inputs], k_texel_inputs * sizeof *x);
    std::memcpy(x + k_texel_inputs, &positions[size_t{texel.v} * k_texel_inputs], k_texel_inputs * sizeof *x);
    std::memcpy(x + 2 * k_texel_inputs, &lights[size_t{texel.light} * 3 * k_light_inputs],
                3 * k_light_inputs * sizeof *x);
  }
}

void Trainer::Work::run_lane(uint32_t lane) {
  gradients[lane].assign(shape.parameters(), 0.0f);
  input[lane].resize(size_t{k_chunk} * k_inputs);
  target[lane].resize(k_chunk);
  weight[lane].resize(k_chunk);
  scratch[lane].resize(batch_scratch(shape.width, shape.layers, k_chunk));
  loss[lane] = 0;
  for (uint32_t done = 0; done < samples; done += k_chunk) {
    const uint32_t count = std::min(k_chunk, samples - done);
    draw(step, lane * samples + done, count, input[lane].data(), target[lane].data(), weight[lane].data());
    const Batch batch = {k_inputs,   shape.width,        shape.layers, count,
                         parameters, input[lane].data(), clips,        scratch[lane].data()};
    loss[lane] += batch_math().gradient(batch, target[lane].data(), weight[lane].data(), gradients[lane].data());
  }
}

void Trainer::begin_quantisation(TrainingState* state) {
  state->float_network = state->network;
  Floats input(size_t{k_probe} * k_inputs), ignored(2 * size_t{k_chunk});
  for (uint32_t done = 0; done < k_probe; done += k_chunk)
    work_->draw(~0u, done, k_chunk, &input[size_t{done} * k_inputs], ignored.data(), ignored.data() + k_chunk);
  state->clips = activation_clips(state->network, input, k_probe, k_beyond);
  std::fill(state->mean.begin(), state->mean.end(), 0.0f);
  std::fill(state->variance.begin(), state->variance.end(), 0.0f);
}

void Trainer::step(TrainingState* state) {
  Work& w = *work_;
  const bool quantised = state->step >= plan_.float_steps;
  if (quantised && state->clips.empty()) begin_quantisation(state);
  w.shape = state->network.shape;
  w.step = state->step;
  w.parameters = state->network.parameters.data();
  w.clips = nullptr;
  if (quantised) {
    w.rounded.resize(w.shape.parameters());
    round_weights(state->network, w.rounded.data());
    w.parameters = w.rounded.data();
    w.clips = state->clips.data();
  }
  pool_.run(k_lanes, [&](uint32_t lane) { w.run_lane(lane); });

  const uint32_t first = quantised ? plan_.float_steps : 0;
  const uint32_t count = quantised ? plan_.quantised_steps : plan_.float_steps;
  const double start = quantised ? plan_.rate_quantised : plan_.rate;
  const double progress = static_cast<double>(state->step - first) / count;
  const double rate = plan_.rate_end + (start - plan_.rate_end) * 0.5 * (1 + std::cos(k_pi * progress));
  const double age = state->step - first + 1;
  const float mean_scale = static_cast<float>(rate / (1 - std::pow(static_cast<double>(k_mean_decay), age)));
  const float variance_scale = static_cast<float>(1 / (1 - std::pow(static_cast<double>(k_variance_decay), age)));
  const float per_sample = 1.0f / static_cast<float>(k_lanes * w.samples);
  const float* gradients[k_lanes];
  for (uint32_t lane = 0; lane < k_lanes; ++lane) gradients[lane] = w.gradients[lane].data();
  const AdamStep adam = {gradients,
                         k_lanes,
                         per_sample,
                         mean_scale,
                         variance_scale,
                         k_mean_decay,
                         k_variance_decay,
                         k_epsilon,
                         state->network.parameters.data(),
                         state->mean.data(),
                         state->variance.data()};
  pool_.run(k_lanes, [&](uint32_t lane) {
    const uint32_t all = w.shape.parameters();
    batch_math().adam(adam, all * lane / k_lanes, all * (lane + 1) / k_lanes);
  });
  double loss = 0;
  for (const double part : w.loss) loss += part;
  loss *= static_cast<double>(per_sample);
  state->loss = state->step == 0 ? loss : k_loss_decay * state->loss + (1 - k_loss_decay) * loss;
  ++state->step;
  if (!quantised && state->step == plan_.float_steps && plan_.quantised_steps == 0) begin_quantisation(state);
}

TrainingState start_training(const NetworkShape& shape, uint64_t seed) {
  TrainingState state;
  state.network = make_network(shape, seed);
  state.mean.assign(shape.parameters(), 0.0f);
  state.variance.assign(shape.parameters(), 0.0f);
  return state;
}

void round_weights(const FloatNetwork& network, float* rounded) {
  const NetworkShape& shape = network.shape;
  std::copy(network.parameters.begin(), network.parameters.end(), rounded);
  const auto round_layer = [&](const float* weights, uint32_t outputs) {
    float* out = rounded + (weights - network.parameters.data());
    for (uint32_t o = 0; o < outputs; ++o) {
      float largest = 0;
      for (uint32_t i = 0; i < shape.width; ++i) largest = std::max(largest, std::fabs(weights[i * outputs + o]));
      if (!(largest > 0)) continue;
      const float scale = largest / 127.0f, inverse = 127.0f / largest;
      for (uint32_t i = 0; i < shape.width; ++i)
        out[i * outputs + o] = std::nearbyint(weights[i * outputs + o] * inverse) * scale;
    }
  };
  for (uint32_t layer = 0; layer < shape.layers; ++layer) round_layer(network.weights(layer), shape.width);
  round_layer(network.last_weights(), 1);
}

std::vector<float> activation_clips(const FloatNetwork& network, const Floats& input, uint32_t samples, double beyond) {
  const NetworkShape& shape = network.shape;
  Floats scratch(batch_scratch(shape.width, shape.layers, samples)), output(samples);
  std::vector<float> clips;
  const Batch batch = {k_inputs,     shape.width, shape.layers,  samples, network.parameters.data(),
                       input.data(), nullptr,     scratch.data()};
  batch_math().forward(batch, output.data());
  const size_t count = size_t{shape.width} * samples;
  for (uint32_t layer = 0; layer <= shape.layers; ++layer) {
    std::vector<float> values(scratch.begin() + static_cast<long>(layer * count),
                              scratch.begin() + static_cast<long>((layer + 1) * count));
    const size_t rank = count - 1 - static_cast<size_t>(beyond * static_cast<double>(count));
    std::nth_element(values.begin(), values.begin() + static_cast<long>(rank), values.end());
    clips.push_back(std::max(values[rank], 1e-6f));  // at least a little, for a layer that is always 0
  }
  return clips;
}

}  // namespace sandglass::host

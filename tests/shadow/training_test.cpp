// Training: gradients against differences, lights that are not trained on, and a small object that is learnt.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/baking/batch_math.h"
#include "models/baking/shadow_file.h"
#include "models/baking/shadow_runner.h"
#include "models/baking/trainer.h"
#include "models/baking/validate.h"
#include "models/mesh/generated.h"
#include "models/work/random.h"

namespace {

using namespace sandglass;
using namespace sandglass::host;

constexpr double k_degree = k_pi / 180;

struct Ball {
  LightGeometry geometry;
  TrainingSet set;
  std::unique_ptr<ShadowCaster> caster;

  Ball() {
    geometry.object = stand_on_plane(make_icosphere(0.1f, 3), "ball");
    geometry.half_angle = 10 * k_degree;
    geometry.polar_max = 40 * k_degree;
    caster = std::make_unique<ShadowCaster>(geometry.object.mesh, geometry.half_angle, SampleCounts{2, 4}, 1);
    set.size = k_native_size;
    set.stride = 8;
    set.lights = ring_directions(geometry.polar_max, 200);
    ThreadPool pool(2);
    trace_training_set(
        geometry, *caster, pool, [](uint32_t) { return true; }, &set);
  }
};

const Ball& ball() {
  static const Ball instance;
  return instance;
}

TEST(ShadowTraining, GradientIsTheSlopeOfTheLoss) {
  constexpr uint32_t k_samples = 24, k_width = 8, k_layers = 2;
  const NetworkShape shape = {k_width, k_layers};
  FloatNetwork network = make_network(shape, 3);
  for (size_t i = 0; i < network.parameters.size(); ++i)
    network.parameters[i] += static_cast<float>(0.05 * random_unit(i));
  Floats input(k_samples * k_inputs), target(k_samples), weight(k_samples);
  Floats scratch(batch_scratch(k_width, k_layers, k_samples));
  for (size_t i = 0; i < input.size(); ++i) input[i] = static_cast<float>(2 * random_unit(900 + i) - 1);
  for (size_t i = 0; i < k_samples; ++i) {
    target[i] = static_cast<float>(random_unit(i));
    weight[i] = static_cast<float>(0.5 + random_unit(i + 99));
  }
  Floats gradient(shape.parameters()), ignored(shape.parameters());
  const auto loss = [&](Floats* into) {
    const Batch batch = {k_inputs,     k_width, k_layers,      k_samples, network.parameters.data(),
                         input.data(), nullptr, scratch.data()};
    std::fill(into->begin(), into->end(), 0.0f);
    return batch_math().gradient(batch, target.data(), weight.data(), into->data());
  };
  loss(&gradient);
  double difference = 0, length = 0;
  for (size_t i = 0; i < gradient.size(); i += 7) {
    const float kept = network.parameters[i], step = 5e-4f;
    network.parameters[i] = kept + step;
    const double up = loss(&ignored);
    network.parameters[i] = kept - step;
    const double down = loss(&ignored);
    network.parameters[i] = kept;
    const double slope = (up - down) / (2 * static_cast<double>(step));
    difference += std::pow(slope - static_cast<double>(gradient[i]), 2);
    length += slope * slope;
  }
  EXPECT_LT(std::sqrt(difference), 0.02 * std::sqrt(length));
}

// This holds for any two counts, also for equal ones. The spacing of n points is the side of the square that each one
// has.
TEST(ShadowTraining, NoUnseenLightIsATrainedOne) {
  const double polar_max = 70 * k_pi / 180, area = 2 * k_pi * (1 - std::cos(polar_max));
  const auto nearest = [](const std::vector<Direction>& lights, const std::vector<Direction>& trained) {
    double closest = 4;
    for (const Direction& a : lights)
      for (const Direction& b : trained) closest = std::min(closest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    return closest;
  };
  constexpr std::pair<uint32_t, uint32_t> k_counts[] = {{16, 16},     {960, 960},  {4816, 4816},
                                                        {4816, 1000}, {4816, 301}, {16, 1000}};
  for (const auto& [trained, unseen] : k_counts) {
    const std::vector<Direction> ring = ring_directions(polar_max, trained);
    const std::vector<Direction> lights = unseen_directions(polar_max, unseen);
    ASSERT_EQ(lights.size(), unseen);
    EXPECT_GT(nearest(lights, ring), 1e-3 * std::sqrt(area / trained)) << trained << " trained, " << unseen;
    EXPECT_NEAR(lights.back()[1], ring_directions(polar_max, unseen).back()[1], 1e-12);
  }
  // The control: two equal rings.
  EXPECT_EQ(nearest(ring_directions(polar_max, 960), ring_directions(polar_max, 960)), 0);
}

TEST(ShadowTraining, LearnsABallAndTheBytesFollow) {
  TrainingPlan plan;
  plan.float_steps = 3000;
  plan.quantised_steps = 500;
  plan.batch = 1024;
  ThreadPool pool(2);
  Trainer trainer(ball().set, plan, pool);
  TrainingState state = start_training({32, 2}, plan.seed);
  while (!trainer.finished(state)) trainer.step(&state);
  ShadowFile file = {"ball", ball().geometry, quantise(state.network, state.clips), 0, 0, 0, 1, {}};
  const std::vector<uint8_t> bytes = shadow_file_bytes(file);
  ShadowRunner full(bytes, "ball", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_FULL);
  ShadowRunner adaptive(bytes, "ball", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  double float_error = 0, byte_error = 0, adaptive_error = 0, rounding = 0;
  size_t count = 0;
  for (const Direction& light : ring_directions(ball().geometry.polar_max, 7)) {
    const std::vector<float> truth =
        ball().caster->texture(ball().geometry.rectangle(light), light, 999, k_native_size, pool);
    const std::vector<float> network = evaluate(state.float_network, light, k_native_size, pool);
    const uint8_t *f = full.texture(light).bytes, *a = adaptive.texture(light).bytes;
    for (size_t i = 0; i < truth.size(); ++i, ++count) {
      const double t = static_cast<double>(truth[i]);
      float_error += std::pow(static_cast<double>(network[i]) - t, 2);
      byte_error += std::pow(1 - f[i] / 255.0 - t, 2);
      adaptive_error += std::pow(1 - a[i] / 255.0 - t, 2);
      rounding += std::pow((f[i] - a[i]) / 255.0, 2);
    }
  }
  const double n = static_cast<double>(count);
  const double float_rmse = std::sqrt(float_error / n), byte_rmse = std::sqrt(byte_error / n);
  EXPECT_LT(float_rmse, 0.03);
  // Bytes may add 0.003 to the error of the float network, and the adaptive grid 0.002 to that of the bytes.
  EXPECT_LT(byte_rmse, float_rmse + 0.003);
  EXPECT_LT(std::sqrt(adaptive_error / n), byte_rmse + 0.002);
  EXPECT_LT(std::sqrt(rounding / n), 0.01);
}

}  // namespace

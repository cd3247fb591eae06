#include "models/lighting/light_net.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/simulation/metrics.h"

namespace sandglass::host {

namespace {

constexpr float k_epsilon = 1e-5f;  // the epsilon of the batch normalisation behind the latent layer

// A number from the file, or `otherwise` if the file does not have it.
double number(const Arrays& arrays, const std::string& name, double otherwise) {
  const auto found = arrays.find(name);
  return found == arrays.end() || found->second.values.empty() ? otherwise
                                                               : static_cast<double>(found->second.values[0]);
}

}  // namespace

LightNet light_net_of(const Arrays& arrays) {
  LightNet net;
  net.trunk = densenet_of(arrays);
  net.latent = array_of(arrays, "latent/kernel", {k_features, k_latent});
  net.latent_bias = array_of(arrays, "latent/bias", {k_latent});
  const auto& gamma = array_of(arrays, "latent/bn/gamma", {k_latent});
  const auto& beta = array_of(arrays, "latent/bn/beta", {k_latent});
  const auto& mean = array_of(arrays, "latent/bn/moving_mean", {k_latent});
  const auto& variance = array_of(arrays, "latent/bn/moving_variance", {k_latent});
  for (size_t o = 0; o < k_latent; ++o) {
    const float scale = gamma[o] / std::sqrt(variance[o] + k_epsilon);
    for (size_t i = 0; i < k_features; ++i) net.latent[i * k_latent + o] *= scale;
    net.latent_bias[o] = (net.latent_bias[o] - mean[o]) * scale + beta[o];
  }
  net.heads.resize(size_t{k_latent} * k_heads);
  size_t to = 0;
  for (const auto& [name, outputs] :
       {std::pair<const char*, size_t>{"direction", 3}, {"light", 3}, {"ambient", 3}, {"contrast", 1}}) {
    const auto& kernel = array_of(arrays, std::string(name) + "/kernel", {k_latent, outputs});
    const auto& bias = array_of(arrays, std::string(name) + "/bias", {outputs});
    for (size_t o = 0; o < outputs; ++o, ++to) {
      for (size_t i = 0; i < k_latent; ++i) net.heads[i * k_heads + to] = kernel[i * outputs + o];
      net.heads_bias.push_back(bias[o]);
    }
  }
  net.seed = static_cast<uint64_t>(number(arrays, "seed", 0));
  net.training_images = static_cast<uint32_t>(number(arrays, "training_images", 0));
  if (const auto hash = arrays.find("data_hash"); hash != arrays.end())
    for (size_t i = 0; i < hash->second.values.size() && i < 16; ++i) {
      const int c = static_cast<int>(hash->second.values[i]);  // a hexadecimal digit
      net.data_hash = net.data_hash << 4 | static_cast<uint64_t>(c >= 'a' ? c - 'a' + 10 : c - '0') % 16;
    }
  return net;
}

LightValues light_of(const LightNet& net, std::span<const float> features) {
  std::vector<float> latent = net.latent_bias;
  for (size_t i = 0; i < k_features; ++i)
    for (size_t o = 0; o < k_latent; ++o) latent[o] += features[i] * net.latent[i * k_latent + o];
  LightValues values;
  for (size_t o = 0; o < k_heads; ++o) {
    float sum = net.heads_bias[o];
    for (size_t i = 0; i < k_latent; ++i)
      sum += net.heads[i * k_heads + o] * (latent[i] > 0 ? latent[i] : std::expm1(latent[i]));
    values[o] = o < 3 ? std::tanh(sum) : 1 / (1 + std::exp(-sum));
  }
  const float length = std::sqrt(values[0] * values[0] + values[1] * values[1] + values[2] * values[2]);
  for (size_t axis = 0; axis < 3; ++axis) values[axis] /= std::max(length, 1e-12f);
  return values;
}

LightDifference median_difference(std::span<const LightValues> a, std::span<const LightValues> b) {
  std::vector<double> angles, others;
  for (size_t k = 0; k < a.size(); ++k) {
    double dot = 0, lengths[2] = {}, most = 0;
    for (size_t i = 0; i < 3; ++i) {
      const double x = static_cast<double>(a[k][i]), y = static_cast<double>(b[k][i]);
      dot += x * y, lengths[0] += x * x, lengths[1] += y * y;
    }
    for (size_t i = 3; i < a[k].size(); ++i) most = std::max(most, static_cast<double>(std::fabs(a[k][i] - b[k][i])));
    angles.push_back(std::acos(std::clamp(dot / std::sqrt(lengths[0] * lengths[1]), -1.0, 1.0)) * 180 /
                     std::numbers::pi);
    others.push_back(most);
  }
  return {quantile(angles, 0.5), quantile(others, 0.5)};
}

}  // namespace sandglass::host

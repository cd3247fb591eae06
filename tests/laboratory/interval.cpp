#include "tests/laboratory/interval.h"

#include <map>
#include <numeric>

#include "models/simulation/metrics.h"
#include "runtime/math/random.h"

namespace sandglass::host {

std::vector<double> place_means(const std::vector<std::pair<std::string, double>>& values_by_place) {
  std::map<std::string, std::pair<double, double>> sums;
  for (const auto& [place, value] : values_by_place) {
    sums[place].first += value;
    sums[place].second += 1.0;
  }
  std::vector<double> means;
  for (const auto& [place, sum] : sums) means.push_back(sum.first / sum.second);
  return means;
}

Interval interval_of(const std::vector<double>& place_values, uint64_t seed) {
  constexpr int k_resamples = 10000;
  constexpr uint64_t k_stream = 41;
  if (place_values.empty()) return {};
  const auto places = static_cast<uint32_t>(place_values.size());
  Random random = random_stream(seed, k_stream);
  std::vector<double> means(k_resamples);
  for (double& mean : means) {
    for (uint32_t i = 0; i < places; ++i) mean += place_values[random.below(places)];
    mean /= places;
  }
  const double sum = std::accumulate(place_values.begin(), place_values.end(), 0.0);
  return {sum / places, quantile(means, 0.025), quantile(means, 0.975)};
}

}  // namespace sandglass::host

// The mean of a measure over places, and how far it can be trusted. Views of one place are not independent, so each
// place counts once, whatever its number of views.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace sandglass::host {

struct Interval {
  double mean = 0.0, low = 0.0, high = 0.0;  // 95 %
};

// The mean of each place, in the order of their names.
std::vector<double> place_means(const std::vector<std::pair<std::string, double>>& values_by_place);

// Resamples places with replacement. All are 0 where there is none.
Interval interval_of(const std::vector<double>& place_values, uint64_t seed = 1);

}  // namespace sandglass::host

// Points spread through a box, without a random number generator: an additive recurrence.
#pragma once

#include <cmath>

template <class Visit>
void for_points(const float low[3], const float high[3], int count, const Visit& visit) {
  const double step[3] = {0.8191725134, 0.6710436067, 0.5497004779};
  for (int i = 1; i <= count; ++i) {
    float p[3];
    for (int k = 0; k < 3; ++k) {
      const double t = step[k] * i - std::floor(step[k] * i);
      p[k] = static_cast<float>(static_cast<double>(low[k]) + t * static_cast<double>(high[k] - low[k]));
    }
    visit(p);
  }
}

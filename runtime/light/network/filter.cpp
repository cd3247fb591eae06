#include "runtime/light/network/filter.h"

#include "runtime/light/luminance.h"
#include "runtime/math/math.h"

namespace sandglass {

namespace {

constexpr double k_longest_gap = 1.0;      // seconds; a longer gap between estimates counts as this
constexpr uint32_t k_patience = 3;         // so many outliers in a row are believed
constexpr double k_same_direction = 1e-9;  // length of a difference below which there is nothing to turn

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double normalise(double v[3]) {
  const double length = square_root(dot(v, v));
  if (length > 0.0)
    for (int i = 0; i < 3; ++i) v[i] /= length;
  return length;
}

bool contradicts(const LightFilterLaw& law, const LightSample& a, const LightSample& b) {
  const double light = luminance(a.levels + k_sample_light) - luminance(b.levels + k_sample_light);
  const double ambient = luminance(a.levels + k_sample_ambient) - luminance(b.levels + k_sample_ambient);
  return angle_between(a.direction, b.direction) > law.outlier_angle || absolute(light) > law.outlier_level ||
         absolute(ambient) > law.outlier_level;
}

double seconds_since(const LightFilter& filter, uint64_t time_ns) {
  if (time_ns <= filter.time_ns) return filter.law.interval;
  const double gap = static_cast<double>(time_ns - filter.time_ns) * 1e-9;
  return gap < k_longest_gap ? gap : k_longest_gap;
}

// Whether the sample is believed. One that contradicts the state is remembered.
bool believed(LightFilter* filter, const LightSample& sample) {
  if (!contradicts(filter->law, sample, filter->state)) {
    filter->outliers_in_a_row = 0;
    return true;
  }
  const bool agrees = filter->outliers_in_a_row > 0 && !contradicts(filter->law, sample, filter->outlier);
  const bool take = agrees || filter->outliers_in_a_row + 1 >= k_patience;
  filter->outlier = sample;
  filter->outliers_in_a_row = take ? 1 : filter->outliers_in_a_row + 1;  // what follows this change agrees with it
  if (!take) ++filter->rejected;
  return take;
}

void move_state(LightFilter* filter, const LightSample& sample, double part, double turn_max) {
  const double angle = part * angle_between(filter->state.direction, sample.direction);
  double moved[3];
  turn_towards(filter->state.direction, sample.direction, angle < turn_max ? angle : turn_max, moved);
  for (int i = 0; i < 3; ++i) filter->state.direction[i] = moved[i];
  for (uint32_t i = 0; i < k_sample_levels; ++i)
    filter->state.levels[i] += part * (sample.levels[i] - filter->state.levels[i]);
}

}  // namespace

double angle_between(const double a[3], const double b[3]) {
  const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return arc_tangent2(square_root(dot(cross, cross)), dot(a, b));
}

void turn_towards(const double from[3], const double to[3], double angle, double out[3]) {
  const double along = dot(from, to);
  double side[3];
  for (int i = 0; i < 3; ++i) side[i] = to[i] - along * from[i];
  if (square_root(dot(side, side)) < k_same_direction) {
    for (int i = 0; i < 3; ++i) side[i] = 0.0;
    if (along < 0.0) {
      // Opposite: towards the axis that `from` is farthest from.
      int axis = 0;
      for (int i = 1; i < 3; ++i)
        if (absolute(from[i]) < absolute(from[axis])) axis = i;
      for (int i = 0; i < 3; ++i) side[i] = (i == axis ? 1.0 : 0.0) - from[axis] * from[i];
    }
  }
  normalise(side);
  const SinCos turn = sin_cos_turns(angle / (2.0 * k_pi));
  for (int i = 0; i < 3; ++i) out[i] = turn.cos * from[i] + turn.sin * side[i];
  normalise(out);
}

void light_filter_reset(LightFilter* filter) {
  const LightFilterLaw law = filter->law;
  *filter = {};
  filter->law = law;
  filter->state.direction[1] = filter->outlier.direction[1] = 1.0;
}

bool light_filter_take(LightFilter* filter, const LightSample& sample, uint64_t time_ns) {
  const LightFilterLaw& law = filter->law;
  const double gap = seconds_since(*filter, time_ns);
  filter->time_ns = time_ns;
  if (filter->accepted == 0 || !(law.smoothing > 0.0)) {
    filter->agreement = filter->accepted == 0 ? 1.0 : dot(sample.direction, filter->state.direction);
    filter->agreement = filter->agreement > 0.0 ? filter->agreement : 0.0;
    filter->state = sample;
    ++filter->accepted;
    return true;
  }
  const double smooth = gap / (law.smoothing + gap), mean = 1.0 / (filter->accepted + 1.0);
  const double part = smooth > mean ? smooth : mean;
  const double cosine = dot(sample.direction, filter->state.direction);
  filter->agreement += part * ((cosine > 0.0 ? cosine : 0.0) - filter->agreement);
  if (!believed(filter, sample)) return false;
  move_state(filter, sample, part, law.turn_limit * gap);
  ++filter->accepted;
  return true;
}

double light_filter_confidence(const LightFilter& filter) {
  const double n = filter.accepted + filter.rejected;
  return filter.agreement * (n / (n + 1.0));
}

void light_filter_turn(LightFilter* filter, const double rotation[3][3]) {
  LightSample* const samples[2] = {&filter->state, &filter->outlier};
  for (LightSample* sample : samples) {
    double turned[3];
    for (int i = 0; i < 3; ++i) turned[i] = dot(rotation[i], sample->direction);
    normalise(turned);
    for (int i = 0; i < 3; ++i) sample->direction[i] = turned[i];
  }
}

}  // namespace sandglass

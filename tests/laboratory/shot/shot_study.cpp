#include "tests/laboratory/shot/shot_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <sstream>

namespace sandglass::host {

const char* name_of(ShotVariant variant) {
  constexpr const char* k_names[k_shot_variants] = {"no shadow, mean light",
                                                    "ambient shadow alone, mean light",
                                                    "one light, by the network",
                                                    "a full turn",
                                                    "a full turn, some images short",
                                                    "the true light in cells",
                                                    "shadows of a full turn, true shading",
                                                    "true shadows, shading of a full turn",
                                                    "a full turn at the true level",
                                                    "control: a full turn, mirrored",
                                                    "control: a full turn in another room",
                                                    "one light, the true label",
                                                    "the same without its shadow",
                                                    "the same with a hard shadow",
                                                    "an arbitrary light",
                                                    "no shadow, mean light at the true level",
                                                    "ambient shadow alone, mean light at the true level"};
  return k_names[static_cast<int>(variant)];
}
const char* shot_metric_name(int metric) {
  constexpr const char* k_names[] = {"RMSE", "nRMSE", "siRMSE", "RMLE", "RGB deg", "1 - SSIM", "FLIP"};
  return k_names[metric];
}

std::vector<double> ShotStudy::by_place(ShotVariant variant, int metric) const {
  std::map<std::string, std::pair<double, int>> sums;
  for (const ShotView& view : views) {
    if (!view.done) continue;
    auto& [sum, count] = sums[view.place];
    sum += view.errors[static_cast<int>(variant)][metric], ++count;
  }
  std::vector<double> means;
  for (const auto& [place, sum] : sums) means.push_back(sum.first / sum.second);
  return means;
}

void take_means(ShotStudy* study) {
  study->has_network = false;
  for (const ShotView& view : study->views) study->has_network = study->has_network || (view.done && view.has_network);
  for (int v = 0; v < k_shot_variants; ++v)
    for (int m = 0; m < k_shot_metrics; ++m) {
      const std::vector<double> places = study->by_place(static_cast<ShotVariant>(v), m);
      double sum = 0.0;
      for (const double e : places) sum += e;
      study->mean[v][m] = places.empty() ? 0.0 : sum / static_cast<double>(places.size());
    }
}

namespace {

// The share of Student's distribution within t standard errors. The finite sums are Abramowitz and Stegun 26.7.3 for
// odd and 26.7.4 for even degrees of freedom.
double student_share(double t, int freedom) {
  const double angle = std::atan(t / std::sqrt(static_cast<double>(freedom))), c = std::cos(angle), s = std::sin(angle);
  const bool odd = freedom % 2 != 0;
  double term = odd ? c : 1.0, sum = freedom > 1 ? term : 0.0;
  for (int k = odd ? 2 : 1; k <= freedom - 3; k += 2) sum += term *= c * c * k / (k + 1);
  return odd ? 2.0 / 3.141592653589793 * (angle + s * sum) : s * sum;
}

}  // namespace

double student_95(int degrees_of_freedom) {
  if (degrees_of_freedom < 1) return std::numeric_limits<double>::infinity();
  double low = 1.0, high = 16.0;  // the result is 1.96 for infinitely many degrees of freedom and 12.7 for one
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (student_share(middle, degrees_of_freedom) < 0.95 ? low : high) = middle;
  }
  return low;
}

ShotStudy::Paired ShotStudy::against(ShotVariant first, ShotVariant second, int metric) const {
  std::vector<double> d = by_place(first, metric);
  const std::vector<double> other = by_place(second, metric);
  for (size_t i = 0; i < d.size(); ++i) d[i] -= other[i];
  double mean_of = 0.0, square = 0.0;
  const double n = static_cast<double>(d.size());
  for (const double x : d) mean_of += x / n;
  for (const double x : d) square += (x - mean_of) * (x - mean_of);
  const double student = student_95(static_cast<int>(d.size()) - 1);
  return {mean_of, n > 1 ? student * std::sqrt(square / (n - 1) / n) : student};
}

std::vector<Verdict> shot_verdicts(const ShotStudy& study) {
  constexpr int k_rmse = 0, k_similarity = 5, k_flip = 6;
  std::vector<Verdict> rows;
  const auto add = [&](ShotVariant first, ShotVariant second, int metric) {
    const ShotStudy::Paired p = study.against(first, second, metric);
    const double result = p.mean + p.half;
    rows.push_back({"whole picture",
                    std::string(name_of(first)) + " better than " + name_of(second) + ", " + shot_metric_name(metric),
                    "upper end", 0.0, result, 0.0, result < 0.0, false});
  };
  for (const ShotVariant v : {ShotVariant::turn, ShotVariant::truth})
    for (const int metric : {k_flip, k_similarity, k_rmse}) add(v, ShotVariant::no_shadow, metric);
  for (const int metric : {k_rmse, k_similarity}) add(ShotVariant::ambient_level, ShotVariant::no_shadow_level, metric);
  // What must lose: wrong lights against the right one.
  for (const ShotVariant control : {ShotVariant::mirrored, ShotVariant::other_room}) {
    const ShotStudy::Paired p = study.against(control, ShotVariant::turn, k_flip);
    rows.push_back({"whole picture", std::string(name_of(control)) + ", FLIP beyond a full turn's", "lower end", 0.0,
                    p.mean - p.half, 0.0, p.mean - p.half > 0.0, true});
  }
  return rows;
}

// Hash, azimuth, whether there is a network, angle, level, and all errors. The name comes last, because it may have
// spaces.
std::string line_of(const ShotView& view) {
  std::ostringstream text;
  text.precision(17);
  text << view.panorama_hash << ' ' << view.azimuth_deg << ' ' << view.has_network << ' ' << view.angle_deg << ' '
       << view.log_level;
  for (const auto& row : view.errors)
    for (const double e : row) text << ' ' << e;
  text << ' ' << view.panorama;
  return text.str() + "\n";
}

bool read_line(const std::string& line, ShotView* view) {
  std::istringstream text(line);
  text >> view->panorama_hash >> view->azimuth_deg >> view->has_network >> view->angle_deg >> view->log_level;
  for (auto& row : view->errors)
    for (double& e : row) text >> e;
  text.ignore(1);
  view->done = static_cast<bool>(std::getline(text, view->panorama));
  return view->done;
}

void remember(const std::string& text, const std::string& key, std::vector<ShotView>* views) {
  std::istringstream lines(text);
  std::string line;
  if (!std::getline(lines, line) || line != key) return;
  while (std::getline(lines, line)) {
    ShotView kept;
    if (!read_line(line, &kept)) continue;
    for (ShotView& view : *views)
      if (view.panorama_hash == kept.panorama_hash && view.azimuth_deg == kept.azimuth_deg) {
        const std::string name = view.panorama, place = view.place;
        view = kept, view.panorama = name, view.place = place;
      }
  }
}

std::string shot_study_text(const ShotStudy& study) {
  const size_t places = study.by_place(ShotVariant::truth, 0).size();
  char cell[96];
  const auto head = [&](const std::string& first, const auto& columns) {
    std::string text = "| " + first + " |", rule = "\n|---|";
    for (const std::string& column : columns) text += " " + column + " |", rule += "---|";
    return text + rule + "\n";
  };
  std::vector<std::string> metrics;
  for (int m = 0; m < k_shot_metrics; ++m) metrics.push_back(shot_metric_name(m));
  std::string text = head("mean of " + std::to_string(places) + " places", metrics);
  const auto shown = [&](ShotVariant v) {
    const bool needs_network = v == ShotVariant::one_light;
    return study.has_network || !needs_network;
  };
  for (int v = 0; v < k_shot_variants; ++v) {
    if (!shown(static_cast<ShotVariant>(v))) continue;
    text += std::string("| ") + name_of(static_cast<ShotVariant>(v)) + " |";
    for (int m = 0; m < k_shot_metrics; ++m) {
      std::snprintf(cell, sizeof cell, " %.4f |", study.mean[v][m]);
      text += cell;
    }
    text += "\n";
  }
  text += "\n" + head("difference, paired by place; below 0 the first is better", metrics);
  const auto against = [&](ShotVariant first, ShotVariant second) {
    if (!shown(first) || !shown(second)) return;
    text += std::string("| ") + name_of(first) + " - " + name_of(second) + " |";
    for (int m = 0; m < k_shot_metrics; ++m) {
      const ShotStudy::Paired p = study.against(first, second, m);
      std::snprintf(cell, sizeof cell, " %+.4f ± %.4f |", p.mean, p.half);
      text += cell;
    }
    text += "\n";
  };
  using V = ShotVariant;
  for (const V first : {V::ambient, V::one_light, V::turn, V::turn_short, V::truth}) against(first, V::no_shadow);
  for (const V first : {V::turn, V::turn_short, V::truth}) against(first, V::ambient);
  against(V::turn, V::one_light);
  for (const V first : {V::turn_shadow, V::turn_shading, V::turn_level, V::mirrored, V::other_room})
    against(first, V::turn);
  against(V::ambient_level, V::no_shadow_level);
  for (const V second : {V::label_no_shadow, V::label_hard, V::arbitrary}) against(V::label, second);
  double angle = 0.0, level = 0.0, bias = 0.0, count = 0.0;
  for (const ShotView& view : study.views) {
    if (!view.done) continue;
    angle += view.angle_deg, level += std::fabs(view.log_level), bias += view.log_level, count += 1.0;
  }
  std::snprintf(cell, sizeof cell, "\nA full turn: %.1f degrees off, |log level| %.2f, log level %+.2f.\n",
                angle / std::max(count, 1.0), level / std::max(count, 1.0), bias / std::max(count, 1.0));
  return text + cell;
}

namespace {

using PilePart = PileShadowError::Part;

constexpr PilePart PileShadowError::*k_pile_parts[] = {&PileShadowError::clear, &PileShadowError::among_grains,
                                                       &PileShadowError::on_sand};
// The first three limits are shares of the error that comes from leaving the shadow out (shot_study.h says why). The
// bias limit is a share of the light on the floor.
constexpr double k_pile_shares[] = {1.0 / 3.0, 1.0 / 3.0, 0.75}, k_pile_bias_limit = 0.05;

}  // namespace

PileShadowError whole_of(const std::vector<PileShadowError>& lights) {
  PileShadowError whole = {};
  for (const auto of : k_pile_parts) {
    PilePart& sum = whole.*of;
    for (const PileShadowError& e : lights) {
      const PilePart& part = e.*of;
      const auto add = [&](double PilePart::*rms) { sum.*rms += part.*rms * (part.*rms) * part.texels; };
      for (const auto rms : {&PilePart::rmse, &PilePart::without, &PilePart::particles, &PilePart::mirrored}) add(rms);
      sum.bias += part.bias * part.texels, sum.texels += part.texels;
    }
    const double n = std::max(1, sum.texels);
    for (const auto rms : {&PilePart::rmse, &PilePart::without, &PilePart::particles, &PilePart::mirrored})
      sum.*rms = std::sqrt(sum.*rms / n);
    sum.bias /= n;
  }
  return whole;
}

bool holds(const PileShadowError& whole) {
  for (size_t i = 0; i < 3; ++i) {
    const PilePart& part = whole.*k_pile_parts[i];
    const bool floor = k_pile_parts[i] != &PileShadowError::on_sand;
    if (part.texels == 0 || !(part.rmse <= k_pile_shares[i] * part.without) || !(part.rmse < part.mirrored))
      return false;
    if (floor && (!(part.rmse < part.particles) || !(std::fabs(part.bias) <= k_pile_bias_limit))) return false;
  }
  return true;
}

std::string pile_shadow_text(const std::vector<PileShadowError>& lights) {
  std::string text = "| light, from the zenith; azimuth |", rule = "\n|---|";
  for (const char* part : {"clear floor", "among grains", "on the sand"}) {
    text += std::string(" RMSE, ") + part + " | without | of particles | mirrored | bias | texels |";
    rule += "---|---|---|---|---|---|";
  }
  text += rule + "\n";
  char cell[120];
  const auto add = [&](const std::string& name, const PileShadowError& e) {
    text += "| " + name + " |";
    for (const auto of : k_pile_parts) {
      const PilePart& part = e.*of;
      std::snprintf(cell, sizeof cell, " %.4f | %.4f | %.4f | %.4f | %+.4f | %d |", part.rmse, part.without,
                    part.particles, part.mirrored, part.bias, part.texels);
      text += cell;
    }
    text += "\n";
  };
  for (const PileShadowError& e : lights) {
    std::snprintf(cell, sizeof cell, "%.0f; %.0f degrees", e.polar_deg, e.azimuth_deg);
    add(cell, e);
  }
  const PileShadowError whole = whole_of(lights);
  std::snprintf(cell, sizeof cell, "all; limits %.2f, %.2f, %.2f of without, bias %.2f: %s", k_pile_shares[0],
                k_pile_shares[1], k_pile_shares[2], k_pile_bias_limit, holds(whole) ? "holds" : "FAILS");
  add(cell, whole);
  return text;
}

}  // namespace sandglass::host

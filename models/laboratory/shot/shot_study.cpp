#include "models/laboratory/shot/shot_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

namespace sandglass::host {

const char* name_of(ShotVariant variant) {
  constexpr const char* k_names[] = {"true labels",     "no shadow",     "hard shadow",
                                     "arbitrary light", "no tone curve", "estimate"};
  return k_names[static_cast<int>(variant)];
}
const char* shot_metric_name(int metric) {
  constexpr const char* k_names[] = {"RMSE", "nRMSE", "siRMSE", "RMLE", "RGB deg", "1 - SSIM", "FLIP"};
  return k_names[metric];
}

void take_means(ShotStudy* study) {
  study->has_estimate = false;
  std::fill_n(&study->mean[0][0], k_shot_variants * k_shot_metrics, 0.0);
  double count = 0;
  for (const ShotView& view : study->views) count += view.done ? 1 : 0;
  for (const ShotView& view : study->views) {
    if (!view.done) continue;
    study->has_estimate = study->has_estimate || view.has_estimate;
    for (int v = 0; v < k_shot_variants; ++v)
      for (int m = 0; m < k_shot_metrics; ++m) study->mean[v][m] += view.errors[v][m] / count;
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

ShotStudy::Paired ShotStudy::paired(ShotVariant better, ShotVariant worse, int metric) const {
  std::vector<double> d;
  for (const ShotView& view : views)
    if (view.done)
      d.push_back(view.errors[static_cast<int>(worse)][metric] - view.errors[static_cast<int>(better)][metric]);
  double mean_of = 0.0, square = 0.0;
  const double n = static_cast<double>(d.size());
  for (const double x : d) mean_of += x / n;
  for (const double x : d) square += (x - mean_of) * (x - mean_of);
  const double student = student_95(static_cast<int>(d.size()) - 1);
  return {mean_of, n > 1 ? student * std::sqrt(square / (n - 1) / n) : student};
}

// Hash, azimuth, whether there is an estimate, its angle, and all errors. The name comes last, because it may have
// spaces.
std::string line_of(const ShotView& view) {
  std::ostringstream text;
  text.precision(17);
  text << view.panorama_hash << ' ' << view.azimuth_deg << ' ' << view.has_estimate << ' ' << view.angle_deg;
  for (const auto& row : view.errors)
    for (const double e : row) text << ' ' << e;
  text << ' ' << view.panorama;
  return text.str() + "\n";
}

bool read_line(const std::string& line, ShotView* view) {
  std::istringstream text(line);
  text >> view->panorama_hash >> view->azimuth_deg >> view->has_estimate >> view->angle_deg;
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
        const std::string name = view.panorama;
        view = kept, view.panorama = name;
      }
  }
}

std::string shot_study_text(const ShotStudy& study) {
  std::string text = "| mean of " + std::to_string(study.views.size()) + " views |";
  char cell[64];
  for (int m = 0; m < k_shot_metrics; ++m) text += std::string(" ") + shot_metric_name(m) + " |";
  text += "\n|---|---|---|---|---|---|---|---|\n";
  const auto variants = static_cast<int>(ShotVariant::estimate) + (study.has_estimate ? 1 : 0);
  for (int v = 0; v < variants; ++v) {
    text += std::string("| ") + name_of(static_cast<ShotVariant>(v)) + " |";
    for (int m = 0; m < k_shot_metrics; ++m) {
      std::snprintf(cell, sizeof cell, " %.4f |", study.mean[v][m]);
      text += cell;
    }
    text += "\n";
  }
  const auto against = [&](ShotVariant better, ShotVariant worse) {
    text += std::string("| ") + name_of(worse) + " - " + name_of(better) + ", paired |";
    for (int m = 0; m < k_shot_metrics; ++m) {
      const ShotStudy::Paired p = study.paired(better, worse, m);
      std::snprintf(cell, sizeof cell, " %+.4f ± %.4f |", p.mean, p.half);
      text += cell;
    }
    text += "\n";
  };
  for (const ShotVariant worse :
       {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light, ShotVariant::no_curve})
    against(ShotVariant::labels, worse);
  if (study.has_estimate) {
    against(ShotVariant::labels, ShotVariant::estimate);
    for (const ShotVariant worse : {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light})
      against(ShotVariant::estimate, worse);
    for (const ShotView& view : study.views)
      if (view.done && view.errors[static_cast<int>(ShotVariant::estimate)][0] >
                           view.errors[static_cast<int>(ShotVariant::arbitrary_light)][0]) {
        std::snprintf(cell, sizeof cell, "%.0f", view.angle_deg);
        text += "\nWorse than an arbitrary light: " + view.panorama + ", " + cell + " degrees off.";
      }
    text += "\n";
  }
  return text;
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

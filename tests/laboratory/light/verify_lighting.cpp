#include "tests/laboratory/light/verify_lighting.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/simulation/metrics.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/interval.h"

namespace sandglass::host {

namespace {

constexpr double k_bright_share = 0.9;  // share of the greatest luminance; images are clipped there
constexpr double k_any_contrast = 0.5;  // taken where no other place gives a contrast

constexpr const char* k_estimates_header =
    "image,direction_x,direction_y,direction_z,light_r,light_g,light_b,ambient_r,ambient_g,ambient_b,contrast";

enum Contender { k_estimate, k_mean, k_brightest, k_grey, k_mirrored, k_contenders };
constexpr const char* k_names[k_contenders] = {"estimate", "mean light", "brightest", "grey world",
                                               "mirrored estimate"};

struct JudgedView {
  Location location;
  std::string name;
  Picture image;
  LightLabels labels, lights[k_contenders];
};

Vec3 pixel_of(const Picture& image, int x, int y) {
  const uint8_t* p = image.at(x, y);
  return {linear_of(p[0]), linear_of(p[1]), linear_of(p[2])};
}

double difference(Vec3 a, Vec3 b) { return (std::fabs(a.x - b.x) + std::fabs(a.y - b.y) + std::fabs(a.z - b.z)) / 3.0; }

// What an estimate must show against a baseline. `must_win`: the interval of the difference lies below 0. If not, it
// lies below a tenth of the baseline's own error; an interval that only reaches 0 shows nothing.
constexpr double k_equivalent = 0.1;
struct Quantity {
  const char *name, *unit;
  double (*error)(const LightLabels& truth, const LightLabels& made);
  bool must_win;
};
constexpr Quantity k_quantities[] = {
    {"direction", "deg",
     [](const LightLabels& t, const LightLabels& m) {
       return std::atan2(length(cross(t.direction, m.direction)), dot(t.direction, m.direction)) * 180.0 /
              std::numbers::pi;
     },
     true},
    {"light colour", "", [](const LightLabels& t, const LightLabels& m) { return difference(t.light, m.light); },
     false},
    {"ambient colour", "", [](const LightLabels& t, const LightLabels& m) { return difference(t.ambient, m.ambient); },
     false},
    {"contrast", "", [](const LightLabels& t, const LightLabels& m) { return std::fabs(t.contrast - m.contrast); },
     false},
};

std::vector<double> errors_of(const std::vector<JudgedView>& views, const Quantity& quantity, Contender contender) {
  std::vector<double> errors;
  for (const JudgedView& view : views) errors.push_back(quantity.error(view.labels, view.lights[contender]));
  return errors;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// One contender's errors less another's, over places.
Interval paired(const std::vector<JudgedView>& views, const Quantity& quantity, Contender first, Contender second,
                uint64_t seed) {
  const std::vector<double> a = errors_of(views, quantity, first), b = errors_of(views, quantity, second);
  std::vector<std::pair<std::string, double>> differences;
  for (size_t i = 0; i < views.size(); ++i) differences.emplace_back(views[i].location.name, a[i] - b[i]);
  return interval_of(place_means(differences), seed);
}

// The mean of the labels of other places. If the place has a fold, only places of other folds count. Returns false if
// there are none.
bool mean_light(const std::vector<JudgedView>& all, const Location& location, LightLabels* mean) {
  *mean = {};
  size_t count = 0;
  for (const JudgedView& other : all) {
    if (other.location.name == location.name || (location.fold >= 0 && other.location.fold == location.fold)) continue;
    const LightLabels& l = other.labels;
    mean->direction = mean->direction + l.direction;
    mean->light = mean->light + l.light;
    mean->ambient = mean->ambient + l.ambient;
    mean->contrast += l.contrast;
    ++count;
  }
  if (count == 0 || length(mean->direction) <= 0.0) return false;
  const double share = 1.0 / static_cast<double>(count);
  mean->direction = normalised(mean->direction);
  mean->light = mean->light * share;
  mean->ambient = mean->ambient * share;
  mean->contrast *= share;
  mean->has_direction = true;
  return true;
}

std::vector<Verdict> judge(const std::vector<JudgedView>& views, bool with_mean, uint64_t seed) {
  constexpr double k_no_limit = std::numeric_limits<double>::infinity();
  std::vector<Verdict> rows;
  const auto report = [&](const std::string& name, const char* unit, double value) {
    rows.push_back({"lighting", name, unit, 0.0, value, k_no_limit, true, false});
  };
  for (const Contender c : {k_estimate, k_mean, k_brightest, k_grey}) {
    if (c == k_mean && !with_mean) continue;
    for (const Quantity& quantity : k_quantities) {
      const std::string name = std::string(k_names[c]) + ": " + quantity.name;
      std::vector<double> errors = errors_of(views, quantity, c);
      report(name + ", mean", quantity.unit, mean_of(errors));
      if (!quantity.must_win) continue;
      report(name + ", median", quantity.unit, quantile(errors, 0.5));
      report(name + ", 90 %", quantity.unit, quantile(errors, 0.9));
    }
  }
  for (const Contender baseline : {k_mean, k_brightest, k_grey}) {
    if (baseline == k_mean && !with_mean) continue;
    for (const Quantity& quantity : k_quantities) {
      const Interval d = paired(views, quantity, k_estimate, baseline, seed);
      const std::string name = std::string(quantity.name) + " against " + k_names[baseline];
      report(name + ", mean", quantity.unit, d.mean);
      report(name + ", 2.5 %", quantity.unit, d.low);
      const double limit = quantity.must_win ? 0.0 : k_equivalent * mean_of(errors_of(views, quantity, baseline));
      rows.push_back({"lighting", name + ", 97.5 %", quantity.unit, 0.0, d.high, limit, d.high < limit, false});
    }
  }
  const Interval mirror = paired(views, k_quantities[0], k_mirrored, k_estimate, seed);
  rows.push_back({"lighting", "control: mirrored, direction beyond the estimate's, 2.5 %", "deg", 0.0, mirror.low, 0.0,
                  mirror.low > 0.0, true});
  return rows;
}

}  // namespace

LightEstimator estimates_of_csv(const std::string& text, const std::string& path) {
  const std::string header = k_estimates_header;
  const auto table = std::make_shared<std::map<std::string, LightLabels>>();
  for (size_t at = 0, line = 1; at < text.size(); ++line) {
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string row = text.substr(at, end - at);
    at = end + 1;
    if (!row.empty() && row.back() == '\r') row.pop_back();
    if (row.empty() || row == header) continue;
    if (line == 1)
      throw cannot("read", path, "it does not begin with the line \"" + header + "\"", "Write it with train.py");
    const size_t comma = row.find(',');
    double v[10];
    const char* rest = comma == std::string::npos ? "" : row.c_str() + comma;
    bool whole = true;
    for (double& value : v) {
      char* after = nullptr;
      whole = whole && *rest == ',';
      if (!whole) break;
      value = std::strtod(rest + 1, &after);
      whole = after != rest + 1 && std::isfinite(value);
      rest = after;
    }
    const Vec3 d = {v[0], v[1], v[2]};
    if (!whole || *rest != '\0' || !(length(d) > 0.0))
      throw cannot("read", path, "line " + std::to_string(line) + " is not a name, a direction and seven numbers",
                   "Write it with train.py");
    std::string name = row.substr(0, comma);
    if (name.ends_with(".png")) name.resize(name.size() - 4);
    (*table)[name] = {normalised(d), {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, v[9], true};
  }
  return [table, path](const Picture&, const std::string& name) {
    const auto found = table->find(name);
    if (found == table->end())
      throw cannot("use", path, "it has no line for \"" + name + "\"", "Estimate all views of these panoramas");
    return found->second;
  };
}

LightLabels brightest_region(const Picture& image, double contrast) {
  const double focal = focal_length(image.width, image.height, k_excerpt_fov_deg);
  double greatest = 0.0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) greatest = std::max(greatest, luminance(pixel_of(image, x, y)));
  Vec3 direction, light, ambient;
  double bright = 0.0, rest = 0.0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3 colour = pixel_of(image, x, y);
      if (luminance(colour) >= k_bright_share * greatest) {
        const Vec3 ray = {(x - 0.5 * (image.width - 1)) / focal, (y - 0.5 * (image.height - 1)) / focal, 1.0};
        direction = direction + normalised(ray);
        light = light + colour;
        bright += 1.0;
      } else {
        ambient = ambient + colour;
        rest += 1.0;
      }
    }
  return {normalised(direction), light * (1.0 / bright), ambient * (1.0 / std::max(rest, 1.0)), contrast, true};
}

LightLabels grey_world(const Picture& image, double contrast) {
  Vec3 sum;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum = sum + pixel_of(image, x, y);
  const Vec3 mean = sum * (1.0 / (static_cast<double>(image.width) * image.height));
  const double brightest = std::max({mean.x, mean.y, mean.z});
  const Vec3 light = brightest > 0.0 ? mean * (1.0 / brightest) : Vec3{1, 1, 1};
  return {{0.0, -1.0, 0.0}, light, mean, contrast, true};
}

std::vector<Verdict> verify_lighting(const LightingVerdictOptions& options) {
  const std::vector<std::string> panoramas = find_panoramas(options.panoramas);
  refuse_equal_stems(panoramas);
  const std::string manifest = read_locations(options.manifest);
  for (const std::string& panorama : panoramas) location_of(panorama, manifest);  // before minutes of work
  std::vector<JudgedView> views(panoramas.size() * k_excerpts);
  for_all(panoramas.size(), options.threads, "cutting views", [&](size_t i) {
    const LitPanorama panorama(panoramas[i]);
    const auto all = views_of(panoramas[i], options.seed);
    for (size_t k = 0; k < k_excerpts && !interrupted(); ++k) {
      LitView cut = panorama.cut(all[k]);
      JudgedView& view = views[i * k_excerpts + k];
      view.name = stem_of(panoramas[i]) + "_" + std::to_string(k);
      view.location = location_of(panoramas[i], manifest);
      view.image = std::move(cut.image);
      view.labels = cut.labels;
    }
  });
  bool with_mean = true;
  for (JudgedView& view : views) {
    if (interrupted()) return {};
    const bool others = mean_light(views, view.location, &view.lights[k_mean]);
    const double contrast = others ? view.lights[k_mean].contrast : k_any_contrast;
    with_mean = with_mean && others;
    view.lights[k_brightest] = brightest_region(view.image, contrast);
    view.lights[k_grey] = grey_world(view.image, contrast);
    view.lights[k_estimate] = view.lights[k_mirrored] = options.estimator(view.image, view.name);
    view.lights[k_mirrored].direction.x *= -1.0;
  }
  return judge(views, with_mean, options.seed);
}

}  // namespace sandglass::host

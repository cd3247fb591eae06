#include "tests/laboratory/light/verify_lighting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <numbers>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_picture.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/probe_scene.h"
#include "models/simulation/metrics.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/light/lit_picture.h"

namespace sandglass::host {

namespace {

constexpr double k_bright_share = 0.9;  // share of the greatest luminance; images are clipped there
constexpr double k_any_contrast = 0.5;  // taken where no other place gives a contrast
constexpr Colour k_white = {255, 255, 255}, k_black = {0, 0, 0};
constexpr Colour k_colours[k_light_sources] = {
    {255, 255, 255}, {60, 220, 60}, {150, 150, 150}, {230, 60, 200}, {80, 140, 255}};

constexpr const char* k_estimates_header =
    "image,direction_x,direction_y,direction_z,light_r,light_g,light_b,ambient_r,ambient_g,ambient_b,contrast";

Vec3 pixel_of(const Picture& image, int x, int y) {
  const uint8_t* p = image.at(x, y);
  return {linear_of(p[0]), linear_of(p[1]), linear_of(p[2])};
}

double angle_between(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi; }

double difference(Vec3 a, Vec3 b) { return (std::fabs(a.x - b.x) + std::fabs(a.y - b.y) + std::fabs(a.z - b.z)) / 3.0; }

// One view, from the cut to the verdict. Its warped panorama (6 MB) is freed once the truth is rendered.
struct Work {
  std::string path, name;
  Location location;
  View view;
  Picture image;
  LightLabels lights[k_light_sources];
  bool has[k_light_sources] = {true, false, false, true, true};
  double white = 0.0;
  RadianceMap truth, pictures[k_light_sources];
};

void render_truth(const ProbeScene& scene, const RadianceMap& warped, int samples, Work* work) {
  const ProbeLight light = ProbeLight::environment(warped, ViewRotation(work->view));
  work->truth = shown_by(scene.render(light, work->view, samples), work->white);
}

void render_estimates(const ProbeScene& scene, int samples, Work* work) {
  // Ambient light looks different from each side of the object.
  const RadianceMap ambient = scene.render(ProbeLight::ambient(), work->view, samples);
  const ViewRotation rotation(work->view);
  for (int s = 0; s < k_light_sources; ++s) {
    if (!work->has[s]) continue;
    LightLabels light = work->lights[s];
    light.direction = rotation.to_panorama(camera_to_rotated(light.direction));
    const RadianceMap directional = scene.render(ProbeLight::directional(light.direction), work->view, samples);
    work->pictures[s] = lit_by(light, directional, ambient);
  }
}

// The mean of the labels of other places. If the place has a fold, only places of other folds count. Returns false if
// there are none.
bool mean_light(const std::vector<Work>& all, const Location& location, LightLabels* mean) {
  *mean = {};
  size_t count = 0;
  for (const Work& other : all) {
    if (other.location.name == location.name || (location.fold >= 0 && other.location.fold == location.fold)) continue;
    const LightLabels& l = other.lights[0];
    mean->direction = mean->direction + l.direction, mean->light = mean->light + l.light;
    mean->ambient = mean->ambient + l.ambient, mean->contrast += l.contrast;
    ++count;
  }
  if (count == 0 || length(mean->direction) <= 0.0) return false;
  const double share = 1.0 / static_cast<double>(count);
  mean->direction = normalised(mean->direction), mean->light = mean->light * share;
  mean->ambient = mean->ambient * share, mean->contrast *= share;
  mean->has_direction = true;
  return true;
}

LightErrors errors_of(const Work& work, int source) {
  const LightLabels &truth = work.lights[0], &made = work.lights[source];
  LightErrors e;
  e.angle_deg = angle_between(truth.direction, made.direction);
  e.light = difference(truth.light, made.light), e.ambient = difference(truth.ambient, made.ambient);
  e.contrast = std::fabs(truth.contrast - made.contrast);
  if (work.truth.width > 0) e.image = compare(work.truth, work.pictures[source]);
  return e;
}

// The image with arrows, above the rendered pictures: first the truth, then the sources in their order.
Picture picture_of_work(const Work& work, const LightView& view) {
  constexpr int k_columns = 3, k_label = 9;
  Picture picture(k_columns * ProbeScene::k_width, k_excerpt_height + 2 * (ProbeScene::k_height + k_label) + k_label,
                  k_white);
  Picture image = work.image;
  for (int s = k_light_sources - 1; s >= 0; --s)
    if (work.has[s]) draw_light_arrow(&image, work.lights[s].direction, k_colours[s]);
  draw_text(&picture, 2, 1, 1, view.name, k_black);
  paste(&picture, image, (picture.width - image.width) / 2, k_label);
  for (int i = 0, at = 0; i <= k_light_sources; ++i) {
    if (i > 0 && !work.has[i - 1]) continue;
    const int x = at % k_columns * ProbeScene::k_width,
              y = k_label + k_excerpt_height + at / k_columns * (ProbeScene::k_height + k_label);
    const RadianceMap& rendered = i == 0 ? work.truth : work.pictures[i - 1];
    if (rendered.width > 0) paste(&picture, picture_of(rendered), x, y + k_label);
    char label[32] = "TRUTH";
    if (i > 0)
      std::snprintf(label, sizeof label, "%s %.0f", name_of(static_cast<Contender>(i - 1)),
                    view.errors[i - 1].angle_deg);
    draw_text(&picture, x + 10, y + 1, 1, label, k_black);
    if (i > 0)
      fill_rectangle(&picture, x + 1, y + 1, 7, 7, k_black),
          fill_rectangle(&picture, x + 2, y + 2, 5, 5, k_colours[i - 1]);
    if (++at == 2 * k_columns) break;
  }
  return picture;
}

using Member = double (*)(const LightErrors&);

// What an estimate must show against a baseline. `better`: the interval of the difference lies below 0. `no worse`: it
// lies below a tenth of the baseline's own error; an interval that only reaches 0 shows nothing.
constexpr double k_equivalent = 0.1;
struct Quantity {
  const char* name;
  const char* unit;
  Member of;
  bool must_win;
  bool against_mean_light;  // false: some thirty places do not tell, and nothing is claimed
};
constexpr Quantity k_quantities[] = {
    {"direction", "deg", [](const LightErrors& e) { return e.angle_deg; }, true, true},
    {"light colour", "", [](const LightErrors& e) { return e.light; }, false, true},
    {"ambient colour", "", [](const LightErrors& e) { return e.ambient; }, false, true},
    {"contrast", "", [](const LightErrors& e) { return e.contrast; }, false, true},
    {"rendered RMSE", "", [](const LightErrors& e) { return e.image.rmse; }, false, false},
};

void judge(const std::vector<Work>& works, bool rendered, uint64_t seed, LightingVerdicts* verdicts) {
  for (const Contender baseline : {Contender::mean, Contender::brightest, Contender::grey}) {
    const auto b = static_cast<size_t>(baseline), e = static_cast<size_t>(Contender::estimate);
    if (!works.front().has[b]) continue;
    for (const Quantity& quantity : k_quantities) {
      if (!rendered && quantity.of({.image = {.rmse = 1.0}}) > 0.0) continue;
      std::vector<std::pair<std::string, double>> differences;
      double error = 0.0;
      for (const LightView& view : verdicts->views) {
        differences.emplace_back(view.location, quantity.of(view.errors[e]) - quantity.of(view.errors[b]));
        error += quantity.of(view.errors[b]) / static_cast<double>(verdicts->views.size());
      }
      const Interval d = interval_of(place_means(differences), seed);
      const std::string name = std::string(quantity.name) + " against " + name_of(baseline);
      verdicts->rows.push_back({"lighting", name + ", mean", quantity.unit, 0.0, d.mean,
                                std::numeric_limits<double>::infinity(), true, false});
      if (baseline == Contender::mean && !quantity.against_mean_light) continue;
      const double limit = quantity.must_win ? 0.0 : k_equivalent * error;
      verdicts->rows.push_back(
          {"lighting", name + ", 97.5 %", quantity.unit, 0.0, d.high, limit, d.high < limit, false});
    }
  }
}

}  // namespace

const char* name_of(Contender source) {
  constexpr const char* k_names[] = {"labels", "estimate", "mean light", "brightest", "grey world"};
  return k_names[static_cast<int>(source)];
}

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

std::set<std::string> panoramas_of_estimates(const std::string& text) {
  std::set<std::string> stems;
  for (size_t at = text.find('\n'); at < text.size(); at = text.find('\n', at + 1)) {
    const std::string image = text.substr(at + 1, text.find(',', at) - at - 1);
    if (const size_t view = image.rfind('_'); view != std::string::npos) stems.insert(image.substr(0, view));
  }
  return stems;
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
        direction = direction + normalised(ray), light = light + colour, bright += 1.0;
      } else {
        ambient = ambient + colour, rest += 1.0;
      }
    }
  return {normalised(direction), light * (1.0 / bright), ambient * (1.0 / std::max(rest, 1.0)), contrast, true};
}

LightLabels grey_world(const Picture& image, double contrast) {
  Vec3 sum;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum = sum + pixel_of(image, x, y);
  const Vec3 mean = sum * (1.0 / (static_cast<double>(image.width) * image.height));
  const double most = std::max({mean.x, mean.y, mean.z});
  const Vec3 light = most > 0.0 ? mean * (1.0 / most) : Vec3{1, 1, 1};
  return {{0.0, -1.0, 0.0}, light, mean, contrast, true};
}

LightingVerdicts verify_lighting(const LightingVerdictOptions& options) {
  const std::vector<std::string> panoramas = find_panoramas(options.panoramas);
  refuse_equal_stems(panoramas);
  const std::string manifest = read_locations(options.manifest);
  for (const std::string& panorama : panoramas) location_of(panorama, manifest);  // before minutes of rendering
  const auto views = static_cast<size_t>(options.views);
  const bool rendered = options.samples > 0;
  const auto scene = rendered ? std::make_unique<ProbeScene>(options.object) : nullptr;
  std::vector<Work> works(panoramas.size() * views);
  LightingVerdicts verdicts;
  verdicts.rendered = rendered;
  verdicts.has_estimate = static_cast<bool>(options.estimator);
  for_all(panoramas.size(), options.threads, "lighting truths", [&](size_t i) {
    const LitPanorama panorama(panoramas[i]);
    const auto all = views_of(panoramas[i], options.seed);
    for (size_t k = 0; k < views && !interrupted(); ++k) {
      Work& work = works[i * views + k];
      LitView cut = panorama.cut(all[k]);
      work.path = panoramas[i], work.name = stem_of(panoramas[i]) + "_" + std::to_string(k);
      work.location = location_of(panoramas[i], manifest), work.view = all[k], work.white = panorama.white();
      work.image = std::move(cut.image), work.lights[0] = cut.labels;
      if (rendered) render_truth(*scene, cut.warped, options.samples, &work);
    }
  });
  if (interrupted()) return verdicts;
  for (Work& work : works) {
    const bool others = mean_light(works, work.location, &work.lights[static_cast<size_t>(Contender::mean)]);
    work.has[static_cast<size_t>(Contender::mean)] = others;
    const double contrast = others ? work.lights[static_cast<size_t>(Contender::mean)].contrast : k_any_contrast;
    work.lights[static_cast<size_t>(Contender::brightest)] = brightest_region(work.image, contrast);
    work.lights[static_cast<size_t>(Contender::grey)] = grey_world(work.image, contrast);
    work.has[static_cast<size_t>(Contender::estimate)] = verdicts.has_estimate;
    if (verdicts.has_estimate)
      work.lights[static_cast<size_t>(Contender::estimate)] = options.estimator(work.image, work.name);
  }
  if (rendered) {
    for_all(works.size(), options.threads, "lighting estimates",
            [&](size_t i) { render_estimates(*scene, options.samples, &works[i]); });
    if (interrupted()) return verdicts;
  }
  for (const Work& work : works) {
    LightView view;
    view.name = work.name, view.panorama = stem_of(work.path), view.location = work.location.name;
    view.path = work.path, view.view = work.view;
    std::copy_n(work.lights, k_light_sources, view.lights);
    for (int s = 0; s < k_light_sources; ++s)
      if (work.has[s]) view.errors[s] = errors_of(work, s);
    verdicts.views.push_back(view);
  }
  for (size_t i = 0; i < works.size(); i += views)
    verdicts.pictures.push_back(picture_of_work(works[i], verdicts.views[i]));
  for (int s = 0; s < k_light_sources; ++s) verdicts.has[s] = works.front().has[s];
  if (verdicts.has_estimate) judge(works, rendered, options.seed, &verdicts);
  return verdicts;
}

namespace {

// The columns of both tables: four errors of the light, then five errors of the image.
constexpr size_t k_errors = 9;

void add_errors(const LightErrors& e, double share, std::array<double, k_errors>* sums) {
  const std::array<double, k_errors> values = {e.angle_deg,
                                               e.light,
                                               e.ambient,
                                               e.contrast,
                                               e.image.rmse,
                                               e.image.relative,
                                               e.image.scale_invariant,
                                               e.image.logarithmic,
                                               e.image.angle_deg};
  for (size_t i = 0; i < k_errors; ++i) (*sums)[i] += share * values[i];
}

}  // namespace

std::string lighting_table(const LightingVerdicts& verdicts) {
  char line[256];
  std::snprintf(line, sizeof line, "%-11s %7s %7s %7s %7s %7s %8s %8s %8s %8s %8s %8s\n", "light", "mean", "median",
                "90 %", "light", "ambient", "contrast", "RMSE", "nRMSE", "siRMSE", "RMLE", "RGB deg");
  std::string text = line;
  for (size_t s = 0; s < k_light_sources; ++s) {
    if (!verdicts.has[s]) continue;
    std::vector<double> angles;
    std::array<double, k_errors> m = {};
    const double share = 1.0 / static_cast<double>(verdicts.views.size());
    for (const LightView& view : verdicts.views) {
      angles.push_back(view.errors[s].angle_deg);
      add_errors(view.errors[s], share, &m);
    }
    const double median = quantile(angles, 0.5), most = quantile(angles, 0.9);
    std::snprintf(line, sizeof line, "%-11s %7.2f %7.2f %7.2f %7.4f %7.4f %8.4f", name_of(static_cast<Contender>(s)),
                  m[0], median, most, m[1], m[2], m[3]);
    text += line;
    std::snprintf(line, sizeof line, " %8.4f %8.4f %8.4f %8.4f %8.3f\n", m[4], m[5], m[6], m[7], m[8]);
    text += verdicts.rendered ? line : "        -        -        -        -        -\n";
  }
  return text;
}

std::string lighting_csv(const LightingVerdicts& verdicts) {
  std::string text =
      "panorama,place,source,views,angle_deg,light,ambient,contrast,rmse,nrmse,si_rmse,rmle,rgb_angle_deg\n";
  for (size_t first = 0, end = 0; first < verdicts.views.size(); first = end) {
    while (end < verdicts.views.size() && verdicts.views[end].panorama == verdicts.views[first].panorama) ++end;
    const double share = 1.0 / static_cast<double>(end - first);
    for (size_t s = 0; s < k_light_sources; ++s) {
      if (!verdicts.has[s]) continue;
      std::array<double, k_errors> sums = {};
      for (size_t i = first; i < end; ++i) add_errors(verdicts.views[i].errors[s], share, &sums);
      text += verdicts.views[first].panorama + "," + verdicts.views[first].location + "," +
              name_of(static_cast<Contender>(s)) + "," + std::to_string(end - first);
      for (size_t q = 0; q < k_errors; ++q) {
        char number[32];
        std::snprintf(number, sizeof number, ",%.5g", sums[q]);
        text += q < 4 || verdicts.rendered ? number : ",";
      }
      text += "\n";
    }
  }
  return text;
}

std::string estimates_csv(const LightingVerdicts& verdicts) {
  std::string text = std::string(k_estimates_header) + "\n";
  for (const LightView& view : verdicts.views) {
    const LightLabels& e = view.lights[static_cast<size_t>(Contender::estimate)];
    text += view.name + ".png";
    for (const double value : {e.direction.x, e.direction.y, e.direction.z, e.light.x, e.light.y, e.light.z,
                               e.ambient.x, e.ambient.y, e.ambient.z, e.contrast}) {
      char number[32];
      std::snprintf(number, sizeof number, ",%.6f", value);
      text += number;
    }
    text += "\n";
  }
  return text;
}

}  // namespace sandglass::host

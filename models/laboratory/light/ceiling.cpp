#include "models/laboratory/light/ceiling.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "models/lighting/dataset.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/probe_scene.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

namespace {

constexpr double k_most_contrast = 0.95;   // a limit, because o / (1 - o) has none
constexpr double k_least_elevation = 0.1;  // sine; a light that grazes the floor cannot give it a large irradiance
constexpr double k_unshadowed = 0.98;      // a floor pixel of this visibility or more counts as lit
constexpr double k_pi = std::numbers::pi;

std::vector<CeilingVariant> all_variants() {
  std::vector<CeilingVariant> variants;
  for (int range = 0; range < k_ranges; ++range)
    for (int weight = 0; weight < k_ambient_weights; ++weight)
      for (int radiometry = 0; radiometry < k_radiometries; ++radiometry)
        for (int contrast = 0; contrast < (radiometry == 0 ? 1 : k_contrasts); ++contrast)
          variants.push_back({static_cast<Range>(range),
                              static_cast<AmbientWeight>(weight),
                              static_cast<Radiometry>(radiometry),
                              static_cast<Contrast>(contrast),
                              {}});
  return variants;
}

struct ViewResult {  // what one view adds to the sums
  std::vector<ImageErrors> errors;
  double shadow[k_contrasts] = {}, offset[k_contrasts] = {}, contrast[k_contrasts] = {}, best = 0.0;
  bool has_shadow = false;
  double zenith_deg = 0.0;
};

void measure_contrast(const ProbeImage& truth, const ProbeImage& directional, ViewResult* view) {
  double both = 0.0, square = 0.0;
  std::vector<std::pair<double, double>> floor;  // a pixel's darkness: in truth, and at the umbra's full opacity
  for (size_t i = 0; i < truth.lit.size(); ++i) {
    const double t = truth.lit[i], d = directional.lit[i];
    if (t < 0.0 || (t >= k_unshadowed && d >= k_unshadowed)) continue;
    floor.emplace_back(1.0 - t, 1.0 - d);
    both += (1.0 - t) * (1.0 - d), square += (1.0 - d) * (1.0 - d);
  }
  if (floor.empty()) return;
  view->has_shadow = true;
  const double best = square > 0.0 ? std::clamp(both / square, 0.0, 1.0) : 0.0;
  const auto rmse = [&](double o) {
    double sum = 0.0;
    for (const auto& [t, d] : floor) sum += (t - o * d) * (t - o * d);
    return std::sqrt(sum / static_cast<double>(floor.size()));
  };
  for (int c = 0; c < k_contrasts; ++c) {
    view->shadow[c] = rmse(view->contrast[c]);
    view->offset[c] = std::fabs(view->contrast[c] - best);
  }
  view->best = rmse(best);
}

ViewResult measure_view(const ProbeScene& scene, const ProbeImage& ambient, const RadianceMap& panorama, View view,
                        double radius, int samples) {
  const std::vector<CeilingVariant> variants = all_variants();
  const double white = greatest_luminance(panorama);
  const ViewRotation rotation(view);
  const RadianceMap warped = warp(panorama, view, radius);
  LabelVariants labels = label_variants(warped, rotation.to_rotated({0, 1, 0}), white);
  labels.direction = rotation.to_panorama(labels.direction);  // the probe stands in the panorama's frame
  const ProbeImage truth = scene.render(ProbeLight::environment(warped, rotation), view, samples);
  const RadianceMap shown = shown_by(truth.radiance, white);
  const ProbeImage directional = scene.render(ProbeLight::directional(labels.direction), view, samples);
  ViewResult result;
  for (const CeilingVariant& variant : variants) {
    const LightLabels chosen = labels.chosen(variant.range, variant.weight, variant.contrast);
    const Strengths strengths = strengths_of(chosen, variant.radiometry);
    result.errors.push_back(compare(shown, lit_by(strengths, directional.radiance, ambient.radiance)));
  }
  std::copy_n(labels.contrast, k_contrasts, result.contrast);
  result.zenith_deg = std::acos(std::clamp(labels.direction.y, -1.0, 1.0)) * 180.0 / k_pi;
  measure_contrast(truth, directional, &result);
  return result;
}

void add(ImageErrors* sum, const ImageErrors& e, double share) {
  sum->rmse += share * e.rmse, sum->relative += share * e.relative, sum->scale_invariant += share * e.scale_invariant;
  sum->logarithmic += share * e.logarithmic, sum->angle_deg += share * e.angle_deg;
}

}  // namespace

Strengths strengths_of(const LightLabels& labels, Radiometry radiometry) {
  Vec3 light = labels.light;
  const double o = std::min(labels.contrast, k_most_contrast), ratio = o / (1.0 - o);
  if (radiometry == Radiometry::contrast_scaled) light = light * ratio;
  if (radiometry == Radiometry::floor_share && luminance(light) > 0.0)
    light = light *
            (luminance(labels.ambient) * ratio / std::max(labels.direction.y, k_least_elevation) / luminance(light));
  return {light, labels.ambient};
}

RadianceMap lit_by(const Strengths& strengths, const RadianceMap& directional, const RadianceMap& ambient) {
  RadianceMap picture(directional.width, directional.height);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      picture.set(x, y,
                  limited(product(strengths.directional, directional.colour(x, y)) +
                          product(strengths.ambient, ambient.colour(x, y))));
  return picture;
}

RadianceMap shown_by(RadianceMap radiance, double white) {
  for (int y = 0; y < radiance.height; ++y)
    for (int x = 0; x < radiance.width; ++x) radiance.set(x, y, limited(tone_mapped(radiance.colour(x, y), white)));
  return radiance;
}

const char* name_of(Range range) {
  constexpr const char* k_names[] = {"unlimited", "pixels clamped", "mean clamped", "mean scaled"};
  return k_names[static_cast<int>(range)];
}
const char* name_of(AmbientWeight weight) { return weight == AmbientWeight::luminance ? "luminance" : "solid angle"; }
const char* name_of(Contrast contrast) {
  constexpr const char* k_names[] = {"as printed", "factor above", "irradiance"};
  return k_names[static_cast<int>(contrast)];
}
const char* name_of(Radiometry radiometry) {
  constexpr const char* k_names[] = {"pi c", "pi c o/(1-o)", "floor share o"};
  return k_names[static_cast<int>(radiometry)];
}

Ceiling measure_ceiling(const CeilingOptions& options) {
  const std::vector<std::string> panoramas = find_panoramas(options.panoramas);
  const ProbeScene scene(options.object);
  std::vector<ViewResult> views(panoramas.size() * static_cast<size_t>(options.views));
  for_all(panoramas.size(), options.threads, "lighting panoramas", [&](size_t i) {
    RadianceMap panorama = read_panorama(panoramas[i]);
    fill_tripod(&panorama);
    const auto all = choose_views(options.seed + i);
    for (size_t k = 0; k < static_cast<size_t>(options.views) && !interrupted(); ++k) {
      // Ambient light looks different from each side of the object.
      const ProbeImage ambient = scene.render(ProbeLight::ambient(), all[k], options.samples);
      views[i * static_cast<size_t>(options.views) + k] =
          measure_view(scene, ambient, panorama, all[k], k_unknown_depth_insertion, options.samples);
    }
  });

  Ceiling ceiling;
  if (interrupted()) return ceiling;
  ceiling.panoramas = panoramas.size(), ceiling.views = views.size();
  ceiling.variants = all_variants();
  const double share = 1.0 / static_cast<double>(views.size());
  double shadows = 0.0;
  for (const ViewResult& view : views) shadows += view.has_shadow ? 1.0 : 0.0;
  for (const ViewResult& view : views) {
    for (size_t i = 0; i < ceiling.variants.size(); ++i) add(&ceiling.variants[i].mean, view.errors[i], share);
    for (int c = 0; c < k_contrasts; ++c) {
      ContrastError& e = ceiling.contrasts[c];
      if (view.has_shadow) e.shadow_rmse += view.shadow[c] / shadows, e.offset += view.offset[c] / shadows;
      e.low = std::min(e.low, view.contrast[c]), e.high = std::max(e.high, view.contrast[c]);
      e.mean += share * view.contrast[c];
    }
    if (view.has_shadow) ceiling.best_contrast_rmse += view.best / shadows;
    ceiling.lights_beyond_45 += view.zenith_deg > 45.0 ? share : 0.0;
    ceiling.lights_beyond_70 += view.zenith_deg > 70.0 ? share : 0.0;
    ceiling.lights_below_horizon += view.zenith_deg > 90.0 ? share : 0.0;
  }
  std::sort(ceiling.variants.begin(), ceiling.variants.end(),
            [](const CeilingVariant& a, const CeilingVariant& b) { return a.mean.rmse < b.mean.rmse; });
  return ceiling;
}

}  // namespace sandglass::host

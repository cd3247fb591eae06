#include "tests/laboratory/shadow/shadow_curves.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "models/baking/shadow_runner.h"
#include "models/baking/training_set.h"
#include "models/files/failure.h"
#include "models/simulation/metrics.h"
#include "models/work/progress.h"
#include "tests/laboratory/cpu_time.h"
#include "tests/laboratory/shadow/shadow_bench.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_size = k_native_size;
constexpr uint32_t k_lights = 12;
constexpr uint64_t k_stream = uint64_t{5} << 40;
constexpr uint32_t k_thresholds[] = {0, 5, 12, 24, 48, 64, 96, 128, 192};
constexpr uint32_t k_texture_sizes[] = {128, 256, 512};

// Reads coverage bytes (or floats) over a rectangle, as a GPU reads a texture that is clamped to its edge.
template <class Value>
double read_texture(const Value* texels, uint32_t size, double s, double t) {
  const double x = std::clamp(s * size - 0.5, 0.0, size - 1.0), y = std::clamp(t * size - 0.5, 0.0, size - 1.0);
  const uint32_t u = std::min(static_cast<uint32_t>(x), size - 2), v = std::min(static_cast<uint32_t>(y), size - 2);
  const double fx = x - u, fy = y - v;
  const auto at = [&](uint32_t a, uint32_t b) { return static_cast<double>(texels[size_t{b} * size + a]); };
  return (1 - fy) * ((1 - fx) * at(u, v) + fx * at(u + 1, v)) + fy * ((1 - fx) * at(u, v + 1) + fx * at(u + 1, v + 1));
}

// The truth for one light at the texel centres of its fitted rectangle.
struct World {
  ShadowRectangle rectangle;
  std::vector<float> transparency;

  // `full`: the value of a texel without light.
  template <class Value>
  double rmse(const Value* coverage, uint32_t size, const ShadowRectangle& own, double full) const {
    double sum = 0;
    for (uint32_t v = 0; v < k_size; ++v)
      for (uint32_t u = 0; u < k_size; ++u) {
        const double x = rectangle.low_x + (u + 0.5) / k_size * (rectangle.high_x - rectangle.low_x);
        const double z = rectangle.low_z + (v + 0.5) / k_size * (rectangle.high_z - rectangle.low_z);
        const double s = (x - own.low_x) / (own.high_x - own.low_x), t = (z - own.low_z) / (own.high_z - own.low_z);
        const bool inside = s >= 0 && s <= 1 && t >= 0 && t <= 1;
        const double shade = inside ? read_texture(coverage, size, s, t) / full : 0;
        sum += std::pow(1 - shade - static_cast<double>(transparency[size_t{v} * k_size + u]), 2);
      }
    return std::sqrt(sum / (k_size * k_size));
  }
};

struct Sum {
  std::vector<double> ms;
  double rmse = 0;

  ShadowCurvePoint point(const std::string& name, double number) {
    return {name, quantile(ms, 0.5), rmse / static_cast<double>(ms.size()), number};
  }
};

}  // namespace

std::vector<ShadowCurve> measure_shadow_curves(const std::vector<NamedShadow>& files, const Mesh& mesh,
                                               sandglass_isa isa,
                                               const std::function<bool(uint32_t, uint32_t)>& go_on) {
  std::vector<BakedShadow> baked;
  double polar = k_pi;
  for (const NamedShadow& file : files) {
    baked.push_back(open_baked_shadow(file.bytes, file.name, mesh));
    polar = std::min(polar, baked.back().geometry.polar_max);
  }
  const LightGeometry& first = baked[0].geometry;
  for (size_t i = 1; i < baked.size(); ++i)
    if (std::fabs(baked[i].geometry.half_angle - first.half_angle) > 1e-6)
      throw cannot("compare", files[i].name,
                   "it was baked for a light of another --angle than \"" + files[0].name + "\"",
                   "Bake both for the same --angle");
  LightGeometry fitted = first;
  fitted.plane = PlaneRule::fitted;
  const ShadowCaster caster(first.object.mesh, first.half_angle, {}, 1);
  ThreadPool pool(1);

  std::vector<std::unique_ptr<ShadowRunner>> thresholds, full, adaptive;
  for (const uint32_t t : k_thresholds)
    thresholds.push_back(std::make_unique<ShadowRunner>(files[0].bytes, files[0].name, isa, SANDGLASS_SHADOW_ADAPTIVE,
                                                        static_cast<int32_t>(t)));
  for (const NamedShadow& file : files) {
    full.push_back(std::make_unique<ShadowRunner>(file.bytes, file.name, isa, SANDGLASS_SHADOW_FULL));
    adaptive.push_back(std::make_unique<ShadowRunner>(file.bytes, file.name, isa, SANDGLASS_SHADOW_ADAPTIVE));
  }
  std::vector<Sum> of_thresholds(thresholds.size()), of_full(files.size()), of_adaptive(files.size()),
      of_float(files.size()), of_sizes(std::size(k_texture_sizes));

  const std::vector<Direction> lights = ring_directions(polar, k_lights);
  for (uint32_t i = 0; i < k_lights; ++i) {
    const Direction &light = lights[i], &other = lights[(i + 1) % k_lights];
    World world = {fitted.rectangle(light), {}};
    world.transparency = caster.texture(world.rectangle, light, k_stream + i, k_size, pool);
    // The runtime computes nothing for a light that it has already. So another light comes in between, untimed.
    const auto measure = [&](ShadowRunner* runner, const LightGeometry& geometry, Sum* sum, uint32_t size) {
      if (interrupted()) return;
      sandglass_shadow_texture texture = {};
      std::vector<uint8_t> resampled(size_t{size} * size);
      const auto make = [&] {
        texture = runner->texture(light);
        const char* reason = nullptr;
        if (size != k_size &&
            sandglass_shadow_resample(runner->handle(), 0, size, resampled.data(), &reason) != SANDGLASS_OK)
          throw cannot("turn", "light", reason);
      };
      sum->ms.push_back(best_cpu_ms(make, [&] { runner->texture(other); }));
      sum->rmse +=
          world.rmse(size == k_size ? texture.coverage : resampled.data(), size, geometry.rectangle(light), 255);
    };
    for (size_t t = 0; t < thresholds.size(); ++t) measure(thresholds[t].get(), first, &of_thresholds[t], k_size);
    for (size_t t = 0; t < of_sizes.size(); ++t) measure(adaptive[0].get(), first, &of_sizes[t], k_texture_sizes[t]);
    for (size_t f = 0; f < files.size(); ++f) {
      measure(full[f].get(), baked[f].geometry, &of_full[f], k_size);
      measure(adaptive[f].get(), baked[f].geometry, &of_adaptive[f], k_size);
      if (baked[f].network.parameters.empty() || interrupted()) continue;
      const double from = cpu_ms_now();
      std::vector<float> coverage = evaluate(baked[f].network, light, k_size, pool);
      of_float[f].ms.push_back(cpu_ms_now() - from);
      for (float& c : coverage) c = 1 - c;
      of_float[f].rmse += world.rmse(coverage.data(), k_size, baked[f].geometry.rectangle(light), 1);
    }
    if (!go_on(i + 1, k_lights)) return {};
  }

  ShadowCurve by_threshold = {"thresholds", {}}, by_texture = {"textures", {}}, by_float = {"float", {}};
  ShadowCurve by_size = {"sizes_int8", {}}, by_size_adaptive = {"sizes_adaptive", {}}, by_plane = {"fixed", {}};
  for (size_t t = 0; t < thresholds.size(); ++t)
    by_threshold.points.push_back(of_thresholds[t].point(std::to_string(k_thresholds[t]), k_thresholds[t]));
  for (size_t t = 0; t < of_sizes.size(); ++t)
    by_texture.points.push_back(of_sizes[t].point(std::to_string(k_texture_sizes[t]), k_texture_sizes[t]));
  for (size_t f = 0; f < files.size(); ++f) {
    const NetworkShape& shape = baked[f].network.shape;
    const std::string name = std::to_string(shape.width) + "x" + std::to_string(shape.layers);
    const double number = shape.parameters();
    if (baked[f].geometry.plane == PlaneRule::fixed) {
      by_plane.points.push_back(of_adaptive[f].point(name, number));
      continue;
    }
    by_size.points.push_back(of_full[f].point(name, number));
    by_size_adaptive.points.push_back(of_adaptive[f].point(name, number));
    if (!of_float[f].ms.empty()) by_float.points.push_back(of_float[f].point(name, number));
  }
  std::vector<ShadowCurve> curves;
  for (ShadowCurve& curve : std::vector{by_threshold, by_size, by_size_adaptive, by_float, by_texture, by_plane}) {
    if (curve.points.empty()) continue;
    std::sort(curve.points.begin(), curve.points.end(),
              [](const ShadowCurvePoint& a, const ShadowCurvePoint& b) { return a.number < b.number; });
    curves.push_back(curve);
  }
  return curves;
}

Plot shadow_curve_plot(const std::vector<ShadowCurve>& curves, const std::string& object) {
  struct Look {
    const char *name, *legend;
    Colour colour;
    PlotSeries::Mark mark;
    bool line;
  };
  constexpr Look k_looks[] = {
      {"thresholds", "bytes, adaptive: threshold 192 ... 0", {196, 98, 16}, PlotSeries::Mark::disk, true},
      {"sizes_int8", "bytes, every texel: sizes", {28, 110, 150}, PlotSeries::Mark::disk, true},
      {"sizes_adaptive", "bytes, adaptive: sizes", {28, 110, 150}, PlotSeries::Mark::ring, true},
      {"float", "float, every texel: sizes", {60, 60, 66}, PlotSeries::Mark::square, true},
      {"textures", "resampled to 128, (256,) 512", {60, 140, 60}, PlotSeries::Mark::square, false},
      {"fixed", "fixed plane, bytes, adaptive", {170, 40, 60}, PlotSeries::Mark::square, false}};
  Plot plot;
  plot.title = "Shadow of the " + object + ": error against time";
  plot.x = {"one texture of 256 x 256, ms, one thread", 1e30, 0, true};
  plot.y = {"RMSE against ray tracing", 0, 0, false};
  plot.legend_right = false;
  for (const Look& look : k_looks)
    for (const ShadowCurve& curve : curves) {
      if (curve.name != look.name) continue;
      PlotSeries series;
      series.name = look.legend, series.colour = look.colour, series.mark = look.mark, series.line = look.line;
      for (const ShadowCurvePoint& point : curve.points) {
        series.x.push_back(point.ms), series.y.push_back(point.rmse);
        plot.x.low = std::min(plot.x.low, 0.7 * point.ms), plot.x.high = std::max(plot.x.high, 1.4 * point.ms);
        plot.y.high = std::max(plot.y.high, 1.7 * point.rmse);  // room for the legend
      }
      plot.series.push_back(series);
    }
  return plot;
}

}  // namespace sandglass::host

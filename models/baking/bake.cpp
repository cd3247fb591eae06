// See bake.h.
#include "models/baking/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "models/baking/shadow_file.h"
#include "models/baking/shadow_runner.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

constexpr double k_degree = k_pi / 180;
// Training takes one texel of each cell of 4 x 4, and 16 times as many lights.
constexpr uint32_t k_stride = 4;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// CPU time of all threads.
double cpu_seconds_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Measures a stage: writes its time when it goes out of scope.
struct StageClock {
  BakeReport::Stage* stage;
  double start = seconds_now(), cpu_start = cpu_seconds_now();
  ~StageClock() { *stage = {seconds_now() - start, cpu_seconds_now() - cpu_start}; }
};

double ms_per_texture(const std::vector<uint8_t>& file, sandglass_shadow_mode mode, double polar_max) {
  ShadowRunner runner(file, "baked", SANDGLASS_ISA_AUTOMATIC, mode);
  const std::vector<Direction> lights = ring_directions(polar_max, 16);
  std::vector<double> times;
  for (const Direction& light : lights) {
    const double from = cpu_seconds_now();
    runner.texture(light);
    times.push_back(1e3 * (cpu_seconds_now() - from));
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

}  // namespace

LightGeometry light_geometry(const Mesh& mesh, const std::string& name, const BakeSettings& settings) {
  LightGeometry geometry;
  geometry.object = stand_on_plane(mesh, name);
  geometry.half_angle = 0.5 * settings.angular_diameter * k_degree;
  geometry.polar_max = settings.polar_max * k_degree;
  return geometry;
}

void make_quick(BakeSettings* settings) {
  settings->textures = 6;
  settings->steps = 2000;
  settings->quantised_steps = 200;
  settings->validation_lights = 4;
  settings->ambient.texels = 16;
  settings->ambient.rooms = 1;
}

BakeReport bake(const Mesh& mesh, const std::string& name, const BakeSettings& settings, const std::string& output,
                const std::string& picture) {
  if (settings.polar_max + 0.5 * settings.angular_diameter > 85)
    throw Failure(
        "cannot bake: the light reaches within 5 degrees of the horizon, where shadows have no end. Choose --max-polar "
        "plus half of --angle at most 85 degrees.");
  BakeReport report;
  const LightGeometry geometry = light_geometry(mesh, name, settings);
  const ShadowCaster caster(geometry.object.mesh, geometry.half_angle, {}, settings.seed);
  ThreadPool pool(settings.threads);
  TrainingSet set;
  set.size = k_native_size;
  set.stride = k_stride;
  set.lights = ring_directions(geometry.polar_max, settings.textures * k_stride * k_stride);
  TrainingState state = start_training(settings.shape, settings.seed);
  {
    const StageClock stage = {&report.tracing};
    const uint32_t lights = static_cast<uint32_t>(set.lights.size());
    Progress progress("tracing", lights);
    const bool whole = trace_training_set(
        geometry, caster, pool, [&](uint32_t done) { return progress.goes_on(done); }, &set);
    report.interrupted = !whole;
    if (!whole) return report;
  }
  TrainingPlan plan;
  plan.float_steps = settings.steps;
  plan.quantised_steps = settings.quantised_steps;
  plan.batch = settings.batch;
  plan.seed = settings.seed;
  Trainer trainer(set, plan, pool);
  const auto train = [&](const char* what, uint32_t first, uint32_t steps, BakeReport::Stage* time) {
    const StageClock stage = {time};
    Progress progress(what, steps);
    while (state.step < first + steps && !interrupted()) {
      trainer.step(&state);
      progress.done(state.step - first);
    }
    return !interrupted();
  };
  report.interrupted = !train("training", 0, plan.float_steps, &report.training) ||
                       !train("rounding", plan.float_steps, plan.quantised_steps, &report.rounding);
  if (report.interrupted) return report;

  ShadowFile file = {name, geometry, quantise(state.network, state.clips), 0, 0, 0, settings.seed, {}};
  if (settings.keep_float)
    file.float_parameters.assign(state.float_network.parameters.begin(), state.float_network.parameters.end());
  std::vector<uint8_t> bytes = shadow_file_bytes(file);
  {
    const StageClock stage = {&report.validating};
    Progress progress("validating", settings.validation_lights);
    const bool whole = validate(
        geometry, caster, state.float_network, bytes, settings.validation_lights, pool,
        [&](uint32_t done) { return progress.goes_on(done); }, &report.validation);
    report.interrupted = !whole;
    if (!whole) return report;
  }
  file.rmse_float = report.validation.network_float.rmse;
  file.rmse_int8 = report.validation.network_int8.rmse;
  file.validated_lights = report.validation.lights;
  std::vector<Picture> rooms;
  {
    const StageClock stage = {&report.ambient_stage};
    std::vector<Picture>* const pictures = picture.empty() ? nullptr : &rooms;
    report.interrupted =
        !bake_ambient(settings.ambient, settings.seed, settings.threads, &file, &report.ambient, pictures);
    if (report.interrupted) return report;
  }
  bytes = shadow_file_bytes(file);
  report.file_bytes = bytes.size();
  report.ms_full = ms_per_texture(bytes, SANDGLASS_SHADOW_FULL, geometry.polar_max);
  report.ms_adaptive = ms_per_texture(bytes, SANDGLASS_SHADOW_ADAPTIVE, geometry.polar_max);
  if (!picture.empty()) write_png(picture, shadow_picture(geometry, caster, bytes, pool, rooms));
  write_file(output, bytes);
  return report;
}

}  // namespace sandglass::host

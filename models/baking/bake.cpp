// See bake.h.
#include "models/baking/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "models/baking/checkpoint.h"
#include "models/baking/quantise.h"
#include "models/baking/shadow_runner.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/work/progress.h"
#include "models/work/random.h"

namespace sandglass::host {

namespace {

constexpr double k_degree = k_pi / 180;
// Training takes one texel of each cell of 4 x 4, and 16 times as many lights.
constexpr uint32_t k_stride = 4;
constexpr double k_checkpoint_period_s = 60.0;

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

// A hash of everything that the traced values and the training depend on.
uint64_t key_of(const Mesh& mesh, const BakeSettings& s) {
  uint64_t key = 1;
  const auto add = [&](uint64_t x) { key = random_mix(key ^ x); };
  for (const float x : mesh.vertices) {
    uint32_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    add(bits);
  }
  for (const uint32_t i : mesh.indices) add(i);
  for (const double x : {s.angular_diameter, s.polar_max, s.rate}) {
    uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    add(bits);
  }
  for (const uint64_t x : {uint64_t{s.shape.width}, uint64_t{s.shape.layers}, static_cast<uint64_t>(s.plane), s.seed,
                           uint64_t{s.textures}, uint64_t{s.steps}, uint64_t{s.quantised_steps}, uint64_t{s.batch}})
    add(x);
  return key;
}

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

// False where the user interrupted it.
bool add_ambient(const BakeSettings& settings, std::vector<Picture>* pictures, ShadowFile* file, BakeReport* report) {
  const StageClock stage = {&report->ambient_stage};
  report->interrupted =
      !bake_ambient(settings.ambient, settings.seed, settings.threads, file, &report->ambient, pictures);
  return !report->interrupted;
}

}  // namespace

LightGeometry light_geometry(const Mesh& mesh, const std::string& name, const BakeSettings& settings) {
  LightGeometry geometry;
  geometry.object = stand_on_plane(mesh, name);
  geometry.plane = settings.plane;
  geometry.half_angle = 0.5 * settings.angular_diameter * k_degree;
  geometry.polar_max = settings.polar_max * k_degree;
  return geometry;
}

BakeReport bake(const Mesh& mesh, const std::string& name, const BakeSettings& settings, const std::string& output,
                const std::string& picture, bool resume) {
  if (settings.polar_max + 0.5 * settings.angular_diameter > 85)
    throw Failure(
        "cannot bake: the light reaches within 5 degrees of the horizon, where shadows have no end. Choose --max-polar "
        "plus half of --angle at most 85 degrees.");
  BakeReport report;
  const LightGeometry geometry = light_geometry(mesh, name, settings);
  const ShadowCaster caster(geometry.object.mesh, geometry.half_angle, {}, settings.seed);
  ThreadPool pool(settings.threads);
  TrainingSet set;
  set.size = k_native_size, set.stride = k_stride;
  set.lights = ring_directions(geometry.polar_max, settings.textures * k_stride * k_stride);
  TrainingState state = start_training(settings.shape, settings.seed);
  const std::string checkpoint = output + ".checkpoint";
  const uint64_t key = key_of(mesh, settings);
  require_own_checkpoint(checkpoint);
  bool kept = resume && load_checkpoint(checkpoint, key, &set, &state);  // the checkpoint is of this bake
  if (kept)
    std::fprintf(stderr, "going on from %zu of %zu lights traced, %u of %u steps trained\n",
                 set.values.size() / (size_t{set.cells()} * set.cells()), set.lights.size(), state.step,
                 settings.steps + settings.quantised_steps);

  double saved = seconds_now();
  const auto keep = [&] {
    save_checkpoint(checkpoint, key, set, state);
    saved = seconds_now(), kept = true;
  };
  {
    const StageClock stage = {&report.tracing};
    const uint32_t lights = static_cast<uint32_t>(set.lights.size());
    const uint64_t traced = set.values.size() / (uint64_t{set.cells()} * set.cells());
    Progress progress("tracing", lights, stderr, traced);
    const bool whole = trace_training_set(
        geometry, caster, pool,
        [&](uint32_t done) {
          progress.done(done);
          if (seconds_now() - saved > k_checkpoint_period_s) keep();
          return !interrupted();
        },
        &set);
    if (!whole) {
      keep();
      report.interrupted = true;
      return report;
    }
  }
  TrainingPlan plan;
  plan.float_steps = settings.steps, plan.quantised_steps = settings.quantised_steps;
  plan.batch = settings.batch, plan.seed = settings.seed, plan.rate = settings.rate;
  Trainer trainer(set, plan, pool);
  const auto train = [&](const char* what, uint32_t first, uint32_t steps, BakeReport::Stage* time) {
    if (state.step >= first + steps) return true;
    const StageClock stage = {time};
    Progress progress(what, steps, stderr, state.step - first);
    while (state.step < first + steps) {
      trainer.step(&state);
      progress.done(state.step - first);
      if (seconds_now() - saved > k_checkpoint_period_s) keep();
      if (!interrupted()) continue;
      keep();
      return false;
    }
    return true;
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
        [&](uint32_t done) {
          progress.done(done);
          return !interrupted();
        },
        &report.validation);
    if (!whole) {
      keep();
      report.interrupted = true;
      return report;
    }
  }
  file.rmse_float = report.validation.network_float.rmse;
  file.rmse_int8 = report.validation.network_int8.rmse;
  file.validated_lights = report.validation.lights;
  std::vector<Picture> rooms;
  if (!add_ambient(settings, picture.empty() ? nullptr : &rooms, &file, &report)) {
    keep();
    return report;
  }
  bytes = shadow_file_bytes(file);
  report.file_bytes = bytes.size();
  report.ms_full = ms_per_texture(bytes, SANDGLASS_SHADOW_FULL, geometry.polar_max);
  report.ms_adaptive = ms_per_texture(bytes, SANDGLASS_SHADOW_ADAPTIVE, geometry.polar_max);
  if (!picture.empty()) write_png(picture, shadow_picture(geometry, caster, bytes, pool, rooms));
  write_file(output, bytes);
  if (kept) std::remove(checkpoint.c_str());
  return report;
}

BakeReport bake_ambient_only(const Mesh& mesh, const std::string& name, const BakeSettings& settings,
                             const std::string& output, const std::string& picture) {
  BakeReport report;
  const std::string old = read_file(output, "shadow", k_asset_limit);
  ShadowFile file =
      read_shadow_file({reinterpret_cast<const uint8_t*>(old.data()), old.size()}, stand_on_plane(mesh, name), output);
  std::vector<Picture> rooms;
  if (!add_ambient(settings, picture.empty() ? nullptr : &rooms, &file, &report)) return report;
  const std::vector<uint8_t> bytes = shadow_file_bytes(file);
  report.file_bytes = bytes.size();
  if (!picture.empty()) {
    const ShadowCaster caster(file.geometry.object.mesh, file.geometry.half_angle, {}, settings.seed);
    ThreadPool pool(settings.threads);
    write_png(picture, shadow_picture(file.geometry, caster, bytes, pool, rooms));
  }
  write_file(output, bytes);
  return report;
}

}  // namespace sandglass::host

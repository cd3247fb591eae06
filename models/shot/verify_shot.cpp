#include "models/shot/verify_shot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "models/host/atomic_file.h"
#include "models/host/body_meshes.h"
#include "models/host/collision_fields.h"
#include "models/host/failure.h"
#include "models/host/pile_shadow.h"
#include "models/host/simulation.h"
#include "models/host/standing_shadows.h"
#include "models/lighting/panorama_file.h"
#include "models/shot/light_estimate.h"
#include "runtime/sampling/random.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr uint32_t k_settling_frames = 75;  // 1.5 s: the knot has become a heap
constexpr uint64_t k_azimuth_stream = 61;

// The scene with its sand at rest; the light is set view by view.
struct Stage {
  SceneFile scene = load_scene("shot");
  std::vector<float> particles, grains;
  float grain_radius = 0.0f;
  Mesh object;

  Stage() {
    const LoadedMeshes meshes(scene, "");
    const Material material = fill_scene(&scene, meshes.bodies());
    const CollisionFields fields(&scene, "");
    Simulation simulation(describe_filled(scene, material));
    simulation.add(material);
    for (uint32_t frame = 0; frame < k_settling_frames; ++frame)
      simulation.frame(scene.frame_step, UINT64_MAX, colliders_over_frame(scene, frame));
    particles = simulation.particle_positions(), grains = simulation.grain_positions();
    grain_radius = drawn_grain_radius(scene.particle_radius, static_cast<uint32_t>(particles.size() / 3),
                                      static_cast<uint32_t>(grains.size() / 3));
    object = standing_object(scene, "");
  }

  ShotShadows shadows_for(Vec3 towards) const {
    StandingShadows standing(scene, SANDGLASS_ISA_AUTOMATIC);
    standing.set_light(scene, 0, towards);
    sandglass_shadow_run(standing.handles().data(), static_cast<uint32_t>(standing.handles().size()), ~0u);
    PileShadow pile(*scene.pile_shadow, SANDGLASS_ISA_AUTOMATIC);
    pile.set_light(towards);
    sandglass_pile_shadow_run(pile.handle(), particles.data(), static_cast<uint32_t>(particles.size() / 3),
                              static_cast<float>(scene.particle_radius), ~0u);
    const std::vector<sandglass_collider> colliders = colliders_over_frame(scene, 0);
    return {standing.drawn(colliders), {pile.drawn(false)}, {pile.drawn(true)}};
  }
};

void put(const ShotErrors& e, double (&row)[k_shot_metrics]) {
  const double values[k_shot_metrics] = {e.image.rmse,
                                         e.image.relative,
                                         e.image.scale_invariant,
                                         e.image.logarithmic,
                                         e.image.angle_deg,
                                         1.0 - e.similarity,
                                         e.flip};
  std::copy_n(values, k_shot_metrics, row);
}

// One line a view: name, whether there is an estimate, its angle, and all errors.
std::string line_of(const ShotView& view) {
  std::ostringstream text;
  text.precision(9);
  text << view.panorama << ' ' << view.has_estimate << ' ' << view.angle_deg;
  for (const auto& row : view.errors)
    for (const double e : row) text << ' ' << e;
  return text.str() + "\n";
}

bool read_line(const std::string& line, ShotView* view) {
  std::istringstream text(line);
  text >> view->panorama >> view->has_estimate >> view->angle_deg;
  for (auto& row : view->errors)
    for (double& e : row) text >> e;
  view->done = !text.fail();
  return view->done;
}

std::string key_of(const ShotStudyOptions& o) {
  return "shot study 3: " + std::to_string(o.width) + " x " + std::to_string(o.height) + ", " +
         std::to_string(o.paths) + " paths, network '" + fs::path(o.network).filename().string() + "'\n";
}

ShotView study_view(const ShotStudyOptions& options, const Stage& stage, const ShotPicture& picture, size_t index) {
  ShotView view;
  view.panorama = fs::path(options.panoramas[index]).stem().string();
  const double azimuth = 360.0 * random_stream(index, k_azimuth_stream).uniform();
  RadianceMap map = read_panorama(options.panoramas[index]);
  fill_tripod(&map);
  const Surroundings room =
      panorama_surroundings(std::move(map), view.panorama, *stage.scene.camera, azimuth, {}, k_unknown_depth_insertion);
  const ShotCamera camera = resting_camera(*stage.scene.camera);
  ShotPictureOptions o;
  o.width = options.width, o.height = options.height, o.paths = options.paths, o.threads = options.threads;
  const RadianceMap truth = picture.truth(room, camera, o);
  const ShotLight labels = labelled_light(room), arbitrary = arbitrary_light(camera);
  std::vector<Picture> cells = {displayed_picture(truth)};
  const auto measure = [&](ShotVariant variant, const ShotLight& light, CastShadow cast) {
    const RadianceMap made = picture.composite(room, camera, light, stage.shadows_for(light.towards), cast, o);
    put(shot_errors(truth, made), view.errors[static_cast<int>(variant)]);
    cells.push_back(displayed_picture(made));
  };
  measure(ShotVariant::labels, labels, CastShadow::textures);
  measure(ShotVariant::no_shadow, labels, CastShadow::none);
  measure(ShotVariant::hard_shadow, labels, CastShadow::hard);
  measure(ShotVariant::arbitrary_light, arbitrary, CastShadow::textures);
  if (!options.network.empty()) {
    LightEstimate estimate(options.network, SANDGLASS_ISA_AUTOMATIC);
    estimate.take(room, camera, 0);
    estimate.finish();
    const ShotLight light = estimate.light();
    measure(ShotVariant::estimate, light, CastShadow::textures);
    view.has_estimate = true;
    view.angle_deg = std::acos(std::clamp(dot(light.towards, labels.towards), -1.0, 1.0)) * 180.0 / 3.141592653589793;
  }
  if (!options.folder.empty())
    write_png((fs::path(options.folder) / ("view_" + std::to_string(index) + ".png")).string(),
              picture_grid(cells, static_cast<int>(cells.size()), 2));
  view.done = true;
  return view;
}

void sum_up(ShotStudy* study) {
  double count = 0;
  for (const ShotView& view : study->views) count += view.done ? 1 : 0;
  for (const ShotView& view : study->views) {
    if (!view.done) continue;
    study->has_estimate = study->has_estimate || view.has_estimate;
    for (int v = 0; v < k_shot_variants; ++v)
      for (int m = 0; m < k_shot_metrics; ++m) study->mean[v][m] += view.errors[v][m] / count;
  }
}

}  // namespace

const char* name_of(ShotVariant variant) {
  constexpr const char* k_names[] = {"true labels", "no shadow", "hard shadow", "arbitrary light", "estimate"};
  return k_names[static_cast<int>(variant)];
}
const char* shot_metric_name(int metric) {
  constexpr const char* k_names[] = {"RMSE", "nRMSE", "siRMSE", "RMLE", "RGB deg", "1 - SSIM", "FLIP"};
  return k_names[metric];
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
  constexpr double k_student = 2.093;  // 95 %, 19 degrees of freedom
  return {mean_of, n > 1 ? k_student * std::sqrt(square / (n - 1) / n) : 0.0};
}

ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress) {
  ShotStudy study;
  const size_t count = std::min(options.views, options.panoramas.size());
  study.views.resize(count);
  const std::string memory = options.folder.empty() ? "" : (fs::path(options.folder) / "views.txt").string();
  std::error_code ignored;
  if (!memory.empty() && fs::is_regular_file(memory, ignored)) {
    std::istringstream lines(read_file(memory, "study"));
    std::string line;
    if (std::getline(lines, line) && line + "\n" == key_of(options))
      while (std::getline(lines, line)) {
        ShotView view;
        if (!read_line(line, &view)) continue;
        for (size_t i = 0; i < count; ++i)
          if (fs::path(options.panoramas[i]).stem().string() == view.panorama) study.views[i] = view;
      }
  }
  const Stage stage;
  const ShotPicture picture(stage.object, stage.grains, stage.grain_radius);
  size_t done = 0;
  for (size_t i = 0; i < count; ++i) {
    if (!study.views[i].done) {
      study.views[i] = study_view(options, stage, picture, i);
      std::string text = key_of(options);
      for (const ShotView& view : study.views)
        if (view.done) text += line_of(view);
      if (!memory.empty()) write_file(memory, text);
    }
    if (!progress(++done)) break;
  }
  sum_up(&study);
  return study;
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
  for (const ShotVariant worse : {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light})
    against(ShotVariant::labels, worse);
  if (study.has_estimate) {
    against(ShotVariant::labels, ShotVariant::estimate);
    for (const ShotVariant worse : {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light})
      against(ShotVariant::estimate, worse);
    for (const ShotView& view : study.views)
      if (view.done && view.errors[4][0] > view.errors[3][0]) {
        std::snprintf(cell, sizeof cell, "%.0f", view.angle_deg);
        text += "\nWorse than an arbitrary light: " + view.panorama + ", " + cell + " degrees off.";
      }
    text += "\n";
  }
  return text;
}

}  // namespace sandglass::host

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
#include "models/lighting/probe_scene.h"
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
    // Of the grains, as in a frame.
    sandglass_pile_shadow_run(pile.handle(), grains.data(), static_cast<uint32_t>(grains.size() / 3), grain_radius,
                              ~0u);
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
  return "shot study 6." + std::to_string(o.seed) + ": " + std::to_string(o.width) + " x " + std::to_string(o.height) +
         ", " + std::to_string(o.paths) + " paths, network '" + fs::path(o.network).filename().string() + "'\n";
}

ShotView study_view(const ShotStudyOptions& options, const Stage& stage, const ShotPicture& picture, size_t index) {
  ShotView view;
  view.panorama = fs::path(options.panoramas[index]).stem().string();
  const double azimuth = 360.0 * random_stream(index, k_azimuth_stream + options.seed).uniform();
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
  measure(ShotVariant::plain_shadow, labels, CastShadow::plain);
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
  constexpr const char* k_names[] = {"true labels",     "no shadow",    "hard shadow",
                                     "arbitrary light", "plain shadow", "estimate"};
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

namespace {

using PilePart = PileShadowError::Part;

void add_texel(PilePart* part, double truth, double shown) {
  part->rmse += (shown - truth) * (shown - truth), part->without += (1.0 - truth) * (1.0 - truth);
  part->bias += shown - truth, ++part->texels;
}

void finish(PilePart* sums) {
  const double n = std::max(1, sums->texels);
  sums->rmse = std::sqrt(sums->rmse / n), sums->without = std::sqrt(sums->without / n), sums->bias /= n;
}

constexpr PilePart PileShadowError::*k_pile_parts[] = {&PileShadowError::clear, &PileShadowError::among_grains,
                                                       &PileShadowError::on_sand};
constexpr double k_pile_limits[] = {0.105, 0.295, 0.385};  // what was measured, and a quarter
constexpr double k_pile_shares[] = {0.45, 0.45, 0.8};      // of what leaving it out costs
constexpr double k_pile_bias_limit = 0.05;                 // on the floor

}  // namespace

std::vector<PileShadowError> study_pile_shadow() {
  constexpr double k_degree = 3.141592653589793 / 180.0, k_lit = 0.98;
  constexpr uint32_t k_stride = 3;         // texels
  constexpr int k_places = 3, k_rays = 4;  // a texel and axis; a place and axis
  const Stage stage;
  const ShotPicture picture(stage.object, stage.grains, stage.grain_radius);
  std::vector<PileShadowError> all;
  // Within what textures are made for, 70 degrees.
  for (const double polar : {20.0, 45.0, 65.0})
    for (const double azimuth : {30.0, 150.0, 270.0}) {
      const Vec3 towards = {std::sin(polar * k_degree) * std::cos(azimuth * k_degree), std::cos(polar * k_degree),
                            std::sin(polar * k_degree) * std::sin(azimuth * k_degree)};
      const ShotShadows shadows = stage.shadows_for(towards);
      const FloorShadow &texture = shadows.pile[0], &on_sand = shadows.pile_surface[0];
      PileShadowError e = {polar, azimuth, {}, {}, {}};
      for (uint32_t v = 0; v < texture.texels; v += k_stride)
        for (uint32_t u = 0; u < texture.texels; u += k_stride) {
          double truth = 0.0, shown = 0.0, seen = 0.0, lit = 0.0, drawn = 0.0, facing = 0.0;
          for (int i = 0; i < k_places * k_places; ++i) {
            const double across = (u + (i % k_places + 0.5) / k_places) / texture.texels,
                         along = (v + (i / k_places + 0.5) / k_places) / texture.texels;
            const double x = texture.low[0] + across * (texture.high[0] - texture.low[0]);
            const double z = texture.low[1] + along * (texture.high[1] - texture.low[1]);
            if (picture.grains_leave(x, z, {0, 1, 0}, 0.0, 1) == 0.0) {  // under a grain
              double cosine = 0.0;
              const double open = picture.grain_lit(x, z, towards, k_light_half_angle_deg * k_degree, k_rays, &cosine);
              lit += cosine * open, drawn += cosine * floor_transparency(on_sand, x, z), facing += cosine;
              continue;
            }
            truth += picture.grains_leave(x, z, towards, k_light_half_angle_deg * k_degree, k_rays);
            shown += floor_transparency(texture, x, z), seen += 1.0;
          }
          if (facing > 0.0) add_texel(&e.on_sand, lit / facing, drawn / facing);
          if (seen == 0.0 || (truth > k_lit * seen && shown > k_lit * seen)) continue;
          add_texel(seen == k_places * k_places ? &e.clear : &e.among_grains, truth / seen, shown / seen);
        }
      for (const auto part : k_pile_parts) finish(&(e.*part));
      all.push_back(e);
    }
  return all;
}

PileShadowError whole_of(const std::vector<PileShadowError>& lights) {
  PileShadowError whole = {};
  for (const auto of : k_pile_parts) {
    PilePart& sum = whole.*of;
    for (const PileShadowError& e : lights) {
      const PilePart& part = e.*of;
      sum.rmse += part.rmse * part.rmse * part.texels, sum.without += part.without * part.without * part.texels;
      sum.bias += part.bias * part.texels, sum.texels += part.texels;
    }
    finish(&sum);
  }
  return whole;
}

bool holds(const PileShadowError& whole) {
  for (size_t i = 0; i < 3; ++i) {
    const PilePart& part = whole.*k_pile_parts[i];
    const bool floor = &part != &whole.on_sand;
    if (part.texels == 0 || part.rmse > k_pile_limits[i] || part.rmse > k_pile_shares[i] * part.without ||
        (floor && std::fabs(part.bias) > k_pile_bias_limit))
      return false;
  }
  return true;
}

std::string pile_shadow_text(const std::vector<PileShadowError>& lights) {
  std::string text =
      "| light, from the zenith; azimuth | RMSE, clear floor | without | bias | texels | among grains | without | bias "
      "| "
      "texels | on the sand | without | bias | texels |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  char cell[80];
  const auto add = [&](const char* name, const PileShadowError& e) {
    text += std::string("| ") + name + " |";
    for (const auto of : k_pile_parts) {
      const PilePart& part = e.*of;
      std::snprintf(cell, sizeof cell, " %.4f | %.4f | %+.4f | %d |", part.rmse, part.without, part.bias, part.texels);
      text += cell;
    }
    text += "\n";
  };
  for (const PileShadowError& e : lights) {
    char name[48];
    std::snprintf(name, sizeof name, "%.0f; %.0f degrees", e.polar_deg, e.azimuth_deg);
    add(name, e);
  }
  const PileShadowError whole = whole_of(lights);
  char name[96];
  std::snprintf(name, sizeof name, "all; limits %.3f, %.3f, %.3f, of bias %.2f: %s", k_pile_limits[0], k_pile_limits[1],
                k_pile_limits[2], k_pile_bias_limit, holds(whole) ? "holds" : "FAILS");
  add(name, whole);
  return text;
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
  for (const ShotVariant worse :
       {ShotVariant::no_shadow, ShotVariant::hard_shadow, ShotVariant::arbitrary_light, ShotVariant::plain_shadow})
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

}  // namespace sandglass::host

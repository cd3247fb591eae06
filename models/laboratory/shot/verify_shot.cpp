#include "models/laboratory/shot/verify_shot.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/laboratory/shot/shot_stage.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/panorama_file.h"
#include "runtime/core/hash.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr uint64_t k_azimuth_stream = 61;

void put(const ShotErrors& e, double (&row)[k_shot_metrics]) {
  const ImageErrors& i = e.image;
  const double values[k_shot_metrics] = {
      i.rmse, i.relative, i.scale_invariant, i.logarithmic, i.angle_deg, 1.0 - e.similarity, e.flip};
  std::copy_n(values, k_shot_metrics, row);
}

// The hash of a file's content. By name alone, a retrained network would get the rows of the one before it.
uint64_t hash_of(const std::string& file, const std::string& kind) {
  const std::string bytes = read_file(file, kind);
  return hash_bytes(bytes.data(), bytes.size());
}

// What the views of one study share.
struct Study {
  const ShotStudyOptions& options;
  const ShotStage stage;
  const ShotPicture picture;

  explicit Study(const ShotStudyOptions& o) : options(o), picture(stage.object, stage.grains, stage.grain_radius) {}
};

std::string key_of(const ShotStudyOptions& o) {
  const uint64_t network = o.network.empty() ? 0 : hash_of(o.network, "lighting network");
  return "shot study 8." + std::to_string(o.seed) + ": " + std::to_string(o.picture.width) + " x " +
         std::to_string(o.picture.height) + ", " + std::to_string(o.picture.paths) + " paths, network " +
         std::to_string(network);
}

// The views that the options ask for, before any is computed. It reads every file, so that a bad one is reported at
// once, not after minutes.
std::vector<ShotView> planned_views(const ShotStudyOptions& options) {
  if (!options.network.empty()) LightEstimate(options.network, SANDGLASS_ISA_AUTOMATIC);
  std::vector<ShotView> views(std::min(options.views, options.panoramas.size()));
  for (size_t i = 0; i < views.size(); ++i) {
    read_panorama(options.panoramas[i]);
    views[i].panorama = fs::path(options.panoramas[i]).stem().string();
    views[i].panorama_hash = hash_of(options.panoramas[i], "panorama");
    views[i].azimuth_deg = 360.0 * random_stream(i, k_azimuth_stream + options.seed).uniform();
  }
  return views;
}

void measure_view(const Study& study, size_t index, ShotView* view) {
  const ShotStudyOptions& options = study.options;
  const Camera& resting = *study.stage.scene.camera;
  RadianceMap map = read_panorama(options.panoramas[index]);
  fill_tripod(&map);
  const Surroundings room =
      panorama_surroundings(std::move(map), view->panorama, resting, view->azimuth_deg, {}, k_unknown_depth_insertion);
  const ShotCamera camera = resting_camera(resting);
  const RadianceMap truth = study.picture.truth(room, camera, options.picture);
  const ShotLight labels = labelled_light(room), arbitrary = arbitrary_light(camera);
  std::vector<Picture> cells = {picture_of(truth)};
  const auto measure = [&](ShotVariant variant, const ShotLight& light, CastShadow cast) {
    const RadianceMap made =
        study.picture.composite(room, camera, light, study.stage.shadows_for(light.towards), cast, options.picture);
    put(shot_errors(truth, made), view->errors[static_cast<int>(variant)]);
    cells.push_back(picture_of(made));
  };
  measure(ShotVariant::labels, labels, CastShadow::textures);
  measure(ShotVariant::no_shadow, labels, CastShadow::none);
  measure(ShotVariant::hard_shadow, labels, CastShadow::hard);
  measure(ShotVariant::arbitrary_light, arbitrary, CastShadow::textures);
  measure(ShotVariant::no_curve, labels, CastShadow::no_curve);
  if (!options.network.empty()) {
    LightEstimate estimate(options.network, SANDGLASS_ISA_AUTOMATIC);
    estimate.take(room, camera, 0);
    estimate.finish();
    const ShotLight light = estimate.light();
    measure(ShotVariant::estimate, light, CastShadow::textures);
    view->has_estimate = true;
    view->angle_deg = std::acos(std::clamp(dot(light.towards, labels.towards), -1.0, 1.0)) * 180.0 / 3.141592653589793;
  }
  if (!options.folder.empty())
    write_png((fs::path(options.folder) / ("view_" + std::to_string(index) + ".png")).string(),
              picture_grid(cells, static_cast<int>(cells.size()), 2));
  view->done = true;
}

}  // namespace

ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress) {
  ShotStudy result;
  result.views = planned_views(options);
  if (result.views.empty()) return result;
  const std::string key = key_of(options);
  const std::string memory = options.folder.empty() ? "" : (fs::path(options.folder) / "views.txt").string();
  std::error_code ignored;
  if (!memory.empty() && fs::is_regular_file(memory, ignored)) remember(read_file(memory, "study"), key, &result.views);
  const Study study(options);
  size_t done = 0;
  for (size_t i = 0; i < result.views.size(); ++i) {
    if (!result.views[i].done) {
      measure_view(study, i, &result.views[i]);
      std::string text = key + "\n";
      for (const ShotView& view : result.views)
        if (view.done) text += line_of(view);
      if (!memory.empty()) write_file(memory, text);
    }
    if (!progress(++done)) break;
  }
  take_means(&result);
  return result;
}

}  // namespace sandglass::host

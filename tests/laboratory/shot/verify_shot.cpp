#include "tests/laboratory/shot/verify_shot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/compositing/light_estimate.h"
#include "models/compositing/shot.h"
#include "models/lighting/dataset.h"
#include "models/rooms/panorama_file.h"
#include "runtime/math/random.h"
#include "tests/laboratory/interval.h"
#include "tests/laboratory/room/session.h"
#include "tests/laboratory/shot/shot_stage.h"

namespace sandglass::host {

namespace {

constexpr uint64_t k_azimuth_stream = 61;

// What an app could draw. The mean light is that of all other places: brightness and harmonics.
enum Variant {
  k_no_shadow,   // mean light, nothing falls on the floor: an app without any estimate
  k_ambient,     // the same with the ambient shadows of an even sky
  k_turn,        // the room as a session has seen it in a full turn
  k_truth,       // the true light, in cells and nine harmonics
  k_mirrored,    // control: the full turn as in a mirror
  k_other_room,  // control: the full turn of another place, at this one's level
  k_variants
};
constexpr const char* k_names[k_variants] = {
    "no shadow, mean light",   "ambient shadow alone, mean light", "a full turn",
    "the true light in cells", "control: a full turn, mirrored",   "control: a full turn in another room"};

enum Metric { k_flip, k_similarity, k_rmse, k_metrics };
constexpr const char* k_metric_names[k_metrics] = {"FLIP", "1 - SSIM", "RMSE"};  // all are 0 at best

struct ShotView {
  std::string file;
  std::string place;         // several panoramas may show one
  double azimuth_deg = 0.0;  // where the camera looks
  ShotLight truth, turn;
  double errors[k_variants][k_metrics] = {};
};

// Reads every file, so that a bad one is reported at once and not after minutes.
std::vector<ShotView> planned_views(const ShotVerdictOptions& options) {
  if (!options.network.empty()) LightEstimate(options.network, SANDGLASS_ISA_AUTOMATIC);
  const std::string manifest = read_locations(options.manifest);
  std::vector<ShotView> views(options.panoramas.size());
  for (size_t i = 0; i < views.size(); ++i) {
    read_panorama(options.panoramas[i]);
    views[i].file = options.panoramas[i];
    views[i].place = location_of(options.panoramas[i], manifest).name;
    views[i].azimuth_deg = 360.0 * random_stream(i, k_azimuth_stream + options.seed).uniform();
  }
  return views;
}

// What is known of the light of a view before a picture is made: the truth, and what a session has seen.
void take_lights(const ShotVerdictOptions& options, const ShotStage& stage, size_t index, ShotView* view) {
  const Surroundings room = stage.captured(view->file, view->azimuth_deg);
  view->truth = room.true_light();
  const Vec3 ahead = resting_camera(*stage.scene.camera).forward;
  const SessionOptions session = {std::atan2(ahead.z, ahead.x), true, mix_bits(options.seed + 1000 * index)};
  sandglass_estimator_light estimate = {};
  if (!options.network.empty()) {
    RoomLight network(options.network);
    estimate = estimate_of_table(room.panorama, session, &network);
  }
  view->turn = light_of_session(room, Session::full_turn, session, estimate.valid != 0 ? &estimate : nullptr);
}

double level_of(const ShotLight& light) { return luminance(irradiance_of(light)); }

// The mean light of all other places, with the shadows of an even sky.
ShotLight mean_of_others(const std::vector<ShotView>& views, const ShotView& view) {
  std::vector<ShotLight> others;
  for (const ShotView& other : views)
    if (other.place != view.place) others.push_back(other.truth);
  if (others.empty()) others.push_back(view.truth);
  ShotLight mean = mean_light(others);
  std::fill_n(mean.cells, SANDGLASS_LIGHT_CELLS, 1.0f / SANDGLASS_LIGHT_CELLS);
  std::copy_n(mean.cells, SANDGLASS_LIGHT_CELLS, mean.ambient_cells);
  return mean;
}

void measure(const ShotVerdictOptions& options, const ShotStage& stage, const ShotPicture& picture, size_t index,
             std::vector<ShotView>* views) {
  ShotView& view = (*views)[index];
  const Surroundings room = stage.captured(view.file, view.azimuth_deg);
  const ShotCamera camera = resting_camera(*stage.scene.camera);
  const RadianceMap truth = picture.truth(room, camera, options.picture);
  const auto draw = [&](Variant variant, const ShotLight& light, CastShadow cast = CastShadow::textures) {
    const ShotErrors e =
        shot_errors(truth, picture.composite(room, camera, light, stage.shadows_for(light), cast, options.picture));
    const double errors[k_metrics] = {e.flip, 1.0 - e.similarity, e.rmse};
    std::copy_n(errors, k_metrics, view.errors[variant]);
  };
  const ShotLight mean = mean_of_others(*views, view);
  const ShotLight& other = (*views)[(index + views->size() / 2) % views->size()].turn;
  draw(k_no_shadow, mean, CastShadow::none);
  draw(k_ambient, mean);
  draw(k_turn, view.turn);
  draw(k_truth, view.truth);
  draw(k_mirrored, mirrored(view.turn));
  draw(k_other_room, scaled(other, level_of(view.turn) / level_of(other)));
}

std::vector<Verdict> judge(const std::vector<ShotView>& views) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  const auto over_places = [&](const std::function<double(const ShotView&)>& value) {
    std::vector<std::pair<std::string, double>> values;
    for (const ShotView& view : views) values.emplace_back(view.place, value(view));
    const std::vector<double> places = place_means(values);
    const Interval i = interval_of(places);
    return places.size() > 1 ? i : Interval{i.mean, -k_infinity, k_infinity};  // one place shows nothing
  };
  std::vector<Verdict> rows;
  for (int v = 0; v < k_variants; ++v)
    for (int m = 0; m < k_metrics; ++m) {
      const double mean = over_places([&](const ShotView& view) { return view.errors[v][m]; }).mean;
      rows.push_back({"whole picture", std::string(k_names[v]) + ", " + k_metric_names[m], "", 0.0, mean, k_infinity,
                      true, false});
    }
  const auto against = [&](Variant first, Variant second, Metric metric) {
    return over_places([&](const ShotView& view) { return view.errors[first][metric] - view.errors[second][metric]; });
  };
  const auto tell = [&](Variant first, Variant second) {
    for (const Metric metric : {k_rmse, k_similarity, k_flip}) {
      const Interval d = against(first, second, metric);
      const std::string name = std::string(k_names[first]) + " less " + k_names[second] + ", " + k_metric_names[metric];
      rows.push_back({"whole picture", name, "", 0.0, d.mean, k_infinity, true, false});
      rows.push_back({"whole picture", name + ", half", "", 0.0, 0.5 * (d.high - d.low), k_infinity, true, false});
    }
  };
  tell(k_turn, k_no_shadow);
  tell(k_turn, k_ambient);
  const auto must_win = [&](Variant first, Variant second, Metric metric) {
    const double result = against(first, second, metric).high;
    rows.push_back({"whole picture",
                    std::string(k_names[first]) + " better than " + k_names[second] + ", " + k_metric_names[metric],
                    "upper end", 0.0, result, 0.0, result < 0.0, false});
  };
  for (const Variant v : {k_turn, k_truth})
    for (const Metric metric : {k_flip, k_similarity, k_rmse}) must_win(v, k_no_shadow, metric);
  for (const Variant control : {k_mirrored, k_other_room}) {
    const double result = against(control, k_turn, k_flip).low;
    rows.push_back({"whole picture", std::string(k_names[control]) + ", FLIP beyond a full turn's", "lower end", 0.0,
                    result, 0.0, result > 0.0, true});
  }
  return rows;
}

}  // namespace

std::vector<Verdict> verify_shots(const ShotVerdictOptions& options, const std::function<bool(size_t done)>& progress) {
  std::vector<ShotView> views = planned_views(options);
  const ShotStage stage;
  for (size_t i = 0; i < views.size(); ++i) take_lights(options, stage, i, &views[i]);
  const ShotPicture picture(stage.object, stage.sand);
  for (size_t i = 0; i < views.size(); ++i) {
    measure(options, stage, picture, i, &views);
    if (!progress(i + 1)) return {};
  }
  return judge(views);
}

}  // namespace sandglass::host

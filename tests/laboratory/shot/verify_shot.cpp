#include "tests/laboratory/shot/verify_shot.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/panorama_file.h"
#include "runtime/core/hash.h"
#include "runtime/core/random.h"
#include "tests/laboratory/room/session.h"
#include "tests/laboratory/shot/shot_stage.h"

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
uint64_t hash_of(const std::string& file, const std::string& kind, uint64_t limit) {
  const std::string bytes = read_file(file, kind, limit);
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
  const uint64_t network = o.network.empty() ? 0 : hash_of(o.network, "lighting network", k_asset_limit);
  std::string key = "shot study 10." + std::to_string(o.seed) + ": " + std::to_string(o.picture.width) + " x " +
                    std::to_string(o.picture.height) + ", " + std::to_string(o.picture.paths) + " paths, network " +
                    std::to_string(network) + ", of";
  // A view depends on the others by their mean light.
  for (const std::string& file : o.panoramas) key += " " + fs::path(file).stem().string();
  return key;
}

// The views that the options ask for, before any is computed. It reads every file, so that a bad one is reported at
// once, not after minutes.
std::vector<ShotView> planned_views(const ShotStudyOptions& options) {
  if (!options.network.empty()) LightEstimate(options.network, SANDGLASS_ISA_AUTOMATIC);
  const std::string manifest = read_locations(options.manifest);
  std::vector<ShotView> views(options.panoramas.size());
  for (size_t i = 0; i < views.size(); ++i) {
    read_panorama(options.panoramas[i]);
    views[i].panorama = fs::path(options.panoramas[i]).stem().string();
    views[i].place = location_of(options.panoramas[i], manifest).name;
    views[i].panorama_hash = hash_of(options.panoramas[i], "panorama", k_file_limit);
    views[i].azimuth_deg = 360.0 * random_stream(i, k_azimuth_stream + options.seed).uniform();
  }
  return views;
}

Surroundings room_of(const Study& study, size_t index, const ShotView& view) {
  RadianceMap map = read_panorama(study.options.panoramas[index]);
  fill_tripod(&map);
  return panorama_surroundings(std::move(map), view.panorama, *study.stage.scene.camera, view.azimuth_deg, {},
                               k_object_insertion);
}

// What is known of the light of a view before a picture is made.
struct ViewLights {
  ShotLight truth, turn, turn_short, one;
};

ViewLights lights_of(const Study& study, const Surroundings& room, size_t index) {
  ViewLights lights = {room.true_light(), {}, {}, {}};
  const Vec3 ahead = resting_camera(*study.stage.scene.camera).forward, place = room.view.direction() * room.insertion;
  const double at[3] = {place.x, place.y, place.z};
  const SessionOptions options = {std::atan2(ahead.z, ahead.x), true, mix_bits(study.options.seed + 1000 * index)};
  sandglass_light_estimate estimate = {};
  if (!study.options.network.empty()) {
    RoomLight network(study.options.network);
    estimate = estimate_of_table(room.panorama, options, &network);
    LightEstimate alone(study.options.network, SANDGLASS_ISA_AUTOMATIC);
    alone.take(room, resting_camera(*study.stage.scene.camera), 0);
    alone.finish();
    lights.one = alone.light();
  }
  for (const auto& [session, light] :
       {std::pair(Session::full_turn, &lights.turn), std::pair(Session::full_turn_short, &lights.turn_short)}) {
    const SeenRoom seen = look_around(room.panorama, session, options);
    light->struct_size = sizeof *light;
    room_estimate(seen.room, k_room_model, at, estimate.valid != 0 ? &estimate : nullptr, light);
    *light = scaled(*light, room.exposure / seen.exposure);
  }
  return lights;
}

double level_of(const ShotLight& light) { return luminance(irradiance_of(light)); }

// The mean light of all other places, with the shadows of an even sky.
ShotLight mean_of_others(const std::vector<ShotView>& views, const std::vector<ViewLights>& lights, size_t index) {
  std::vector<ShotLight> others;
  for (size_t i = 0; i < views.size(); ++i)
    if (views[i].place != views[index].place || views.size() == 1) others.push_back(lights[i].truth);
  if (others.empty()) others.push_back(lights[index].truth);
  ShotLight mean = mean_light(others);
  std::fill_n(mean.cells, SANDGLASS_LIGHT_CELLS, 1.0f / SANDGLASS_LIGHT_CELLS);
  std::copy_n(mean.cells, SANDGLASS_LIGHT_CELLS, mean.ambient_cells);
  return mean;
}

void measure_view(const Study& study, size_t index, const std::vector<ViewLights>& all, std::vector<ShotView>* views) {
  const ShotStudyOptions& options = study.options;
  ShotView& view = (*views)[index];
  const Surroundings room = room_of(study, index, view);
  const ShotCamera camera = resting_camera(*study.stage.scene.camera);
  const RadianceMap truth = study.picture.truth(room, camera, options.picture);
  const ViewLights& lights = all[index];
  const ShotLight mean = mean_of_others(*views, all, index), label = labelled_light(room);
  std::vector<Picture> cells = {picture_of(truth)};
  const auto measure = [&](ShotVariant variant, const ShotLight& light, CastShadow cast = CastShadow::textures) {
    const RadianceMap made =
        study.picture.composite(room, camera, light, study.stage.shadows_for(light), cast, options.picture);
    put(shot_errors(truth, made), view.errors[static_cast<int>(variant)]);
    cells.push_back(picture_of(made));
  };
  using V = ShotVariant;
  measure(V::no_shadow, mean, CastShadow::none);
  measure(V::ambient, mean);
  view.has_network = !options.network.empty();
  if (view.has_network) measure(V::one_light, lights.one);
  measure(V::turn, lights.turn);
  measure(V::turn_short, lights.turn_short);
  measure(V::truth, lights.truth);
  measure(V::turn_shadow, mixed(lights.turn, lights.truth));
  measure(V::turn_shading, mixed(lights.truth, lights.turn));
  measure(V::turn_level, scaled(lights.turn, level_of(lights.truth) / level_of(lights.turn)));
  measure(V::mirrored, mirrored(lights.turn));
  const ShotLight& other = all[(index + all.size() / 2) % all.size()].turn;
  measure(V::other_room, scaled(other, level_of(lights.turn) / level_of(other)));
  measure(V::label, label);
  measure(V::label_no_shadow, label, CastShadow::none);
  measure(V::label_hard, label, CastShadow::hard);
  measure(V::arbitrary, arbitrary_light(camera, irradiance_of(mean)));
  const ShotLight level = scaled(mean, level_of(lights.truth) / level_of(mean));
  measure(V::no_shadow_level, level, CastShadow::none);
  measure(V::ambient_level, level);
  const double cosine = dot(mean_direction_of(lights.turn), mean_direction_of(lights.truth));
  view.angle_deg = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / 3.141592653589793;
  view.log_level = std::log(level_of(lights.turn) / level_of(lights.truth));
  if (!options.folder.empty())
    write_png((fs::path(options.folder) / ("view_" + view.panorama + ".png")).string(), picture_grid(cells, 4, 2));
  view.done = true;
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
  std::vector<ViewLights> lights;
  if (!std::all_of(result.views.begin(), result.views.end(), [](const ShotView& view) { return view.done; }))
    for (size_t i = 0; i < result.views.size(); ++i)
      lights.push_back(lights_of(study, room_of(study, i, result.views[i]), i));
  size_t done = 0;
  for (size_t i = 0; i < result.views.size(); ++i) {
    if (!result.views[i].done) {
      measure_view(study, i, lights, &result.views);
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

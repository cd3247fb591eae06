#include "tests/laboratory/room/studied_places.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include "models/lighting/dataset.h"
#include "models/lighting/labels.h"
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "models/work/progress.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

OneLight true_label(const RadianceMap& panorama, double azimuth, double radius) {
  const View view = {0.5 * std::numbers::pi, azimuth};
  const LightLabels labels = labels_of(warp(panorama, view, radius, 512, 256), {0, 1, 0}, greatest_luminance(panorama));
  return {ViewRotation(view).to_panorama(labels.direction),
          labels.has_direction ? labels.contrast * labels.concentration : 0.0};
}

// A panorama as sessions see it.
RadianceMap coarse_panorama(const std::string& file) {
  RadianceMap panorama = read_panorama(file);
  fill_tripod(&panorama);
  return shrunk(panorama, 2);
}

double azimuth_of(uint32_t index, const RoomStudyOptions& options) {
  return 2.0 * std::numbers::pi * index / options.azimuths;
}

}  // namespace

std::vector<FloorObject> study_objects(const std::vector<std::string>& named, const std::string& data_folder,
                                       ThreadPool* pool) {
  std::vector<std::string> names = named;
  if (names.empty()) {
    names = {"chair", "trefoil", "bucket"};
    const std::string armadillo = data_folder + "/meshes/armadillo.obj";
    if (!data_folder.empty() && std::filesystem::exists(armadillo)) names.insert(names.begin() + 1, armadillo);
  }
  std::vector<FloorObject> objects;
  for (const std::string& name : names)
    objects.emplace_back(stem_of(name), named_mesh(name).mesh, objects.size() + 1, pool);
  return objects;
}

StudiedPlace place_in(const RadianceMap& panorama, double azimuth, double radius,
                      const std::vector<FloorObject>& objects) {
  StudiedPlace place;
  place.place = {radius * std::cos(azimuth), -k_eye_height, radius * std::sin(azimuth)};
  place.light = true_light(panorama, place.place);
  place.parts = true_parts(panorama);
  place.label = true_label(panorama, azimuth, radius);
  for (const FloorObject& object : objects) place.truths.push_back(object.truth(place.light));
  return place;
}

RoomStudy study_rooms(const RoomStudyOptions& options, std::shared_ptr<const std::vector<FloorObject>> objects) {
  RoomStudy study = {std::move(objects), {}};
  const std::string manifest = read_locations(options.manifest);
  const std::vector<std::string>& files = options.panoramas;
  Progress progress("looking around", files.size());
  std::optional<RoomLight> network;
  if (!options.network.empty()) network.emplace(options.network);
  ThreadPool pool(options.threads);
  for (size_t i = 0; i < files.size() && !interrupted(); ++i) {
    const RadianceMap coarse = coarse_panorama(files[i]);
    const Location location = location_of(files[i], manifest);
    const auto seed_of = [&](uint32_t a) { return mix_bits(options.seed + 1000 * i + a); };
    std::vector<StudiedPlace> places(options.azimuths);
    pool.run(options.azimuths, [&](uint32_t a) {
      const double azimuth = azimuth_of(a, options);
      places[a] = place_in(coarse, azimuth, options.place, *study.objects);
      places[a].panorama = files[i];
      places[a].location = location.name;
      for (const Session session : k_sessions)
        places[a].sessions.push_back(look_around(coarse, session, {azimuth, options.exposure_known, seed_of(a)}));
      places[a].unguarded = look_around(coarse, k_unguarded, {azimuth, options.exposure_known, seed_of(a), false});
      const SeenRoom& turn = places[a].sessions[static_cast<size_t>(Session::full_turn)];
      places[a].probes = probe_lights(coarse, turn, options.exposure_known, places[a].place);
    });
    for (uint32_t a = 0; a < options.azimuths && network; ++a) {
      const sandglass_estimator_light e =
          estimate_of_table(coarse, {azimuth_of(a, options), true, seed_of(a)}, &*network);
      places[a].network = e;
      places[a].estimates = {{Vec3{e.direction[0], e.direction[1], e.direction[2]}, static_cast<double>(e.contrast)}};
    }
    for (StudiedPlace& place : places) study.places.push_back(std::move(place));
    progress.done(i + 1);
  }
  return study;
}

}  // namespace sandglass::host

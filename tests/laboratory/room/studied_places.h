// Places in panoramas that shadows are judged at: the light that is there, what the floor beside each object receives of
// it, and what a session of an app has seen.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "models/work/thread_pool.h"
#include "tests/laboratory/interval.h"
#include "tests/laboratory/room/floor.h"
#include "tests/laboratory/room/probes.h"

namespace sandglass::host {

// The chair, the armadillo where the data folder has one, and two made by formula.
std::vector<FloorObject> study_objects(const std::vector<std::string>& named, const std::string& data_folder,
                                       ThreadPool* pool);

// A light as the sole one: its direction in the panorama's frame, and its share of the floor's irradiance.
struct OneLight {
  Vec3 direction;
  double share = 0.0;
};

// Of the panorama's camera above the floor, in radii.
constexpr double k_eye_height = 0.25;

// One panorama, one azimuth: the object stands ahead of the camera there.
struct StudiedPlace {
  std::string panorama, location;
  Vec3 place;
  TrueLight light;
  OneLight label;                            // the true label (5.1), as seen from the object
  std::vector<std::vector<float>> truths;    // the floor's ratio beside each object
  std::vector<SeenRoom> sessions;            // those of k_sessions
  SeenRoom unguarded;                        // control: the last of them, believing what dark bytes say
  PartRadiance parts;                        // the panorama's, of all directions
  std::vector<OneLight> estimates;           // of one light, from an image
  sandglass_estimator_light network = {};    // the network's, as it gives it
  std::vector<sandglass_room_light> probes;  // by k_probe_variants; of objects that were moved there are none
};

constexpr Session k_unguarded = Session::everything_shorter;

struct RoomStudy {
  std::shared_ptr<const std::vector<FloorObject>> objects;
  std::vector<StudiedPlace> places;
};

// What needs no camera. `radius` is where the object stands, in radii ahead of the camera.
StudiedPlace place_in(const RadianceMap& panorama, double azimuth, double radius,
                      const std::vector<FloorObject>& objects);

struct RoomStudyOptions {
  std::vector<std::string> panoramas;  // files
  std::string manifest;                // places and folds; empty: each panorama is its own place
  std::string network;                 // of the estimate of one light; empty: there is none
  double place = 0.25;                 // of the object, in radii ahead of the camera
  uint32_t azimuths = 4;               // sessions begin at so many azimuths of each panorama
  bool exposure_known = true;          // whether the app says how images were exposed
  uint64_t seed = 1;
  uint32_t threads = 1;
};

// Throws a Failure for a file that is no panorama. Stops early, with what it has, when it is interrupted.
RoomStudy study_rooms(const RoomStudyOptions& options, std::shared_ptr<const std::vector<FloorObject>> objects);

// The mean of a measure over each place, by its location.
template <class Measure>
std::vector<double> by_location(const RoomStudy& study, const Measure& measure) {
  std::vector<std::pair<std::string, double>> values;
  for (const StudiedPlace& place : study.places) values.emplace_back(place.location, measure(place));
  return place_means(values);
}

}  // namespace sandglass::host

// Held against rays: the floor beside an object, drawn in the light of a room as far as a session has seen it. The
// constants of the estimate are fitted on some places and reported on others.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/laboratory/room/floor.h"
#include "models/laboratory/room/session.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

struct RoomStudyOptions {
  std::vector<std::string> panoramas;  // files or folders
  std::string manifest;                // places and folds
  double place = 0.25;                 // of the object, in radii ahead of the camera
  uint32_t azimuths = 4;               // sessions begin at so many azimuths of each panorama
  bool exposure_known = true;
  std::string network;  // of the estimate of one light; empty: its rows are left out
  uint64_t seed = 1;
  uint32_t threads = 1;
};

// One panorama, one azimuth: the true light at the object, and what each session has seen.
struct StudiedPlace {
  std::string panorama, location;
  int fold = -1;
  double azimuth = 0.0;
  Vec3 place;
  TrueLight light;
  std::vector<SeenRoom> sessions;               // in the order of k_sessions
  std::vector<FloorObject::Quadratic> objects;  // of each object
  std::vector<std::vector<float>> truths, lit;  // the floor's ratio and the surface, of each object
  sandglass_light_estimate estimate = {};       // of the network, from the image of the table
};

struct RoomStudy {
  std::vector<FloorObject> objects;
  std::vector<StudiedPlace> places;
};

RoomStudy study_rooms(const RoomStudyOptions& options, std::vector<FloorObject> objects);

// The constants that draw the floor best in the places that `use` accepts: the mean over sessions, objects and places.
RoomModel fit_room_model(const RoomStudy& study, const RoomModel& start, bool (*use)(const StudiedPlace&, int fold),
                         int fold, ThreadPool* pool);

// Prints the table: each way to draw the floor by session, with intervals over places.
void print_room_table(const RoomStudy& study, const std::vector<RoomModel>& models_by_fold);

}  // namespace sandglass::host

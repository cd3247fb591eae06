// Held against rays: the floor beside an object and the object's surface, drawn in the light of a room as far as a
// session has seen it, beside what an app could draw instead. Each place's rows are computed with constants that were
// fitted on other places.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "models/laboratory/room/floor.h"
#include "models/laboratory/room/session.h"
#include "models/laboratory/sand/granular_verdicts.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

struct RoomStudyOptions {
  std::vector<std::string> panoramas;  // files
  std::string manifest;                // places and folds; empty: each panorama is its own place
  std::string network;                 // of the estimate of one light; empty: its rows are left out
  double place = 0.25;                 // of the object, in radii ahead of the camera
  uint32_t azimuths = 4;               // sessions begin at so many azimuths of each panorama
  bool exposure_known = true;          // whether the app says how images were exposed
  uint64_t seed = 1;
  uint32_t threads = 1;
};

// One panorama, one azimuth: the true light at the object, and what each session has seen.
struct StudiedPlace {
  std::string panorama, location;
  int fold = -1;
  Vec3 place;
  TrueLight light;
  std::vector<SeenRoom> sessions;               // in the order of k_sessions
  std::vector<FloorObject::Quadratic> objects;  // of each object
  std::vector<std::vector<float>> truths, lit;  // the floor's ratio and the surface, of each object
  struct OneLight {
    Vec3 direction;
    double share = 0.0;  // of the floor's irradiance
    bool known = false;
  } label, estimate;                      // the true label (5.1), and what the network says of the image of the table
  sandglass_light_estimate network = {};  // the latter as the network gives it
};

struct RoomStudy {
  std::vector<FloorObject> objects;
  std::vector<StudiedPlace> places;
};

// Throws a Failure for a file that is no panorama. Stops early, with what it has, when it is interrupted.
RoomStudy study_rooms(const RoomStudyOptions& options, std::vector<FloorObject> objects);

constexpr int k_room_folds = 5;
// The constants that draw the floor best in all places but those of the fold: the mean over sessions, objects and
// places; -1: in all places. Then those that give the best level.
RoomModel fit_room_model(const RoomStudy& study, int left_out, ThreadPool* pool);

struct Interval {
  double mean = 0.0, low = 0.0, high = 0.0;  // 95 %, over places
};

// One way to draw the shadow.
struct DrawnRow {
  std::string name;
  Interval floor, against_none, against_ambient;  // RMSE of the floor's ratio; differences are paired by place
  double share_of_ambient = 0.0;                  // of the mean error of ambient occlusion
  std::vector<double> by_object;
  std::optional<Interval> shading;  // RMSE of the surface's irradiance, as a share of the floor's
  bool control = false;
};

// What a session makes known.
struct SessionRow {
  std::string name;
  Interval seen, direction_deg, level, level_bias;  // |log ratio| and log ratio of the floor's irradiance
  double main_share = 0.0, clipped = 0.0;
};

struct RoomTable {
  size_t places = 0;
  std::vector<std::string> objects;
  std::vector<DrawnRow> drawn;
  std::vector<SessionRow> sessions;
  double zenith_deg = 0.0;  // from the true direction of the floor's light to the zenith
};

// `models`: by fold, 0..k_room_folds - 1, or one for all.
RoomTable room_table(const RoomStudy& study, const std::vector<RoomModel>& models);

std::string room_markdown(const RoomTable& table);
// What the table must show.
std::vector<Verdict> room_verdicts(const RoomTable& table);

}  // namespace sandglass::host

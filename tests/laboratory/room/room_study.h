// Held against rays: the floor beside an object, drawn in the light of a room as far as a session has seen it, beside what
// an app could draw instead. The constants are the shipped ones (k_room_model).
#pragma once

#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/room/studied_places.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// A way to draw an object's shadow, held against rays.
struct DrawnRow {
  std::string name;
  Interval floor, against_none, against_ambient;  // RMSE of the floor's ratio; differences are paired by place
  double share_of_ambient = 0.0;                  // of the mean error of ambient occlusion
  bool control = false;
};

// Throws std::out_of_range.
const DrawnRow& row_of(const std::vector<DrawnRow>& rows, const std::string& name);

// What a session makes known.
struct SessionRow {
  std::string name;
  Interval seen, direction_deg, level;               // |log ratio| of the floor's irradiance
  Interval level_clipped_known, level_unseen_known;  // |log ratio|, were it known what these send out
};

struct RoomTable {
  size_t places = 0;
  std::vector<DrawnRow> drawn;
  std::vector<SessionRow> sessions;
  Interval unguarded;  // |log ratio| of the level, of the control
};

RoomTable room_table(const RoomStudy& study, ThreadPool* pool);

// The same table under a condition: another place of the object, some of the rooms.
struct Condition {
  std::string name;
  RoomTable table;
};
// The places whose panorama has `part` in its path.
RoomStudy rooms_in(const RoomStudy& study, const std::string& part);

void print_room(const RoomTable& table);
// What the tables must show; most of it the first one.
std::vector<Verdict> room_verdicts(const std::vector<Condition>& conditions);
// The numbers of the tables, for --json.
std::vector<Measurement> room_measurements(const std::vector<Condition>& conditions);

}  // namespace sandglass::host

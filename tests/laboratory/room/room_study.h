// Held against rays: the floor beside an object and the object's surface, drawn in the light of a room as far as a
// session has seen it, beside what an app could draw instead. The constants are the shipped ones (k_room_model).
#pragma once

#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/room/floor_rows.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// What a session makes known.
struct SessionRow {
  std::string name;
  Interval seen, direction_deg, level, level_bias;   // |log ratio| and log ratio of the floor's irradiance
  Interval level_clipped_known, level_unseen_known;  // |log ratio|, were it known what these send out
  double main_share = 0.0, clipped = 0.0;
};

struct RoomTable {
  size_t places = 0;
  std::vector<DrawnRow> drawn;
  std::vector<SessionRow> sessions;
  Interval unguarded;       // |log ratio| of the level, of the control
  double zenith_deg = 0.0;  // from the true direction of the floor's light to the zenith
};

RoomTable room_table(const RoomStudy& study, ThreadPool* pool);

// The same table under a condition: another place of the object, some of the rooms.
struct Condition {
  std::string name;
  RoomTable table;
};
// The places whose panorama has `part` in its path.
RoomStudy rooms_in(const RoomStudy& study, const std::string& part);

std::string sessions_markdown(const RoomTable& table);
// The first condition is that of the verdicts.
std::string conditions_markdown(const std::vector<Condition>& conditions);
// What the table must show.
std::vector<Verdict> room_verdicts(const std::vector<Condition>& conditions);
// The numbers of the tables, for --json.
std::vector<Measurement> room_measurements(const std::vector<Condition>& conditions);

}  // namespace sandglass::host

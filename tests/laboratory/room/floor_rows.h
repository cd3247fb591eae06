// Ways to draw an object's shadow, held against rays: a row of the table for each.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sandglass/room.h"
#include "tests/laboratory/room/studied_places.h"

namespace sandglass::host {

// The floor's ratio beside an object.
struct Way {
  std::string name;
  std::function<std::vector<float>(const StudiedPlace&, size_t object)> floor;
  bool control = false;  // is wrong, and must be worse than what it spoils
};

Way no_shadow(const RoomStudy& study);
Way ambient_occlusion(const RoomStudy& study);
Way in_cells(const RoomStudy& study, std::string name, const std::function<Cells(const StudiedPlace&)>& cells,
             bool control = false);
// One light, and ambient occlusion for `ambient` of the rest.
Way one_light(const RoomStudy& study, std::string name, const std::function<OneLight(const StudiedPlace&)>& light,
              double ambient, bool control = false);
// As an app draws it: the ambient shadow, and the sharp one of the main light.
Way in_room(const RoomStudy& study, std::string name,
            const std::function<sandglass_room_light(const StudiedPlace&)>& light);

// All shares of the light, or those of the ambient shadow alone.
Cells cells_of(const sandglass_room_light& light, bool ambient);

struct DrawnRow {
  std::string name;
  Interval floor, against_none, against_ambient;  // RMSE of the floor's ratio; differences are paired by place
  double share_of_ambient = 0.0;                  // of the mean error of ambient occlusion
  bool control = false;
};

// The first way must be no_shadow, the second ambient_occlusion.
std::vector<DrawnRow> drawn_rows(const RoomStudy& study, const std::vector<Way>& ways);
// Throws std::out_of_range.
const DrawnRow& row_of(const std::vector<DrawnRow>& rows, const std::string& name);

}  // namespace sandglass::host

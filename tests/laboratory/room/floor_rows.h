// Ways to draw an object's shadow, held against rays: a row of the table for each.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sandglass/room.h"
#include "tests/laboratory/room/studied_places.h"

namespace sandglass::host {

// The floor's ratio beside an object, and where there is one the light of its surface.
struct Way {
  std::string name;
  std::function<std::vector<float>(const StudiedPlace&, size_t object)> floor, surface;
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
// The light of an object's surface, beside that of the floor.
std::vector<float> surface_in(const FloorObject& object, const sandglass_room_light& light);

struct DrawnRow {
  std::string name;
  Interval floor, against_none, against_ambient;  // RMSE of the floor's ratio; differences are paired by place
  double share_of_ambient = 0.0;                  // of the mean error of ambient occlusion
  std::vector<double> by_object;
  std::optional<Interval> shading;  // RMSE of the surface's irradiance, as a share of the floor's
  bool control = false;
};

// The first way must be no_shadow, the second ambient_occlusion.
std::vector<DrawnRow> drawn_rows(const RoomStudy& study, const std::vector<Way>& ways);
// Throws std::out_of_range.
const DrawnRow& row_of(const std::vector<DrawnRow>& rows, const std::string& name);
std::string drawn_markdown(const RoomStudy& study, const std::vector<DrawnRow>& rows);
std::string number_text(const char* format, double a, double b = 0, double c = 0);

}  // namespace sandglass::host

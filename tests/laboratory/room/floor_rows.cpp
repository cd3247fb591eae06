#include "tests/laboratory/room/floor_rows.h"

#include <algorithm>
#include <stdexcept>

namespace sandglass::host {

namespace {

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> d(a.size());
  for (size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return d;
}

}  // namespace

Way in_cells(const RoomStudy& study, std::string name, const std::function<Cells(const StudiedPlace&)>& cells,
             bool control) {
  return {std::move(name),
          [objects = study.objects, cells](const StudiedPlace& p, size_t o) { return (*objects)[o].drawn(cells(p)); },
          control};
}

Way no_shadow(const RoomStudy& study) {
  return in_cells(study, "no shadow", [](const StudiedPlace&) { return Cells{}; });
}

Way ambient_occlusion(const RoomStudy& study) {
  Cells even;
  even.fill(1.0 / k_light_cells);
  return in_cells(study, "ambient occlusion alone", [even](const StudiedPlace&) { return even; });
}

Way one_light(const RoomStudy& study, std::string name, const std::function<OneLight(const StudiedPlace&)>& light,
              double ambient, bool control) {
  return {std::move(name),
          [objects = study.objects, light, ambient](const StudiedPlace& p, size_t o) {
            const OneLight one = light(p);
            const double share = one.direction.y > 0 ? one.share : 0.0;
            Cells rest;
            rest.fill(ambient * (1 - share) / k_light_cells);
            return (*objects)[o].drawn(rest, share, one.direction);
          },
          control};
}

Way in_room(const RoomStudy& study, std::string name,
            const std::function<sandglass_room_light(const StudiedPlace&)>& light_of) {
  return {std::move(name), [objects = study.objects, light_of](const StudiedPlace& p, size_t o) {
            const sandglass_room_light light = light_of(p);
            return (*objects)[o].drawn(cells_of(light, true), static_cast<double>(light.main_share),
                                       from_floats(light.main_direction));
          }};
}

Cells cells_of(const sandglass_room_light& light, bool ambient) {
  Cells cells;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    cells[i] = static_cast<double>(ambient ? light.ambient_cells[i] : light.cells[i]);
  return cells;
}

std::vector<DrawnRow> drawn_rows(const RoomStudy& study, const std::vector<Way>& ways) {
  const size_t objects = study.objects->size();
  std::vector<DrawnRow> rows;
  std::vector<double> none, ambient;  // by place
  for (const Way& way : ways) {
    DrawnRow row;
    row.name = way.name;
    row.control = way.control;
    std::vector<double> floor;
    for (size_t o = 0; o < objects; ++o) {
      const std::vector<double> errors =
          by_location(study, [&](const StudiedPlace& p) { return error_of(way.floor(p, o), p.truths[o]); });
      floor.resize(errors.size());
      for (size_t i = 0; i < errors.size(); ++i) floor[i] += errors[i] / static_cast<double>(objects);
    }
    if (rows.empty()) none = floor;
    if (rows.size() == 1) ambient = floor;
    row.floor = interval_of(floor);
    row.against_none = interval_of(difference(floor, none));
    if (rows.size() >= 1) row.against_ambient = interval_of(difference(floor, ambient));
    rows.push_back(row);
  }
  rows.front().against_ambient = interval_of(difference(none, ambient));
  for (DrawnRow& row : rows) row.share_of_ambient = row.floor.mean / rows[1].floor.mean;
  return rows;
}

const DrawnRow& row_of(const std::vector<DrawnRow>& rows, const std::string& name) {
  for (const DrawnRow& row : rows)
    if (row.name == name) return row;
  throw std::out_of_range("no way to draw is called " + name);
}

}  // namespace sandglass::host

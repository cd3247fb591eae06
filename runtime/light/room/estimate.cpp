// The light to be expected at a place, from what was seen: read from the sums of sums.h.
//
// What was seen counts four times as long for the level as for the directions. After a while light is likely to come
// from elsewhere, but the room is not likely to be as dark as one that was never seen. So an object does not change
// while the camera rests.
//
// What lies below the horizon of the object is the floor that it stands on, as it was seen around the foot: by the
// parts that lie in the direction of the foot from where the camera saw them.
//
// A floor shadow is linear in the cells. So the shadow of least expected squared error is the one drawn in the expected
// light. Where nothing was seen that is an even sky, and the shadow is soft; a guess of one light is not.
#include "runtime/frame/filled_struct.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/sums.h"
#include "runtime/math/math.h"
#include "runtime/math/plane_axes.h"

namespace sandglass {
namespace {

constexpr double k_stands_out = 3.0;  // times the mean of the cells farther away: a cell may hold a light of its own
constexpr double k_clearly = 1.25;    // another main light takes over where it is so many times as strong
constexpr double k_across = 0.8660254037844386;  // cosine of 30 degrees: cells across the zenith that hold one lamp
constexpr float k_shown = 0.01f;                 // share of a main light that can be seen
constexpr double k_near_foot = 40.0;             // sharpness of what counts as the foot's surroundings: 9 degrees
// A part right at the foot that was seen from above weighs 1. What a part elsewhere weighs, and the usual floor.
constexpr double k_floor_elsewhere = 1e-4, k_floor_unseen = 1e-4;
// While images seem to show another room: the floor's irradiance over pi, as a multiple of their mean radiance, lies
// within these bounds. In 27 captured rooms it is 2.6 in the median.
constexpr double k_other_min = 2, k_other_max = 3;
constexpr double k_floor_max = 0.9;  // reflectance of a floor
// Mean cosine about a light's axis: of one too wide for a sharp shadow, and of one as narrow as a lamp.
constexpr double k_wide = 0.95, k_narrow = 0.99;
constexpr uint32_t k_look_rows = 1, k_look_columns = 2;  // parts to each side that one look takes in

bool are_top(uint32_t a, uint32_t b) {
  return a / k_cell_sectors == k_cell_rings - 1 && b / k_cell_sectors == k_cell_rings - 1;
}

bool beside(uint32_t a, uint32_t b) {
  const uint32_t sectors = (a - b) % k_cell_sectors;
  return sectors <= 1 || sectors == k_cell_sectors - 1;
}

// Cells that touch each other. All of the top ring meet at the zenith.
bool touch(uint32_t a, uint32_t b) {
  const auto rings = static_cast<int>(a / k_cell_sectors) - static_cast<int>(b / k_cell_sectors);
  return rings >= -1 && rings <= 1 && (beside(a, b) || are_top(a, b));
}

// A light of its own: what a seen cell and those that touch it hold beyond the cells farther away.
struct Lamp {
  double mass, moment[3], colour[3];
  double excess[k_light_cells];  // of each cell
};

Lamp lamp_at(const RoomSums& sums, uint32_t middle) {
  constexpr double k_cell = k_pi / k_light_cells;
  Lamp lamp = {};
  double away = 0, count = 0;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (touch(i, middle)) continue;
    away += sums.seen[i];
    ++count;
  }
  const double around = away / count;  // what a cell would hold without the lamp
  const auto moment = [&](uint32_t i, double m[3]) {
    for (int k = 0; k < 3; ++k) m[k] = sums.moments[i][k] - around / k_cell * sums.even_moments[i][k];
  };
  double ahead[3];
  moment(middle, ahead);
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (!touch(i, middle) || !(sums.seen[i] > k_stands_out * around)) continue;
    double there[3];
    moment(i, there);
    // Across the zenith lies another lamp, if not right at it.
    const double along = ahead[0] * there[0] + ahead[1] * there[1] + ahead[2] * there[2];
    if (are_top(i, middle) && !beside(i, middle) && along < k_across * square_root(square_of(ahead) * square_of(there)))
      continue;
    lamp.excess[i] = sums.seen[i] - around;
    lamp.mass += lamp.excess[i];
    const double part = lamp.excess[i] / sums.seen[i];
    for (int k = 0; k < 3; ++k) {
      lamp.moment[k] += there[k];
      lamp.colour[k] += part * sums.cells[i][k];
    }
  }
  return lamp;
}

uint32_t brightest(const RoomSums& sums, const uint32_t* near) {
  uint32_t best = near != nullptr ? *near : 0;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    if (sums.seen[i] > sums.seen[best] && (near == nullptr || (touch(i, *near) && beside(i, *near)))) best = i;
  return best;
}

// The main light is drawn sharp as far as it is narrow. The one that is shown stays until another is clearly stronger:
// else each new image might choose another one of two equal lamps.
void find_main_light(const RoomSums& sums, const RoomModel& model, double total, const uint32_t* shown,
                     sandglass_room_light* out) {
  Lamp lamp = lamp_at(sums, brightest(sums, nullptr));
  if (shown != nullptr) {
    const Lamp stays = lamp_at(sums, brightest(sums, shown));
    if (lamp.mass < k_clearly * stays.mass) lamp = stays;
  }
  const double length =
      square_root(lamp.moment[0] * lamp.moment[0] + lamp.moment[1] * lamp.moment[1] + lamp.moment[2] * lamp.moment[2]);
  const double grey = luminance(lamp.colour);
  if (!(lamp.mass > 0) || !(length > 0) || !(grey > 0)) return;
  double narrow = (length / lamp.mass - k_wide) / (k_narrow - k_wide);
  narrow = narrow < 0 ? 0 : narrow > 1 ? 1 : narrow;
  const double share = model.sharp * narrow / total;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const double taken = share * lamp.excess[i], had = static_cast<double>(out->cells[i]);
    out->ambient_cells[i] = static_cast<float>(had > taken ? had - taken : 0.0);
  }
  double ambient = 0;
  for (const float q : out->ambient_cells) ambient += static_cast<double>(q);
  out->main_share = ambient < 1 ? static_cast<float>(1 - ambient) : 0.0f;
  for (int k = 0; k < 3; ++k) {
    out->main_direction[k] = static_cast<float>(lamp.moment[k] / length);
    out->main_colour[k] = static_cast<float>(lamp.colour[k] / grey);
  }
}

// The floor around the foot as the camera has seen it: its radiance in the room's unit. Returns what that weighs. A
// part weighs the more the nearer it lies to the foot's direction, and the more steeply the camera looked down on it.
double floor_seen(const Room& room, const RoomMemory& memory, const double foot[3], double radiance[3]) {
  double area = 0;
  for (uint32_t i = 0; i < k_room_below; ++i) {
    if (!(memory.known(i) > 0)) continue;
    const bool by_probe = memory.confidence > 0 && !(memory.seen[i] > 0);
    double from[3], part[3], along = 0, to_foot = 0, to_part = 0;
    if (by_probe) room_place(room, room.probe->place, from);
    const uint32_t row = i / k_room_columns;
    room_direction(row + 0.5, i % k_room_columns + 0.5, part);
    double down = 0;
    for (int k = 0; k < 3; ++k) {
      if (!by_probe) from[k] = room.parts[i].from[k] / 127.0;
      const double a = foot[k] - from[k], b = part[k] - from[k];
      along += a * b;
      to_foot += a * a;
      to_part += b * b;
      if (k == 1) down = -a;
    }
    double near = k_floor_elsewhere;
    if (down > 0) {
      const double steep = down * down / to_foot;
      near += steep * steep * exponential(k_near_foot * (along / square_root(to_foot * to_part) - 1));
    }
    const double weight = memory.known(i) * room_part_weight(i) * near;
    const RoomPart known = room_part_of(room, memory, i);
    for (int c = 0; c < 3; ++c) radiance[c] += weight * static_cast<double>(known.radiance[c]) * room.light;
    area += weight;
  }
  if (area > 0)
    for (int c = 0; c < 3; ++c) radiance[c] /= area;
  return area;
}

// The floor's radiance in units of the last image's white.
void find_floor(const Room& room, const RoomModel& model, const RoomMemory& memory, const double foot[3],
                const sandglass_room_place& place, sandglass_room_light* out) {
  double seen[3] = {};
  const double area = place.floor != nullptr ? 0 : floor_seen(room, memory, foot, seen);
  for (int c = 0; c < 3; ++c) {
    const double white = static_cast<double>(out->irradiance[c]) / k_pi, limit = k_floor_max * white;
    double floor = (area * seen[c] / room.scale + k_floor_unseen * model.albedo * white) / (area + k_floor_unseen);
    floor = floor < limit ? floor : limit;
    out->floor[c] = place.floor != nullptr ? place.floor[c] : static_cast<float>(floor);
    for (int i = 0; i < 2; ++i) out->sh[3 * i + c] += static_cast<float>(k_below_harmonics[i]) * out->floor[c];
  }
}

// The direction in which one look takes in most of the sky that was not seen, weighted by what it gives the floor.
void find_look(const Room& room, const RoomMemory& memory, float look[3]) {
  double best_gain = -1, facing[k_room_rows];  // cosine and solid angle of a part of the row
  for (uint32_t row = 0; row < k_room_rows; ++row) {
    const SinCos elevation = sin_cos_turns(((row + 0.5) / k_room_rows - 0.5) / 2);
    facing[row] = elevation.sin > 0 ? elevation.sin * elevation.cos : 0;
  }
  uint32_t best = 0;
  for (uint32_t row = k_room_rows / 2; row < k_room_rows; ++row)
    for (uint32_t column = 0; column < k_room_columns; ++column) {
      double gain = 0;
      for (uint32_t r = row - k_look_rows; r <= row + k_look_rows && r < k_room_rows; ++r)
        for (uint32_t c = 0; c <= 2 * k_look_columns; ++c) {
          const uint32_t at = (column + c + k_room_columns - k_look_columns) % k_room_columns;
          gain += (1 - memory.known(r * k_room_columns + at)) * facing[r];
        }
      if (gain > best_gain) {
        best_gain = gain;
        best = row * k_room_columns + column;
      }
    }
  double direction[3];
  const uint32_t row = best / k_room_columns, column = best % k_room_columns;
  room_direction(row + 0.5, column + 0.5 + room.yaw * k_room_columns, direction);
  for (int k = 0; k < 3; ++k) look[k] = static_cast<float>(direction[k]);
}

// Whether the last image shows all of a part. What its rim cuts is learned from none.
bool is_whole(const RoomView& view, uint32_t part) {
  bool whole = true;
  for (uint32_t corner = 0; corner < 4; ++corner) {
    const uint32_t row = part / k_room_columns + corner / 2, column = part % k_room_columns + corner % 2;
    double direction[3];
    uint32_t x, y;
    room_direction(row, column, direction);
    whole = whole && room_pixel_of(view, direction, &x, &y);
  }
  return whole;
}

// The exposure that the next short image should have, over the ordinary one, so that it shows what is clipped in the
// last image. The darkest of that comes first, because an even shorter image would show it black. 1: nothing is
// clipped.
float short_exposure(const Room& room) {
  constexpr double k_clips = 0.0004;        // share of a part; the sun is a thousandth of its part
  constexpr uint8_t k_size_looks = 12;      // short images for the size of lamps alone
  constexpr int k_octaves[3] = {3, 9, 15};  // by which an image was shorter if this exposure was tried
  uint32_t next = 3;
  for (uint32_t i = k_room_below; i < k_room_parts && room.exposure_known; ++i) {
    const RoomPart& part = room.parts[i];
    if (part.age > 0 || !(part.seen > 0) || part.clipped < k_clips) continue;
    const int steps = room.white[i - k_room_below] - room_quarter_octaves(room.scale);
    if (next > 0 && steps < 4 * k_octaves[next - 1] && !is_whole(room.view, i)) continue;
    while (next > 0 && steps < 4 * k_octaves[next - 1]) --next;
  }
  if (next == 3 && room.exposure_known && room.wants_size && room.size_looks < k_size_looks) next = 0;
  constexpr float k_exposures[4] = {1.0f / 64, 1.0f / 4096, 1.0f / 262144, 1};
  return k_exposures[next];
}

// The irradiance of the floor in units of the last image's white, found in two ways whose logarithms are averaged: from
// the cells, and from how bright the floor looks.
double level_of(const Room& room, const RoomModel& model, const RoomOverview& all, double total, double seen) {
  const double unit = room.light / room.scale;
  double level = total * all.level * unit * exponential(model.unseen_level * (1 - seen));
  if (all.floor > 0) {
    const double by_floor = k_pi * all.floor * unit / model.albedo, weight = model.floor_trust * (1 - seen);
    level = exponential((1 - weight) * logarithm(level) + weight * logarithm(by_floor));
  }
  if (!(room.shows > 0)) return level;
  const double other = k_pi * room.shows / room.scale;
  level = level < k_other_max * other ? level : k_other_max * other;
  return level > k_other_min * other ? level : k_other_min * other;
}

// The unit of the sums, as a multiple of the last image's white.
double unit_of(const Room& room, const RoomModel& model, const RoomOverview& all, const RoomSums& sums) {
  double total = 0, lasting = 0;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    total += luminance(sums.cells[i]);
    lasting += sums.lasting[i];
  }
  return total > 0 ? level_of(room, model, all, lasting, sums.all_lasting / sums.all_even) / total : 0;
}

uint32_t shown_cell(const Room& room, const RoomFacing& plane, const float direction[3]) {
  const double world[3] = {static_cast<double>(direction[0]), static_cast<double>(direction[1]),
                           static_cast<double>(direction[2])};
  double d[3], local[3];
  room_to_sphere(room, world, d);
  plane.turn(d, local);
  return room_cell_of(local, plane.yaw);
}

// The answer for a plane: its cells, its main light, and its irradiance. `unit`: of the sums.
void find_cells(const Room& room, const RoomModel& model, const RoomFacing& plane, const sandglass_room_place& place,
                const RoomSums& sums, double unit, sandglass_room_light* out) {
  double total = 0, colour[3] = {};
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    total += luminance(sums.cells[i]);
    for (int c = 0; c < 3; ++c) colour[c] += sums.cells[i][c];
  }
  // The total is 0 where all that was seen is black: an even sky that gives nothing.
  for (uint32_t i = 0; i < k_light_cells; ++i)
    out->cells[i] = out->ambient_cells[i] =
        total > 0 ? static_cast<float>(luminance(sums.cells[i]) / total) : k_prior_ring_shares[i / k_cell_sectors];
  out->main_direction[0] = out->main_direction[2] = 0;
  out->main_direction[1] = 1;
  for (float& c : out->main_colour) c = 1;
  out->main_share = 0;
  uint32_t shown = 0;
  const bool is_shown = place.shown != nullptr && place.shown->main_share > k_shown;
  if (is_shown) shown = shown_cell(room, plane, place.shown->main_direction);
  if (total > 0) find_main_light(sums, model, total, is_shown ? &shown : nullptr, out);
  for (int c = 0; c < 3; ++c) out->irradiance[c] = static_cast<float>(colour[c] * unit);
  out->seen = static_cast<float>(sums.all_seen / sums.all_even);
  out->clipped = total > 0 ? static_cast<float>(sums.clipped / total) : 0.0f;
}

RoomFacing facing_of(const Room& room, const sandglass_room_place& place) {
  RoomFacing plane = {false, 0, {}};
  double axes[3][3];
  constexpr float k_along[3] = {1, 0, 0};
  (void)plane_axes(place.normal, place.along != nullptr ? place.along : k_along, axes);
  for (int k = 0; k < 3; ++k) room_to_sphere(room, axes[k], plane.axes[k]);
  return plane;
}

}  // namespace

void room_radiance(const Room& room, const RoomModel& model, float parts[k_room_parts][3]) {
  RoomMemory memory;
  room_remember(room, &memory);
  const RoomOverview all = room_overview(room, memory);
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const KnownPart part = room_known_part(room, memory, i, model, all);
    const double unseen = i < k_room_below ? model.fill_below : model.fill;
    for (int c = 0; c < 3; ++c) {
      const double relative = part.seen * part.lit[c] + (1 - part.seen) * unseen * all.colour[c];
      parts[i][c] = static_cast<float>(relative * all.level * room.light / room.scale);
    }
    if (!(memory.confidence > 0)) continue;
    double far[3];
    const double share = room_far_share(room.probe->far, i, far) * (1 - memory.seen[i]) * memory.confidence;
    for (int c = 0; c < 3; ++c)
      parts[i][c] += static_cast<float>(share * far[c] * memory.probe_scale[c] / room.scale) * room.balance[c];
  }
}

// RoomMemory and sums take 11 KiB of stack.
void room_estimate(const Room& room, const RoomModel& model, const sandglass_room_place& place,
                   sandglass_room_light* light) {
  double at[3] = {};
  const double position[3] = {static_cast<double>(place.position[0]), static_cast<double>(place.position[1]),
                              static_cast<double>(place.position[2])};
  const bool is_known = room.images != 0 || (room.probe != nullptr && room.probe->confidence > 0);
  if (is_known) room_place(room, position, at);
  RoomMemory memory;
  room_remember(room, &memory);
  const RoomOverview all = room_overview(room, memory);
  const RoomHint hint = room_hint(room, model, place.network);
  sandglass_room_light out = {};
  out.valid = is_known ? 1 : 0;
  double unit = 0;  // the floor's, which a plane has in common with it
  for (int i = 0; i < (place.normal != nullptr ? 2 : 1); ++i) {
    const bool of_floor = i == 0;
    const RoomFacing plane = of_floor ? RoomFacing{true, room.yaw, {}} : facing_of(room, place);
    RoomSums sums = {};
    sums_add_sphere(room, memory, model, all, hint, at, plane, &sums);
    sums_even_out(&sums);
    sums_add_far_light(room, memory, all, plane, at, &sums);
    if (of_floor) unit = unit_of(room, model, all, sums);
    find_cells(room, model, plane, place, sums, unit, &out);
    if (!of_floor) continue;
    for (uint32_t j = 0; j < 3 * k_harmonics; ++j) out.sh[j] = static_cast<float>(sums.sh[j] * unit);
    double foot[3];
    room_place(room, position, foot, 2.0);
    find_floor(room, model, memory, foot, place, &out);
  }
  room_main_size(room, at, &out);
  find_look(room, memory, out.look);
  out.short_exposure = short_exposure(room);
  out.white = static_cast<float>(room.scale);
  out.exposure_known = room.exposure_known ? 1 : 0;
  out.unit = room.unit;
  for (int c = 0; c < 3; ++c) out.balance[c] = room.balance[c];
  fill_struct(&out, sizeof out, light);
}

// Fitted to `sandglass_lab verify room` in the interiors of the data folder.
extern const RoomModel k_room_model = {.boost = 2.2,
                                       .fill = 2.2,
                                       .fill_below = 1.0,
                                       .network = 2.0,
                                       .sharp = 1.0,
                                       .albedo = 0.18,
                                       .floor_trust = 0.88,
                                       .unseen_level = 0.7};

}  // namespace sandglass

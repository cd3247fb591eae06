// The light to be expected at a place, from what was seen.
//
// Each part of the sphere counts with
//   X = seen * L * (1 + boost * clipped) + (1 - seen) * fill * (1 + what the network says)
// where L is its radiance beside the geometric mean of all that was seen. It is moved to the object: a part in the
// direction D of the sphere lies in the direction q = D - x from the object at x (in radii), and its solid angle there
// is that of the sphere times (1 - D . x) / |q|^3, by (5.15) to (5.17) of the dissertation. A cell is the mean of X
// over it, weighted by the cosine.
//
// A floor shadow is linear in the cells. So the shadow of least expected squared error is the one drawn in the expected
// light. Where nothing was seen that is an even sky, and the shadow is soft; a guess of one light is not.
#include "sandglass/estimate.h"
#include "kernels/whole.h"
#include "runtime/core/filled_struct.h"
#include "runtime/core/finite.h"
#include "runtime/core/harmonics.h"
#include "runtime/core/luminance.h"
#include "runtime/core/math.h"
#include "runtime/room/room.h"

namespace sandglass {

namespace {

// Each part is moved in 3 x 2 pieces: so many that no piece crosses an edge of the cells' rings.
constexpr uint32_t k_row_split = 3, k_column_split = 2;
constexpr double k_darkest = 1e-4;  // of the mean: keeps logarithms of black parts finite
// Geometric mean before the first image, where white is 1: a level white floor is then nearly white, as it is on the
// mean of what cameras that expose by themselves show of captured interiors.
constexpr double k_first_level = 0.27;
constexpr double k_lobe = 6.0;        // sharpness of the network's light: e^(6 (cos - 1))
constexpr double k_floor_row = 5.0;   // rows below this see the floor: 33.75 degrees below the horizon or more
constexpr double k_stands_out = 3.0;  // times the mean cell: what is beyond may be a light of its own
constexpr double k_wide = 0.94, k_narrow = 0.99;  // mean cosine about the axis: too wide for a sharp shadow; as a lamp
constexpr uint32_t k_look_rows = 1, k_look_columns = 2;  // parts to each side that one look takes in

// All sums over the sphere.
struct Sums {
  double cells[k_light_cells][3];    // irradiance of the level floor from each cell
  double even[k_light_cells];        // the same of an even sky of radiance 1, as far as the pieces fill the cell
  double seen[k_light_cells];        // luminance of the part of `cells` that was seen
  double moments[k_light_cells][3];  // the same times the direction
  double sh[3 * k_harmonics];
  double all_even, all_seen, clipped;  // even sky, the seen part of it; luminance that comes through clipped pixels
};

// What was seen, on the whole.
struct Overview {
  double level;      // geometric mean of the luminance
  double colour[3];  // of luminance 1
  double floor;      // mean luminance of what lies below; 0: not seen
};

// What counts of each part: the share that was seen, as far as it is remembered.
struct Memory {
  double seen[k_room_parts];
};
void remember(const Room& room, Memory* memory) {
  for (uint32_t i = 0; i < k_room_parts; ++i)
    memory->seen[i] = static_cast<double>(room.parts[i].seen) * room_memory(room, room.parts[i]);
}

Overview overview_of(const Room& room, const Memory& memory) {
  double solid_angles[k_room_rows];  // of a part, 1 on the horizon
  for (uint32_t row = 0; row < k_room_rows; ++row)
    solid_angles[row] = sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
  double mean = 0, area = 0, colour[3] = {}, floor = 0, floor_area = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart& part = room.parts[i];
    const double weight = memory.seen[i] * solid_angles[i / k_room_columns], y = luminance(part.radiance);
    mean += weight * y;
    area += weight;
    // A lamp does not colour the rest: each part counts by the root of its brightness.
    const double root = y > 0 ? weight / square_root(y) : 0;
    for (int c = 0; c < 3; ++c) colour[c] += root * static_cast<double>(part.radiance[c]);
    if (i / k_room_columns < static_cast<uint32_t>(k_floor_row)) floor += weight * y, floor_area += weight;
  }
  Overview all = {k_first_level, {1, 1, 1}, 0};
  if (!(area > 0) || !(mean > 0)) return all;
  const double least = k_darkest * mean / area;
  double logarithms = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart& part = room.parts[i];
    const double weight = memory.seen[i] * solid_angles[i / k_room_columns], y = luminance(part.radiance);
    if (weight > 0) logarithms += weight * logarithm(y > least ? y : least);
  }
  all.level = exponential(logarithms / area);
  const double grey = luminance(colour);
  for (int c = 0; c < 3; ++c) all.colour[c] = grey > 0 ? colour[c] / grey : 1;
  all.floor = floor_area > 0 ? floor / floor_area : 0;
  return all;
}

// The direction of the network's light in the sphere's frame, and how much it counts.
struct Hint {
  double direction[3], weight;
};
Hint hint_of(const Room& room, const RoomModel& model, const sandglass_light_estimate* estimate) {
  Hint hint = {{0, 1, 0}, 0};
  if (estimate == nullptr || estimate->valid == 0) return hint;
  if (!all_within(estimate->direction, 3, -1.01f, 1.01f) || !within(estimate->confidence, 0.0f, 1.01f) ||
      !within(estimate->contrast, 0.0f, 1.01f))
    return hint;
  const double direction[3] = {static_cast<double>(estimate->direction[0]), static_cast<double>(estimate->direction[1]),
                               static_cast<double>(estimate->direction[2])};
  room_to_sphere(room, direction, hint.direction);
  hint.weight = model.network * static_cast<double>(estimate->confidence) * static_cast<double>(estimate->contrast);
  return hint;
}

uint32_t cell_of(const double direction[3], double yaw) {
  const double turns = arc_tangent2(direction[2], direction[0]) / (2 * k_pi) + yaw;
  const double around = turns - static_cast<double>(floor_index(turns));
  auto sector = to_whole<uint32_t>(around * k_cell_sectors);
  sector = sector < k_cell_sectors ? sector : k_cell_sectors - 1;
  uint32_t ring = 0;
  while (ring + 1 < k_cell_rings && direction[1] >= k_ring_sines[ring + 1]) ++ring;
  return ring * k_cell_sectors + sector;
}

// What a part sends out.
struct Shown {
  double colour[3];  // beside the geometric mean
  double seen;       // share of the part that was seen
  double from_seen;  // share of the luminance that comes from there
  double clipped;    // share of the pixels that were clipped
};

Shown shown_by(const RoomPart& part, double seen, double unseen, const RoomModel& model, const Overview& all) {
  Shown shown = {{}, seen, 0, static_cast<double>(part.clipped)};
  double lit[3];
  for (int c = 0; c < 3; ++c) {
    lit[c] = seen * static_cast<double>(part.radiance[c]) * (1 + model.boost * shown.clipped) / all.level;
    shown.colour[c] = lit[c] + (1 - seen) * unseen * all.colour[c];
  }
  const double luminous = luminance(shown.colour);
  shown.from_seen = luminous > 0 ? luminance(lit) / luminous : 0;
  return shown;
}

// One piece of a part, from the sphere to the object.
void add_piece(Sums* sums, const SinCos& turn, double yaw, const double sphere[3], double area, const double at[3],
               const Shown& shown) {
  double q[3], along = 0, squared = 0;
  for (int k = 0; k < 3; ++k) q[k] = sphere[k] - at[k], along += sphere[k] * at[k], squared += q[k] * q[k];
  const double distance = square_root(squared), omega = area * (1 - along) / (squared * distance);
  const double local[3] = {q[0] / distance, q[1] / distance, q[2] / distance};
  const double world[3] = {turn.cos * local[0] - turn.sin * local[2], local[1],
                           turn.sin * local[0] + turn.cos * local[2]};
  double polynomials[k_harmonics];
  harmonic_polynomials(world, polynomials);
  for (uint32_t j = 0; j < k_harmonics; ++j)
    for (uint32_t c = 0; c < 3; ++c)
      sums->sh[3 * j + c] += omega * k_harmonic_factors[j] * polynomials[j] * shown.colour[c];
  if (!(world[1] > 0)) return;
  const double facing = omega * world[1];
  const uint32_t cell = cell_of(local, yaw);
  for (uint32_t c = 0; c < 3; ++c) sums->cells[cell][c] += facing * shown.colour[c];
  const double seen = shown.from_seen * facing * luminance(shown.colour);
  sums->even[cell] += facing;
  sums->seen[cell] += seen;
  for (int k = 0; k < 3; ++k) sums->moments[cell][k] += seen * world[k];
  sums->all_even += facing;
  sums->all_seen += shown.seen * facing;
  sums->clipped += shown.clipped * seen;
}

void sum_up(const Room& room, const Memory& memory, const RoomModel& model, const Overview& all, const Hint& hint,
            const double at[3], Sums* sums) {
  const SinCos turn = sin_cos_turns(room.yaw);
  constexpr uint32_t k_rows = k_room_rows * k_row_split, k_columns = k_room_columns * k_column_split;
  constexpr double k_area = 2 * k_pi / k_columns * k_pi / k_rows;
  SinCos azimuths[k_columns];
  for (uint32_t i = 0; i < k_columns; ++i) azimuths[i] = sin_cos_turns((i + 0.5) / k_columns);
  for (uint32_t row = 0; row < k_rows; ++row) {
    const SinCos elevation = sin_cos_turns(((row + 0.5) / k_rows - 0.5) / 2);
    for (uint32_t i = 0; i < k_columns; ++i) {
      const uint32_t part = row / k_row_split * k_room_columns + i / k_column_split;
      const double sphere[3] = {elevation.cos * azimuths[i].cos, elevation.sin, elevation.cos * azimuths[i].sin};
      double agreement = 0;
      for (int k = 0; k < 3; ++k) agreement += sphere[k] * hint.direction[k];
      const double lobe = hint.weight > 0 ? hint.weight * exponential(k_lobe * (agreement - 1)) : 0;
      const double unseen = (sphere[1] > 0 ? model.fill : model.fill_below) * (1 + lobe);
      add_piece(sums, turn, room.yaw, sphere, k_area * elevation.cos, at,
                shown_by(room.parts[part], memory.seen[part], unseen, model, all));
    }
  }
}

// A cell is the mean over it, however many pieces lie in it. Far from the sphere's middle a cell may hold none: it is
// then as the next one around that holds some.
void even_out(Sums* sums) {
  constexpr double k_cell = k_pi / k_light_cells;  // an even sky's irradiance through a cell
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (!(sums->even[i] > 0)) continue;
    const double scale = k_cell / sums->even[i];
    for (int c = 0; c < 3; ++c) sums->cells[i][c] *= scale, sums->moments[i][c] *= scale;
    sums->seen[i] *= scale;
  }
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const uint32_t first = i / k_cell_sectors * k_cell_sectors;
    uint32_t from = i;
    for (uint32_t n = 0; n < k_cell_sectors && !(sums->even[from] > 0); ++n)
      from = first + (from + 1 - first) % k_cell_sectors;
    for (int c = 0; c < 3; ++c) sums->cells[i][c] = sums->cells[from][c];
  }
}

uint32_t neighbour(uint32_t cell, int ring, int sector) {
  const auto r = static_cast<int>(cell / k_cell_sectors) + ring;
  const auto s = (cell % k_cell_sectors + k_cell_sectors + static_cast<uint32_t>(sector)) % k_cell_sectors;
  return r < 0 || r >= static_cast<int>(k_cell_rings) ? k_light_cells : static_cast<uint32_t>(r) * k_cell_sectors + s;
}

// A light of its own: what stands out of the brightest cell that was seen and of those around it. It is drawn sharp as
// far as it is narrow.
void find_main_light(const Sums& sums, const RoomModel& model, double total, sandglass_room_light* out) {
  uint32_t best = 0;
  for (uint32_t i = 1; i < k_light_cells; ++i)
    if (sums.seen[i] > sums.seen[best]) best = i;
  double moment[3] = {}, mass = 0, colour[3] = {}, excess[k_light_cells] = {};
  for (int ring = -1; ring <= 1; ++ring)
    for (int sector = -1; sector <= 1; ++sector) {
      const uint32_t i = neighbour(best, ring, sector);
      if (i == k_light_cells) continue;
      const double beyond = sums.seen[i] - k_stands_out / k_light_cells * total;
      if (!(beyond > 0)) continue;
      excess[i] = beyond / total;
      const double part = beyond / sums.seen[i];
      mass += beyond;
      for (int k = 0; k < 3; ++k) moment[k] += part * sums.moments[i][k], colour[k] += sums.cells[i][k];
    }
  const double length = square_root(moment[0] * moment[0] + moment[1] * moment[1] + moment[2] * moment[2]);
  const double grey = luminance(colour);
  if (!(mass > 0) || !(length > 0) || !(grey > 0)) return;
  double narrow = (length / mass - k_wide) / (k_narrow - k_wide);
  narrow = narrow < 0 ? 0 : narrow > 1 ? 1 : narrow;
  const double share = model.sharp * narrow;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const double taken = share * excess[i], had = static_cast<double>(out->cells[i]);
    out->ambient_cells[i] = static_cast<float>(had > taken ? had - taken : 0.0);
  }
  double kept = 0;
  for (const float q : out->ambient_cells) kept += static_cast<double>(q);
  out->main_share = kept < 1 ? static_cast<float>(1 - kept) : 0.0f;
  for (int k = 0; k < 3; ++k) {
    out->main_direction[k] = static_cast<float>(moment[k] / length);
    out->main_colour[k] = static_cast<float>(colour[k] / grey);
  }
}

// The direction in which one look takes in most of the sky that was not seen, weighted by what it gives the floor.
void find_look(const Room& room, const Memory& memory, float look[3]) {
  double most = -1, facing[k_room_rows];  // cosine and solid angle of a part of the row
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
          gain += (1 - memory.seen[r * k_room_columns + at]) * facing[r];
        }
      if (gain > most) most = gain, best = row * k_room_columns + column;
    }
  double direction[3];
  const uint32_t row = best / k_room_columns, column = best % k_room_columns;
  room_direction(row + 0.5, column + 0.5 + room.yaw * k_room_columns, direction);
  for (int k = 0; k < 3; ++k) look[k] = static_cast<float>(direction[k]);
}

// The irradiance of the floor in units of the last image's white, found in two ways whose logarithms are averaged: from
// the cells, and from how bright the floor looks.
double level_of(const Room& room, const RoomModel& model, const Overview& all, double total, double seen) {
  const double by_cells = total * all.level / room.scale * exponential(model.unseen_level * (1 - seen));
  if (!(all.floor > 0)) return by_cells;
  const double by_floor = k_pi * all.floor / room.scale / model.albedo, weight = model.floor_trust * (1 - seen);
  return exponential((1 - weight) * logarithm(by_cells) + weight * logarithm(by_floor));
}

}  // namespace

// Memory and sums take 9 KiB of stack.
void room_estimate(const Room& room, const RoomModel& model, const double position[3],
                   const sandglass_light_estimate* network, sandglass_room_light* light) {
  double at[3] = {};
  if (room.images != 0) room_place(room, position, at);
  Memory memory;
  remember(room, &memory);
  const Overview all = overview_of(room, memory);
  Sums sums = {};
  sum_up(room, memory, model, all, hint_of(room, model, network), at, &sums);
  even_out(&sums);
  double total = 0, colour[3] = {};
  for (const auto& cell : sums.cells) {
    total += luminance(cell);
    for (int c = 0; c < 3; ++c) colour[c] += cell[c];
  }

  sandglass_room_light out = {};
  out.valid = room.images != 0 ? 1 : 0;
  // The total is 0 where all that was seen is black: an even sky that gives nothing.
  for (uint32_t i = 0; i < k_light_cells; ++i)
    out.cells[i] = out.ambient_cells[i] =
        total > 0 ? static_cast<float>(luminance(sums.cells[i]) / total) : k_prior_ring_shares[i / k_cell_sectors];
  out.main_direction[1] = 1;
  for (float& c : out.main_colour) c = 1;
  if (total > 0) find_main_light(sums, model, total, &out);
  const double seen = sums.all_seen / sums.all_even;
  const double unit = total > 0 ? level_of(room, model, all, total, seen) / total : 0;
  for (int c = 0; c < 3; ++c) out.irradiance[c] = static_cast<float>(colour[c] * unit);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) out.sh[i] = static_cast<float>(sums.sh[i] * unit);
  out.seen = static_cast<float>(seen);
  out.clipped = total > 0 ? static_cast<float>(sums.clipped / total) : 0.0f;
  find_look(room, memory, out.look);
  out.white = static_cast<float>(room.scale);
  fill_struct(&out, sizeof out, light);
}

// Each value lies in the middle of those that `sandglass_lab verify room` prints for the folds of places.
extern const RoomModel k_room_model = {.boost = 3.6,
                                       .fill = 1.65,
                                       .fill_below = 0.5,
                                       .network = 2.0,
                                       .sharp = 1.0,
                                       .albedo = 0.18,
                                       .floor_trust = 0.88,
                                       .unseen_level = 0.7};

}  // namespace sandglass

// The light to be expected at a place, from what was seen.
//
// Each part of the sphere counts with
//   X = seen * L * (1 + boost * clipped) + (1 - seen) * fill * (1 + what the network says)
// where L is its radiance beside the geometric mean of all that was seen. It is moved to the object: a part in the
// direction D of the sphere lies in the direction q = D - x from the object at x (in radii), and its solid angle there
// is that of the sphere times (1 - D . x) / |q|^3, by (5.15) to (5.17) of the dissertation. A cell is the mean of X
// over it, weighted by the cosine.
//
// The level counts what was seen for four times as long as the direction does: light that comes from elsewhere is
// likelier than a room that has become as dark as an unseen one. So an object does not change while the camera rests.
//
// What lies below the horizon of the object is the floor that it stands on, as it was seen around the foot: by the parts
// that lie, from where the camera saw them, in the direction of the foot.
//
// A floor shadow is linear in the cells. So the shadow of least expected squared error is the one drawn in the expected
// light. Where nothing was seen that is an even sky, and the shadow is soft; a guess of one light is not.
#include "sandglass/estimator.h"
#include "kernels/whole.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/math/plane_axes.h"

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
constexpr double k_stands_out = 3.0;  // times the mean of the cells farther away: may be a light of its own
constexpr double k_clearly = 1.25;    // another main light takes over where it is so many times as strong
constexpr float k_shown = 0.01f;      // share of a main light that can be seen
constexpr double k_near_foot = 40.0;  // sharpness of what counts as the foot's surroundings: 9 degrees
// Beside 1, of a part right at the foot that was seen from above: what a part elsewhere weighs, and the usual floor.
constexpr double k_floor_elsewhere = 1e-4, k_floor_unseen = 1e-4;
// Of the mean of images that show another room, as it seems: irradiance over pi. In 27 captured rooms it is 2.6 in the
// median.
constexpr double k_other_least = 2, k_other_most = 3;
constexpr double k_floor_most = 0.9;              // reflectance of a floor at most
constexpr double k_wide = 0.95, k_narrow = 0.99;  // mean cosine about the axis: too wide for a sharp shadow; as a lamp
constexpr uint32_t k_look_rows = 1, k_look_columns = 2;  // parts to each side that one look takes in

// All sums over the sphere.
struct Sums {
  double cells[k_light_cells][3];         // irradiance of the level floor from each cell
  double even[k_light_cells];             // the same of an even sky of radiance 1, as far as the pieces fill the cell
  double seen[k_light_cells];             // luminance of the part of `cells` that was seen
  double moments[k_light_cells][3];       // the same times the direction
  double even_moments[k_light_cells][3];  // `even` times the direction
  double sh[3 * k_harmonics];
  double lasting[k_light_cells];       // luminance of `cells`, if what was seen lasts
  double all_lasting;                  // of the even sky, the part that was seen, if that lasts
  double all_even, all_seen, clipped;  // even sky, the seen part of it; luminance that comes through clipped pixels
};

// What was seen, on the whole.
struct Overview {
  double level;      // geometric mean of the luminance
  double colour[3];  // of luminance 1
  double floor;      // mean luminance of what lies below; 0: not seen
};

// What counts of each part: the share that the camera has seen, as far as it is remembered, and what a probe adds.
struct Memory {
  double seen[k_room_parts];
  double confidence, probe_scale[3];

  double with_probe(double share) const { return share + (1 - share) * confidence; }
  double known(uint32_t i) const { return with_probe(seen[i]); }
};
void remember(const Room& room, Memory* memory) {
  memory->confidence = room.probe != nullptr ? room.probe->confidence : 0;
  if (memory->confidence > 0) room_probe_scale(room, memory->probe_scale);
  for (uint32_t i = 0; i < k_room_parts; ++i) memory->seen[i] = room.parts[i].seen * room_memory(room.parts[i].age);
}
// In the white balance of the last image.
RoomPart part_of(const Room& room, const Memory& memory, uint32_t i) {
  RoomPart part = memory.confidence > 0 ? room_known(room, i, memory.probe_scale, memory.seen[i]) : room.parts[i];
  for (int c = 0; c < 3; ++c) part.radiance[c] *= room.balance[c];
  return part;
}

Overview overview_of(const Room& room, const Memory& memory) {
  double solid_angles[k_room_rows];  // of a part, 1 on the horizon
  for (uint32_t row = 0; row < k_room_rows; ++row)
    solid_angles[row] = sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
  double mean = 0, area = 0, colour[3] = {}, floor = 0, floor_area = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart part = part_of(room, memory, i);
    const double weight = memory.known(i) * solid_angles[i / k_room_columns], y = luminance(part.radiance);
    mean += weight * y;
    area += weight;
    // A lamp does not colour the rest: each part counts by the root of its brightness.
    const double root = y > 0 ? weight / square_root(y) : 0;
    for (int c = 0; c < 3; ++c) colour[c] += root * static_cast<double>(part.radiance[c]);
    if (i / k_room_columns < static_cast<uint32_t>(k_floor_row)) {
      floor += weight * y;
      floor_area += weight;
    }
  }
  Overview all = {k_first_level, {1, 1, 1}, 0};
  if (!(area > 0) || !(mean > 0)) return all;
  const double least = k_darkest * mean / area;
  double logarithms = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart part = part_of(room, memory, i);
    const double weight = memory.known(i) * solid_angles[i / k_room_columns], y = luminance(part.radiance);
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
Hint hint_of(const Room& room, const RoomModel& model, const sandglass_estimator_light* estimate) {
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

// A part as it is known: what it sends out where it was seen, beside the geometric mean, and the shares of it that count
// as seen, now and for the level.
struct KnownPart {
  double lit[3], bright;  // bright: luminance of `lit`
  double clipped;         // share of the pixels that were clipped
  double seen, lasting;
  double up, aside;  // how its light is tilted
};

double bounded_tilt(double k) { return k < -1 ? -1 : k > 1 ? 1 : k; }

// The pieces of a part lie at -2/3, 0 and 2/3 of the way to its edge, and at -1/2 and 1/2. Weights of 1 + k times a third
// or a half of that move the light's middle by 4/9 k and 1/2 k; none is below 0.
static_assert(k_row_split == 3 && k_column_split == 2);
constexpr double k_up = 9.0 / 4 / 127, k_aside = 2.0 / 127;

KnownPart known_part(const Room& room, const Memory& memory, uint32_t i, const RoomModel& model, const Overview& all) {
  const RoomPart part = part_of(room, memory, i);
  const double ever = room.parts[i].seen, clipped = part.clipped;
  const double lasting = ever > 0 ? ever * square_root(square_root(memory.seen[i] / ever)) : 0;
  const double times = (1 + model.boost * clipped) / all.level;
  // Where it is clipped, up and aside are of that; the rest of its light comes from all of it.
  const double light = luminance(part.radiance) * room.light;
  const double from_there = clipped * room.scale * (1 + model.boost) / (1 + model.boost * clipped);
  const double tilt = clipped > 0 && from_there < light ? from_there / light : 1;
  return {{times * static_cast<double>(part.radiance[0]), times * static_cast<double>(part.radiance[1]),
           times * static_cast<double>(part.radiance[2])},
          times * luminance(part.radiance),
          clipped,
          memory.known(i),
          memory.with_probe(lasting),
          bounded_tilt(k_up * tilt * part.up),
          bounded_tilt(k_aside * tilt * part.aside)};
}

// The plane whose light is asked for: a level one, whose azimuth 0 is `yaw` turns away; or its axes (along, normal, across)
// in the sphere's frame.
struct Facing {
  bool level;
  double yaw, axes[3][3];

  void turn(const double sphere[3], double local[3]) const {
    for (int k = 0; k < 3; ++k)
      local[k] = level ? sphere[k] : axes[k][0] * sphere[0] + axes[k][1] * sphere[1] + axes[k][2] * sphere[2];
  }
};

// One piece of a part, from the sphere to the object.
void add_piece(Sums* sums, const SinCos& turn, const Facing& plane, const double sphere[3], double area,
               const double at[3], const KnownPart& part, double tilt, const double unseen[3]) {
  const double seen_share = part.seen * tilt, rest = 1 - part.seen;
  const double colour[3] = {seen_share * part.lit[0] + rest * unseen[0], seen_share * part.lit[1] + rest * unseen[1],
                            seen_share * part.lit[2] + rest * unseen[2]};
  double q[3], along = 0, squared = 0;
  for (int k = 0; k < 3; ++k) {
    q[k] = sphere[k] - at[k];
    along += sphere[k] * at[k];
    squared += q[k] * q[k];
  }
  const double distance = square_root(squared), omega = area * (1 - along) / (squared * distance);
  for (double& x : q) x /= distance;
  double local[3];
  plane.turn(q, local);
  if (!(local[1] > 0)) return;
  const double world[3] = {turn.cos * q[0] - turn.sin * q[2], q[1], turn.sin * q[0] + turn.cos * q[2]};
  double polynomials[k_harmonics];
  harmonic_polynomials(world, polynomials);
  for (uint32_t j = 0; j < k_harmonics; ++j)
    for (uint32_t c = 0; c < 3; ++c) sums->sh[3 * j + c] += omega * k_harmonic_factors[j] * polynomials[j] * colour[c];
  const double facing = omega * local[1];
  const uint32_t cell = cell_of(local, plane.yaw);
  for (uint32_t c = 0; c < 3; ++c) sums->cells[cell][c] += facing * colour[c];
  const double seen = facing * seen_share * part.bright;
  sums->even[cell] += facing;
  sums->lasting[cell] += facing * (part.lasting * tilt * part.bright + (1 - part.lasting) * luminance(unseen));
  sums->all_lasting += facing * part.lasting;
  sums->seen[cell] += seen;
  for (int k = 0; k < 3; ++k) {
    sums->moments[cell][k] += seen * world[k];
    sums->even_moments[cell][k] += facing * world[k];
  }
  sums->all_even += facing;
  sums->all_seen += part.seen * facing;
  sums->clipped += part.clipped * seen;
}

void sum_up(const Room& room, const Memory& memory, const RoomModel& model, const Overview& all, const Hint& hint,
            const double at[3], const Facing& plane, Sums* sums) {
  const SinCos turn = sin_cos_turns(room.yaw);
  constexpr uint32_t k_rows = k_room_rows * k_row_split, k_columns = k_room_columns * k_column_split;
  constexpr double k_area = 2 * k_pi / k_columns * k_pi / k_rows;
  SinCos azimuths[k_columns];
  for (uint32_t i = 0; i < k_columns; ++i) azimuths[i] = sin_cos_turns((i + 0.5) / k_columns);
  KnownPart known[k_room_columns];  // of one row
  for (uint32_t row = 0; row < k_rows; ++row) {
    const SinCos elevation = sin_cos_turns(((row + 0.5) / k_rows - 0.5) / 2);
    // How much more of the part's area lies above its middle than below it.
    const uint32_t part_row = row / k_row_split;
    const double middle = ((part_row + 0.5) / k_room_rows - 0.5) / 2, third = 0.5 / k_rows;
    const double below = sin_cos_turns(middle - third).cos, above = sin_cos_turns(middle + third).cos;
    const double upper = (above - below) / (above + below + sin_cos_turns(middle).cos);
    for (uint32_t i = 0; i < k_room_columns && row % k_row_split == 0; ++i)
      known[i] = known_part(room, memory, row / k_row_split * k_room_columns + i, model, all);
    for (uint32_t i = 0; i < k_columns; ++i) {
      const double sphere[3] = {elevation.cos * azimuths[i].cos, elevation.sin, elevation.cos * azimuths[i].sin};
      double agreement = 0;
      for (int k = 0; k < 3; ++k) agreement += sphere[k] * hint.direction[k];
      const double lobe = hint.weight > 0 ? hint.weight * exponential(k_lobe * (agreement - 1)) : 0;
      const double unseen = (sphere[1] > 0 ? model.fill : model.fill_below) * (1 + lobe);
      const KnownPart& part = known[i / k_column_split];
      const double tilt = (1 + part.up * (static_cast<int>(row % k_row_split) - 1)) / (1 + part.up * upper) *
                          (1 + part.aside * (i % k_column_split == 0 ? -1 : 1));
      const double colour[3] = {unseen * all.colour[0], unseen * all.colour[1], unseen * all.colour[2]};
      add_piece(sums, turn, plane, sphere, k_area * elevation.cos, at, part, tilt, colour);
    }
  }
}

// The far light of a probe (probe.cpp), as far as the camera has not seen where it is. It is no piece of the sphere, so
// it does not fill a cell: it is added to cells that were evened out. It moves with the place where the app tells how
// far away the walls are.
void add_far_light(const Room& room, const Memory& memory, const Overview& all, const Facing& plane, const double at[3],
                   Sums* sums) {
  if (!(memory.confidence > 0)) return;
  const RoomFarLight& far = room.probe->far;
  double q[3], local[3], world[3], ignored[3], share = 0, polynomials[k_harmonics], light[3], along = 0, squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double from = room.told_radius > 0 ? at[k] : 0;
    q[k] = far.direction[k] - from;
    along += far.direction[k] * from;
    squared += q[k] * q[k];
  }
  if (!(squared > 0)) return;
  const double distance = square_root(squared);
  for (double& x : q) x /= distance;
  plane.turn(q, local);
  if (!(local[1] > 0)) return;
  for (uint32_t i = 0; i < k_room_parts; ++i)
    share += room_far_share(far, i, ignored) * (1 - memory.seen[i]) * memory.confidence;
  for (int c = 0; c < 3; ++c)
    light[c] = share * far.irradiance[c] * memory.probe_scale[c] * static_cast<double>(room.balance[c]) * (1 - along) /
               (squared * distance * room.light * all.level);
  room_to_world(room, q, world);
  harmonic_polynomials(world, polynomials);
  const uint32_t cell = cell_of(local, plane.yaw);
  const double bright = local[1] * luminance(light);
  for (uint32_t c = 0; c < 3; ++c) {
    for (uint32_t j = 0; j < k_harmonics; ++j) sums->sh[3 * j + c] += k_harmonic_factors[j] * polynomials[j] * light[c];
    sums->cells[cell][c] += local[1] * light[c];
    sums->moments[cell][c] += bright * world[c];
  }
  sums->seen[cell] += bright;
  sums->lasting[cell] += bright;
}

// A cell is the mean over it, however many pieces lie in it. Far from the sphere's middle a cell may hold none: it is
// then as the next one around that holds some.
void even_out(Sums* sums) {
  constexpr double k_cell = k_pi / k_light_cells;  // an even sky's irradiance through a cell
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (!(sums->even[i] > 0)) continue;
    const double scale = k_cell / sums->even[i];
    for (int c = 0; c < 3; ++c) {
      sums->cells[i][c] *= scale;
      sums->moments[i][c] *= scale;
      sums->even_moments[i][c] *= scale;
    }
    sums->seen[i] *= scale;
    sums->lasting[i] *= scale;
  }
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const uint32_t first = i / k_cell_sectors * k_cell_sectors;
    uint32_t from = i;
    for (uint32_t n = 0; n < k_cell_sectors && !(sums->even[from] > 0); ++n)
      from = first + (from + 1 - first) % k_cell_sectors;
    for (int c = 0; c < 3; ++c) sums->cells[i][c] = sums->cells[from][c];
    sums->lasting[i] = sums->lasting[from];
  }
}

// Cells that touch each other. All of the top ring meet at the zenith.
bool touch(uint32_t a, uint32_t b) {
  const auto rings = static_cast<int>(a / k_cell_sectors) - static_cast<int>(b / k_cell_sectors);
  const uint32_t sectors = (a - b) % k_cell_sectors;
  const bool beside = sectors <= 1 || sectors == k_cell_sectors - 1;
  return rings >= -1 && rings <= 1 && (beside || (rings == 0 && a / k_cell_sectors == k_cell_rings - 1));
}

// A light of its own: what stands out of a cell that was seen and of those that touch it.
struct Lamp {
  double mass, moment[3], colour[3];
  double excess[k_light_cells];  // of each cell
};

Lamp lamp_at(const Sums& sums, uint32_t middle) {
  constexpr double k_cell = k_pi / k_light_cells;
  Lamp lamp = {};
  double away = 0, count = 0;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (touch(i, middle)) continue;
    away += sums.seen[i];
    ++count;
  }
  const double around = away / count;  // what a cell would hold without the lamp
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    if (!touch(i, middle) || !(sums.seen[i] > k_stands_out * around)) continue;
    lamp.excess[i] = sums.seen[i] - around;
    lamp.mass += lamp.excess[i];
    const double part = lamp.excess[i] / sums.seen[i];
    for (int k = 0; k < 3; ++k) {
      lamp.moment[k] += sums.moments[i][k] - around / k_cell * sums.even_moments[i][k];
      lamp.colour[k] += part * sums.cells[i][k];
    }
  }
  return lamp;
}

uint32_t brightest(const Sums& sums, const uint32_t* near) {
  uint32_t best = near != nullptr ? *near : 0;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    if (sums.seen[i] > sums.seen[best] && (near == nullptr || touch(i, *near))) best = i;
  return best;
}

// The main light is drawn sharp as far as it is narrow. That which is shown stays until another is clearly stronger: of
// two equal lamps, each new image would choose another one.
void find_main_light(const Sums& sums, const RoomModel& model, double total, const uint32_t* shown,
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
  double kept = 0;
  for (const float q : out->ambient_cells) kept += static_cast<double>(q);
  out->main_share = kept < 1 ? static_cast<float>(1 - kept) : 0.0f;
  for (int k = 0; k < 3; ++k) {
    out->main_direction[k] = static_cast<float>(lamp.moment[k] / length);
    out->main_colour[k] = static_cast<float>(lamp.colour[k] / grey);
  }
}

// The floor around the foot, as the camera has seen it, in the room's unit; and what that weighs. The nearer a part lies
// to the foot's direction, and the steeper and closer the camera saw it, the more it tells.
double floor_seen(const Room& room, const Memory& memory, const double foot[3], double radiance[3]) {
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
    const RoomPart known = part_of(room, memory, i);
    for (int c = 0; c < 3; ++c) radiance[c] += weight * static_cast<double>(known.radiance[c]) * room.light;
    area += weight;
  }
  if (area > 0)
    for (int c = 0; c < 3; ++c) radiance[c] /= area;
  return area;
}

// The floor's radiance in units of the last image's white.
void find_floor(const Room& room, const RoomModel& model, const Memory& memory, const double foot[3],
                const sandglass_room_place& place, sandglass_room_light* out) {
  double seen[3] = {};
  const double area = place.floor != nullptr ? 0 : floor_seen(room, memory, foot, seen);
  for (int c = 0; c < 3; ++c) {
    const double white = static_cast<double>(out->irradiance[c]) / k_pi, most = k_floor_most * white;
    double floor = (area * seen[c] / room.scale + k_floor_unseen * model.albedo * white) / (area + k_floor_unseen);
    floor = floor < most ? floor : most;
    out->floor[c] = place.floor != nullptr ? place.floor[c] : static_cast<float>(floor);
    for (int i = 0; i < 2; ++i) out->sh[3 * i + c] += static_cast<float>(k_below_harmonics[i]) * out->floor[c];
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
          gain += (1 - memory.known(r * k_room_columns + at)) * facing[r];
        }
      if (gain > most) {
        most = gain;
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

// Of what is clipped in the last image, the least bright first: a shorter image would show that as black. The sun is a
// thousandth of its part.
float short_exposure(const Room& room) {
  constexpr double k_clips = 0.0004;        // share of a part
  constexpr uint8_t k_size_looks = 12;      // for the size of lamps alone
  constexpr int k_octaves[3] = {3, 9, 15};  // shorter than the last ordinary image: then it was tried
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
double level_of(const Room& room, const RoomModel& model, const Overview& all, double total, double seen) {
  const double unit = room.light / room.scale;
  double level = total * all.level * unit * exponential(model.unseen_level * (1 - seen));
  if (all.floor > 0) {
    const double by_floor = k_pi * all.floor * unit / model.albedo, weight = model.floor_trust * (1 - seen);
    level = exponential((1 - weight) * logarithm(level) + weight * logarithm(by_floor));
  }
  if (!(room.shows > 0)) return level;
  const double other = k_pi * room.shows / room.scale;
  level = level < k_other_most * other ? level : k_other_most * other;
  return level > k_other_least * other ? level : k_other_least * other;
}

// What one of the sums' units is, in those of the last image's white.
double unit_of(const Room& room, const RoomModel& model, const Overview& all, const Sums& sums) {
  double total = 0, lasting = 0;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    total += luminance(sums.cells[i]);
    lasting += sums.lasting[i];
  }
  return total > 0 ? level_of(room, model, all, lasting, sums.all_lasting / sums.all_even) / total : 0;
}

uint32_t shown_cell(const Room& room, const Facing& plane, const float direction[3]) {
  const double world[3] = {static_cast<double>(direction[0]), static_cast<double>(direction[1]),
                           static_cast<double>(direction[2])};
  double d[3], local[3];
  room_to_sphere(room, world, d);
  plane.turn(d, local);
  return cell_of(local, plane.yaw);
}

// What is asked of a plane: its cells, its main light, and the irradiance, in units of `unit`.
void find_cells(const Room& room, const RoomModel& model, const Facing& plane, const sandglass_room_place& place,
                const Sums& sums, double unit, sandglass_room_light* out) {
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

Facing facing_of(const Room& room, const sandglass_room_place& place) {
  Facing plane = {false, 0, {}};
  double axes[3][3];
  constexpr float k_along[3] = {1, 0, 0};
  (void)plane_axes(place.normal, place.along != nullptr ? place.along : k_along, axes);
  for (int k = 0; k < 3; ++k) room_to_sphere(room, axes[k], plane.axes[k]);
  return plane;
}

}  // namespace

void room_radiance(const Room& room, const RoomModel& model, float parts[k_room_parts][3]) {
  Memory memory;
  remember(room, &memory);
  const Overview all = overview_of(room, memory);
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const KnownPart part = known_part(room, memory, i, model, all);
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

// Memory and sums take 11 KiB of stack.
void room_estimate(const Room& room, const RoomModel& model, const sandglass_room_place& place,
                   sandglass_room_light* light) {
  double at[3] = {};
  const double position[3] = {static_cast<double>(place.position[0]), static_cast<double>(place.position[1]),
                              static_cast<double>(place.position[2])};
  const bool is_known = room.images != 0 || (room.probe != nullptr && room.probe->confidence > 0);
  if (is_known) room_place(room, position, at);
  Memory memory;
  remember(room, &memory);
  const Overview all = overview_of(room, memory);
  const Hint hint = hint_of(room, model, place.network);
  sandglass_room_light out = {};
  out.valid = is_known ? 1 : 0;
  double unit = 0;  // the floor's, which a plane has in common with it
  for (int i = 0; i < (place.normal != nullptr ? 2 : 1); ++i) {
    const bool of_floor = i == 0;
    const Facing plane = of_floor ? Facing{true, room.yaw, {}} : facing_of(room, place);
    Sums sums = {};
    sum_up(room, memory, model, all, hint, at, plane, &sums);
    even_out(&sums);
    add_far_light(room, memory, all, plane, at, &sums);
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

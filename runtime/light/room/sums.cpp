#include "runtime/light/room/sums.h"

#include "kernels/whole.h"
#include "runtime/light/luminance.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "sandglass/estimator.h"

namespace sandglass {
namespace {

// Each part is moved in 3 x 2 pieces: so many that no piece crosses an edge of the cells' rings.
constexpr uint32_t k_row_split = 3, k_column_split = 2;
constexpr double k_darkest = 1e-4;  // of the mean: keeps logarithms of black parts finite
// Geometric mean before the first image, where white is 1: a level white floor is then nearly white, as it is on the
// mean of what cameras that expose by themselves show of captured interiors.
constexpr double k_first_level = 0.27;
constexpr double k_lobe = 6.0;       // sharpness of the network's light: e^(6 (cos - 1))
constexpr double k_floor_row = 5.0;  // rows below this see the floor: 33.75 degrees below the horizon or more

double bounded_tilt(double k) { return k < -1 ? -1 : k > 1 ? 1 : k; }

// The pieces of a part lie at -2/3, 0 and 2/3 of the way to its edge, and at -1/2 and 1/2. Weights of 1 + k times a
// third or a half of that move the light's middle by 4/9 k and 1/2 k; none is below 0.
static_assert(k_row_split == 3 && k_column_split == 2);
constexpr double k_up = 9.0 / 4 / 127, k_aside = 2.0 / 127;

// One piece of a part, from the sphere to the object.
void add_piece(RoomSums* sums, const SinCos& turn, const RoomFacing& plane, const double sphere[3], double area,
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
  const uint32_t cell = room_cell_of(local, plane.yaw);
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

}  // namespace

void room_remember(const Room& room, RoomMemory* memory) {
  memory->confidence = room.probe != nullptr ? room.probe->confidence : 0;
  if (memory->confidence > 0) room_probe_scale(room, memory->probe_scale);
  for (uint32_t i = 0; i < k_room_parts; ++i) memory->seen[i] = room.parts[i].seen * room_memory(room.parts[i].age);
}

RoomPart room_part_of(const Room& room, const RoomMemory& memory, uint32_t i) {
  RoomPart part = memory.confidence > 0 ? room_known(room, i, memory.probe_scale, memory.seen[i]) : room.parts[i];
  for (int c = 0; c < 3; ++c) part.radiance[c] *= room.balance[c];
  return part;
}

RoomOverview room_overview(const Room& room, const RoomMemory& memory) {
  double solid_angles[k_room_rows];  // of a part, 1 on the horizon
  for (uint32_t row = 0; row < k_room_rows; ++row)
    solid_angles[row] = sin_cos_turns((row + 0.5) / (2 * k_room_rows)).sin;
  double mean = 0, area = 0, colour[3] = {}, floor = 0, floor_area = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart part = room_part_of(room, memory, i);
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
  RoomOverview all = {k_first_level, {1, 1, 1}, 0};
  if (!(area > 0) || !(mean > 0)) return all;
  const double darkest = k_darkest * mean / area;
  double logarithms = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    const RoomPart part = room_part_of(room, memory, i);
    const double weight = memory.known(i) * solid_angles[i / k_room_columns], y = luminance(part.radiance);
    if (weight > 0) logarithms += weight * logarithm(y > darkest ? y : darkest);
  }
  all.level = exponential(logarithms / area);
  const double grey = luminance(colour);
  for (int c = 0; c < 3; ++c) all.colour[c] = grey > 0 ? colour[c] / grey : 1;
  all.floor = floor_area > 0 ? floor / floor_area : 0;
  return all;
}

RoomHint room_hint(const Room& room, const RoomModel& model, const sandglass_estimator_light* estimate) {
  RoomHint hint = {{0, 1, 0}, 0};
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

uint32_t room_cell_of(const double direction[3], double yaw) {
  const double turns = arc_tangent2(direction[2], direction[0]) / (2 * k_pi) + yaw;
  const double around = turns - static_cast<double>(floor_index(turns));
  auto sector = to_whole<uint32_t>(around * k_cell_sectors);
  sector = sector < k_cell_sectors ? sector : k_cell_sectors - 1;
  uint32_t ring = 0;
  while (ring + 1 < k_cell_rings && direction[1] >= k_ring_sines[ring + 1]) ++ring;
  return ring * k_cell_sectors + sector;
}

KnownPart room_known_part(const Room& room, const RoomMemory& memory, uint32_t i, const RoomModel& model,
                          const RoomOverview& all) {
  const RoomPart part = room_part_of(room, memory, i);
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

void sums_add_sphere(const Room& room, const RoomMemory& memory, const RoomModel& model, const RoomOverview& all,
                     const RoomHint& hint, const double at[3], const RoomFacing& plane, RoomSums* sums) {
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
      known[i] = room_known_part(room, memory, row / k_row_split * k_room_columns + i, model, all);
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

void sums_add_far_light(const Room& room, const RoomMemory& memory, const RoomOverview& all, const RoomFacing& plane,
                        const double at[3], RoomSums* sums) {
  if (!(memory.confidence > 0)) return;
  const RoomFarLight& far = room.probe->far;
  double q[3], local[3], world[3], ignored[3], share = 0, polynomials[k_harmonics], light[3], along = 0, squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double from = room.given_radius > 0 ? at[k] : 0;
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
  const uint32_t cell = room_cell_of(local, plane.yaw);
  const double bright = local[1] * luminance(light);
  for (uint32_t c = 0; c < 3; ++c) {
    for (uint32_t j = 0; j < k_harmonics; ++j) sums->sh[3 * j + c] += k_harmonic_factors[j] * polynomials[j] * light[c];
    sums->cells[cell][c] += local[1] * light[c];
    sums->moments[cell][c] += bright * world[c];
  }
  sums->seen[cell] += bright;
  sums->lasting[cell] += bright;
}

void sums_even_out(RoomSums* sums) {
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

}  // namespace sandglass

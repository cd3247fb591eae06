// What another system knows of the room's light, a cube or harmonics, into a layer below what the camera has seen.
//
// The layer is neither mixed with camera images nor replaced by them: where a part was seen, that counts, and the layer
// counts where it was not. So dropping it leaves the room as it was.
//
// A cube: each part asks for some points, of a linear cube so many that hardly a texel is left out. Harmonics say of a
// lamp only that there is more light on one side, and their sum is negative on the other. Of all radiances that have these
// nine moments the one of greatest entropy is taken: e to the power of a sum of the nine harmonics. It is never negative,
// and as even as it may be. Newton's method finds it, a step a unit.
#include "kernels/whole.h"
#include "runtime/light/camera/transfer.h"
#include "runtime/light/cube_map.h"
#include "runtime/light/harmonics.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/half.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {

namespace {

constexpr uint32_t k_points_min = 3, k_points_max = 13;
constexpr double k_texels_per_part = 10.2;  // of an edge: 11.25 degrees are one texel where an edge has so many
constexpr uint8_t k_white = 250;            // sRGB: a channel from here on may be clipped
constexpr double k_value_max = k_half_max;  // what is above stands for light that the cube cannot hold
// Parts that tell the scale: well remembered, unclipped in both, and of bytes not so dark that they are rounded far.
constexpr double k_shared_min = 1.0, k_dark_bytes = 0.004;
constexpr double k_clip_slack = 0.05;
// A scale for each channel, as another white balance needs, is believed so far from that of the luminance.
constexpr double k_balance_max = 2.0;

// Greatest entropy.
constexpr uint32_t k_steps_max = 24, k_halvings_max = 12;
constexpr uint32_t k_grid_rows = 8, k_grid_columns = 16;
constexpr double k_exponent_max = 60.0, k_gain_min = 1e-4;
// No such radiance has the moments of one single direction: all are drawn a little towards even light.
constexpr double k_even_share = 1e-3;
constexpr double k_part_area =
    0.03849124099815343;            // solid angle of a part on the horizon: 2 pi / 32 times 2 sin(pi / 32)
constexpr double k_hue_min = 0.02;  // of the mean radiance: what is darker has no hue of its own

struct Basis {
  double value[k_harmonics];
};

Basis basis_of(const double direction[3]) {
  Basis basis;
  harmonic_polynomials(direction, basis.value);
  for (uint32_t j = 0; j < k_harmonics; ++j) basis.value[j] *= k_harmonic_factors[j];
  return basis;
}

double sum_of(const double x[k_harmonics], const Basis& basis) {
  double sum = 0;
  for (uint32_t j = 0; j < k_harmonics; ++j) sum += x[j] * basis.value[j];
  return sum;
}

double bounded_exponential(double e) { return exponential(e < k_exponent_max ? e : k_exponent_max); }

// Calls use(basis, solid angle) for each point of a grid over the sphere, fine enough for nine harmonics.
template <class Use>
void over_sphere(const Use& use) {
  const double slice = 2 * k_pi / k_grid_columns * 2 * sin_cos_turns(0.25 / k_grid_rows).sin;
  for (uint32_t row = 0; row < k_grid_rows; ++row) {
    const SinCos up = sin_cos_turns(((row + 0.5) / k_grid_rows - 0.5) / 2);
    for (uint32_t column = 0; column < k_grid_columns; ++column) {
      const SinCos around = sin_cos_turns((column + 0.5) / k_grid_columns);
      const double direction[3] = {up.cos * around.cos, up.sin, up.cos * around.sin};
      use(basis_of(direction), slice * up.cos);
    }
  }
}

// The convex function whose minimum is at the exponents.
double cost_of(const double x[k_harmonics], const double target[k_harmonics]) {
  double sum = 0;
  over_sphere([&](const Basis& basis, double area) { sum += area * bounded_exponential(sum_of(x, basis)); });
  for (uint32_t j = 0; j < k_harmonics; ++j) sum -= x[j] * target[j];
  return sum;
}

// Solves a x = b for a symmetric matrix; its diagonal is made a little larger.
void solve(double a[k_harmonics][k_harmonics], double b[k_harmonics]) {
  for (uint32_t i = 0; i < k_harmonics; ++i) a[i][i] *= 1 + 1e-6;
  for (uint32_t i = 0; i < k_harmonics; ++i)
    for (uint32_t r = i + 1; r < k_harmonics; ++r) {
      const double f = a[r][i] / a[i][i];
      for (uint32_t c = i; c < k_harmonics; ++c) a[r][c] -= f * a[i][c];
      b[r] -= f * b[i];
    }
  for (uint32_t i = k_harmonics; i-- > 0;) {
    for (uint32_t c = i + 1; c < k_harmonics; ++c) b[i] -= a[i][c] * b[c];
    b[i] /= a[i][i];
  }
}

// One step of Newton's method, halved while it does not lower the cost. True where no step does.
bool step_entropy(RoomHarmonics* h) {
  double gradient[k_harmonics], hessian[k_harmonics][k_harmonics] = {};
  for (uint32_t j = 0; j < k_harmonics; ++j) gradient[j] = h->target[j];
  over_sphere([&](const Basis& basis, double area) {
    const double p = area * bounded_exponential(sum_of(h->exponents, basis));
    for (uint32_t j = 0; j < k_harmonics; ++j) {
      const double q = p * basis.value[j];
      gradient[j] -= q;
      for (uint32_t k = 0; k < k_harmonics; ++k) hessian[j][k] += q * basis.value[k];
    }
  });
  solve(hessian, gradient);
  double rate = 1, next[k_harmonics], there = h->cost;
  for (uint32_t halving = 0; halving < k_halvings_max; ++halving, rate *= 0.5) {
    for (uint32_t j = 0; j < k_harmonics; ++j) next[j] = h->exponents[j] + rate * gradient[j];
    there = cost_of(next, h->target);
    if (there < h->cost) break;
  }
  if (!(there < h->cost - k_gain_min)) return true;
  h->cost = there;
  for (uint32_t j = 0; j < k_harmonics; ++j) h->exponents[j] = next[j];
  return false;
}

void store(RoomProbePart* part, const double colour[3], double clipped) {
  for (int c = 0; c < 3; ++c) part->radiance[c] = half_of(colour[c]);
  part->clipped = half_of(clipped);
}

void take_row_of_cube(const Room& room, RoomProbe* probe, uint32_t row) {
  const sandglass_cube& cube = probe->cube;
  const uint32_t points = probe->points;
  double to_cube[3][3], at[3];
  Rotation turn = {};
  (void)rotation_of(cube.orientation, &turn);
  for (int axis = 0; axis < 3; ++axis) {
    const double world[3] = {turn.m[0][axis], turn.m[1][axis], turn.m[2][axis]};
    room_to_sphere(room, world, to_cube[axis]);
  }
  room_place(room, probe->place, at);
  for (uint32_t column = 0; column < k_room_columns; ++column) {
    double sum[3] = {}, white = 0, area = 0, beyond = 0, brightest[3] = {};
    for (uint32_t j = 0; j < points; ++j)
      for (uint32_t i = 0; i < points; ++i) {
        double from[3], d[3], colour[3];
        room_direction(row + (j + 0.5) / points, column + (i + 0.5) / points, from);
        const double weight = square_root(from[0] * from[0] + from[2] * from[2]);
        for (int k = 0; k < 3; ++k) from[k] -= at[k];
        for (int k = 0; k < 3; ++k) d[k] = to_cube[k][0] * from[0] + to_cube[k][1] * from[1] + to_cube[k][2] * from[2];
        const RoomCubeTexel kind = room_cube_texel(cube, d, colour);
        if (kind == RoomCubeTexel::none) continue;
        if (kind != RoomCubeTexel::sound) white += weight;
        area += weight;
        if (kind == RoomCubeTexel::beyond) {
          beyond += weight;
          continue;
        }
        for (int c = 0; c < 3; ++c) sum[c] += weight * colour[c];
        if (luminance(colour) > luminance(brightest)) __builtin_memcpy(brightest, colour, sizeof brightest);
      }
    // What the cube cannot hold is at least as bright as the brightest beside it. Where nothing is sound all is hidden.
    for (int c = 0; c < 3 && area > 0; ++c) sum[c] = (sum[c] + beyond * brightest[c]) / area;
    store(&probe->parts[row * k_room_columns + column], sum, area > 0 ? white / area : 1);
  }
}

// The direction of a part's middle from `at`, in the world.
void middle_from(const Room& room, uint32_t part, const double at[3], double world[3]) {
  const uint32_t row = part / k_room_columns, column = part % k_room_columns;
  double d[3];
  room_direction(row + 0.5, column + 0.5, d);
  for (int k = 0; k < 3; ++k) d[k] -= at[k];
  const double squared = square_of(d);
  room_to_world(room, d, world);
  for (int k = 0; k < 3; ++k) world[k] /= square_root(squared);
}

void take_row_of_harmonics(const Room& room, RoomProbe* probe, uint32_t row) {
  const RoomHarmonics& h = probe->harmonics;
  double at[3];
  room_place(room, probe->place, at);
  for (uint32_t column = 0; column < k_room_columns; ++column) {
    const uint32_t i = row * k_room_columns + column;
    double world[3], colour[3];
    middle_from(room, i, at, world);
    const Basis basis = basis_of(world);
    for (int c = 0; c < 3; ++c) {
      colour[c] = sum_of(h.sh[c], basis);  // its hue, where it is light enough to have one
      colour[c] = colour[c] > k_hue_min * h.mean ? colour[c] : k_hue_min * h.mean;
    }
    const double to = h.mean * bounded_exponential(sum_of(h.exponents, basis)) / luminance(colour);
    for (double& c : colour) c *= to;
    store(&probe->parts[i], colour, 0);
  }
}

void run_unit(Room* room) {
  RoomProbe* probe = room->probe;
  switch (probe->phase) {
    case RoomProbePhase::entropy:
      if (!step_entropy(&probe->harmonics) && ++probe->cursor < k_steps_max) return;
      probe->phase = RoomProbePhase::harmonics;
      probe->cursor = 0;
      return;
    case RoomProbePhase::harmonics:
      take_row_of_harmonics(*room, probe, probe->cursor);
      break;
    default:
      take_row_of_cube(*room, probe, probe->cursor);
  }
  if (++probe->cursor < k_room_rows) return;
  bool any = false;  // of a cube: a texel that is a number
  for (const RoomProbePart& part : probe->parts)
    any = any || from_half(part.clipped) < 1 || part.radiance[0] + part.radiance[1] + part.radiance[2] > 0;
  if (any) probe->confidence = probe->confidence_then;
  room_drop_probe_unit(room);
  if (room->images == 0) room->scale = probe->scale > 0 ? probe->scale : 1;
}

bool begin(Room* room, const float position[3], float exposure, float confidence) {
  RoomProbe* probe = room->probe;
  if (room->images == 0 && !(probe->confidence > 0))
    for (int k = 0; k < 3; ++k) room->centre[k] = static_cast<double>(position[k]);
  for (int k = 0; k < 3; ++k) probe->place[k] = static_cast<double>(position[k]);
  probe->confidence = 0;  // until all of it is there
  probe->phase = RoomProbePhase::idle;
  probe->confidence_then = static_cast<double>(confidence);
  probe->scale = exposure > 0 ? 1 / static_cast<double>(exposure) : 0;
  probe->dark = 0;
  probe->far = {};
  probe->cursor = 0;
  probe->run = run_unit;
  return confidence > 0;
}

// A main light without a direction is none.
void set_far_light(const Room& room, const sandglass_harmonics& given, RoomFarLight* far) {
  double world[3];
  for (int k = 0; k < 3; ++k) world[k] = static_cast<double>(given.main_direction[k]);
  const double squared = square_of(world);
  if (!(squared > 0)) return;
  for (double& x : world) x /= square_root(squared);
  room_to_sphere(room, world, far->direction);
  for (int c = 0; c < 3; ++c) far->irradiance[c] = static_cast<double>(given.main_irradiance[c]);
  double row;
  room_part_at(far->direction, &row, &far->column);
  far->row = row < 0.5 ? 0.5 : row > k_room_rows - 0.5 ? k_room_rows - 0.5 : row;
}

// Logarithms of how much brighter the room remembers a part than the probe shows it. False where the two do not compare.
bool compared(const Room& room, uint32_t i, const RoomProbePart& shown, double ratio[3]) {
  const RoomPart& part = room.parts[i];
  double colour[3], far[3];
  const double share = room_far_share(room.probe->far, static_cast<uint32_t>(&shown - room.probe->parts), far);
  for (int c = 0; c < 3; ++c) colour[c] = from_half(shown.radiance[c]) + share * far[c];
  if (!room_remembers(part) || shown.clipped > 0 || !(luminance(colour) > room.probe->dark)) return false;
  for (int c = 0; c < 3; ++c) {
    const double known = static_cast<double>(part.radiance[c]) * room.light;
    if (!(known > 0) || !(colour[c] > 0)) return false;
    ratio[c] = logarithm(known / colour[c]);
  }
  return true;
}

}  // namespace

RoomCubeTexel room_cube_texel(const sandglass_cube& cube, const double d[3], double colour[3]) {
  const double towards[3] = {d[0], d[1], cube.left_handed != 0 ? -d[2] : d[2]};
  const CubePoint at = cube_point(towards);
  const double half = 0.5 * cube.size;
  const auto index = [&](double x) {
    const auto i = to_whole<uint32_t>(x * half + half);
    return i < cube.size ? i : cube.size - 1;
  };
  const uint8_t* row = static_cast<const uint8_t*>(cube.faces[at.face]) + int64_t{index(at.t)} * cube.stride;
  const uint32_t x = index(at.s);
  bool white = false;
  if (cube.format <= SANDGLASS_CUBE_BGRA8) {
    const uint8_t* p = row + 4 * x;
    for (int c = 0; c < 3; ++c) {
      const uint8_t byte = p[cube.format == SANDGLASS_CUBE_BGRA8 ? 2 - c : c];
      colour[c] = srgb_light(byte);
      white = white || byte >= k_white;
    }
    return white ? RoomCubeTexel::clipped : RoomCubeTexel::sound;
  }
  RoomCubeTexel kind = RoomCubeTexel::sound;
  for (uint32_t c = 0; c < 3; ++c) {
    float value;
    if (cube.format == SANDGLASS_CUBE_RGBA16F) {
      uint16_t bits;
      __builtin_memcpy(&bits, row + 8 * x + 2 * c, sizeof bits);
      value = number_from_half(bits);
    } else {
      __builtin_memcpy(&value, row + (cube.format == SANDGLASS_CUBE_RGB32F ? 12 : 16) * x + 4 * c, sizeof value);
    }
    colour[c] = value > 0 ? static_cast<double>(value) : 0;
    if (value != value) kind = RoomCubeTexel::none;
    else if (colour[c] > k_value_max && kind == RoomCubeTexel::sound) kind = RoomCubeTexel::beyond;
  }
  return kind;
}

void room_begin_cube(Room* room, const sandglass_cube& cube) {
  RoomProbe* probe = room->probe;
  if (!begin(room, cube.position, cube.exposure, cube.confidence)) return;
  const bool bytes = cube.format <= SANDGLASS_CUBE_BGRA8;
  // What bytes say of a lamp is little anyway: its share of white texels, for which a few points are enough.
  uint32_t points = bytes ? k_points_min : to_whole<uint32_t>(cube.size / k_texels_per_part) + 1;
  points = points < k_points_min ? k_points_min : points;
  probe->points = points < k_points_max ? points : k_points_max;
  probe->dark = bytes ? k_dark_bytes : 0;
  probe->cube = cube;
  probe->phase = RoomProbePhase::cube;
}

void room_begin_harmonics(Room* room, const sandglass_harmonics& given) {
  RoomProbe* probe = room->probe;
  if (!begin(room, given.position, given.exposure, given.confidence)) return;
  RoomHarmonics* h = &probe->harmonics;
  *h = {};
  double grey[k_harmonics];
  for (uint32_t j = 0; j < k_harmonics; ++j) {
    double colour[3];
    for (uint32_t c = 0; c < 3; ++c)
      h->sh[c][j] = colour[c] = (given.with_phase == 1 ? phase_of(j) : 1) * static_cast<double>(given.sh[3 * j + c]);
    grey[j] = luminance(colour);
  }
  const double even = grey[0] * k_harmonic_factors[0];  // mean radiance
  h->mean = even > 1e-12 ? even : 1e-12;
  for (uint32_t j = 0; j < k_harmonics; ++j) h->target[j] = grey[j] / h->mean * (j == 0 ? 1 : 1 - k_even_share);
  h->cost = cost_of(h->exponents, h->target);
  if (given.kind == SANDGLASS_HARMONICS_AMBIENT) set_far_light(*room, given, &probe->far);
  probe->phase = RoomProbePhase::entropy;
}

uint32_t room_probe_units_left(const Room& room) {
  const RoomProbe* probe = room.probe;
  if (probe == nullptr || probe->phase == RoomProbePhase::idle) return 0;
  return probe->phase == RoomProbePhase::entropy ? k_steps_max - probe->cursor + k_room_rows
                                                 : k_room_rows - probe->cursor;
}

void room_drop_probe_unit(Room* room) {
  if (room->probe == nullptr) return;
  room->probe->phase = RoomProbePhase::idle;
  room->probe->cursor = 0;
  for (const void*& face : room->probe->cube.faces) face = nullptr;
}

void room_probe_scale(const Room& room, double scale[3]) {
  const RoomProbe* probe = room.probe;
  for (int c = 0; c < 3; ++c) scale[c] = room.scale;
  if (room.images == 0) return;
  double sum[3] = {}, area = 0;
  for (uint32_t i = 0; i < k_room_parts; ++i) {
    double ratio[3];
    if (!compared(room, i, probe->parts[i], ratio)) continue;
    const double weight = room_part_weight(i);
    area += weight;
    for (int c = 0; c < 3; ++c) sum[c] += weight * ratio[c];
  }
  const bool scale_known = room.exposure_known && probe->scale > 0, shared = area >= k_shared_min;
  const double found = shared ? exponential(luminance(sum) / area) : room.scale,
               grey = scale_known ? probe->scale : found;
  for (int c = 0; c < 3; ++c) {
    double balance = shared ? exponential(sum[c] / area) / found : 1;
    balance = balance < 1 / k_balance_max ? 1 / k_balance_max : balance > k_balance_max ? k_balance_max : balance;
    scale[c] = grey * balance;
  }
}

double room_far_share(const RoomFarLight& far, uint32_t part, double radiance[3]) {
  for (int c = 0; c < 3; ++c) radiance[c] = 0;
  // It goes to the four parts around it, so that its mean direction is kept.
  const uint32_t row = part / k_room_columns, column = part % k_room_columns;
  const double down = absolute(far.row - (row + 0.5)), aside = absolute(far.column - (column + 0.5));
  const double around = aside < 0.5 * k_room_columns ? aside : k_room_columns - aside;
  if (!(luminance(far.irradiance) > 0 && down < 1 && around < 1)) return 0;
  for (int c = 0; c < 3; ++c) radiance[c] = far.irradiance[c] / (k_part_area * room_part_weight(part));
  return (1 - down) * (1 - around);
}

RoomPart room_known(const Room& room, uint32_t i, const double scale[3], double seen) {
  RoomPart known = room.parts[i];
  const RoomProbePart& probe = room.probe->parts[i];
  const double confidence = room.probe->confidence, probe_clipped = from_half(probe.clipped);
  double there[3], here[3], all_there[3], far[3], clipped = known.clipped;
  const double share = room_far_share(room.probe->far, i, far);
  for (int c = 0; c < 3; ++c) {
    there[c] = from_half(probe.radiance[c]) * scale[c] / room.light;
    all_there[c] = there[c] + share * far[c] * scale[c] / room.light;
    here[c] = static_cast<double>(known.radiance[c]);
  }
  if (clipped > probe_clipped + k_clip_slack && luminance(all_there) > luminance(here)) {
    for (int c = 0; c < 3; ++c) here[c] += confidence * (all_there[c] - here[c]);
    clipped += confidence * (probe_clipped - clipped);
  }
  const double rest = (1 - seen) * confidence, all = seen + rest;
  for (int c = 0; c < 3; ++c) known.radiance[c] = room_bounded_radiance((seen * here[c] + rest * there[c]) / all);
  known.clipped = (seen * clipped + rest * probe_clipped) / all;
  return known;
}

bool room_probe_fit(const Room& room, uint32_t* quarters, bool* mirrored) {
  double smallest = 0;
  bool any = false;
  for (uint32_t orientation = 0; orientation < 8; ++orientation) {
    double sum = 0, squares = 0, area = 0;
    for (uint32_t i = 0; i < k_room_parts; ++i) {
      const uint32_t row = i / k_room_columns, column = i % k_room_columns;
      const uint32_t turned = column + orientation % 4 * (k_room_columns / 4);
      const uint32_t from = (orientation < 4 ? turned : 2 * k_room_columns - 1 - turned) % k_room_columns;
      double ratio[3];
      if (!compared(room, i, room.probe->parts[row * k_room_columns + from], ratio)) continue;
      const double weight = room_part_weight(i), grey = luminance(ratio);
      area += weight;
      sum += weight * grey;
      squares += weight * grey * grey;
    }
    if (area < k_shared_min) continue;
    const double spread = squares / area - sum / area * (sum / area);
    if (any && spread >= smallest) continue;
    any = true;
    smallest = spread;
    *quarters = orientation % 4;
    *mirrored = orientation >= 4;
  }
  return any;
}

}  // namespace sandglass

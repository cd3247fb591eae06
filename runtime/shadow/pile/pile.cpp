// One texture of the sand's shadow, unit by unit.
#include "runtime/shadow/pile/pile.h"

#include <cstdint>
#include <cstring>

#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/baked/shadow.h"
#include "runtime/shadow/pile/thin.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

// Sand is lit as it is seen, sphere by sphere. A receiver on the sand is raised by this share of a radius, so that
// neighbours of the same height do not shade each other.
constexpr float k_surface_lift = 0.5f;
constexpr double k_cap_share = 0.9;     // what hides this share of a light counts as reaching its upper edge
constexpr double k_step_growth = 1.12;  // of distant steps; a light of 20 degrees is 0.35 wide at distance 1
constexpr double k_near_steps = 1;      // that count as if their columns lay just where they end
constexpr double k_even_steps = 8;      // texels that are walked one by one

void clear_columns(Pile* p) {
  const uint32_t count = p->texels * p->pitch + k_lane_group;
  float* tops = p->tops - k_lane_group;
  float* bottoms = p->bottoms - k_lane_group;
  float* fills = p->fills - k_lane_group;
  for (uint32_t i = 0; i < count; ++i) {
    tops[i] = -k_pile_empty;
    bottoms[i] = k_pile_empty;
    fills[i] = 0;
  }
  p->sand_rows[0] = p->sand_columns[0] = static_cast<int32_t>(p->texels);
  p->sand_rows[1] = p->sand_columns[1] = -1;
  p->top = 0;
  if (p->in_air)
    for (uint32_t i = 0; i < p->texels * p->texels; ++i) p->air[i] = 1;
  p->in_air = false;
}

// A sphere goes into the column that holds its centre, and covers it by `share` (pile_thin.h). It reaches as high
// and as low as its two halves do in the mean. A sphere as wide as a texel counts as the cube whose faces are as large as
// its silhouette. It also fills every column whose middle lies under or over it.
// `visits` is what is left of this unit's columns. False: it is spent, and the sphere goes on in the next unit.
bool put_sphere(Pile* p, const float* centre, float share, uint32_t* visits) {
  const float radius = p->source.radius, n = static_cast<float>(p->texels);
  const float rise = (is_finer_than_texels(*p) ? k_fine_rise : k_half_face) * radius;
  const float x = (centre[0] - p->low[0]) / p->texel[0], z = (centre[2] - p->low[1]) / p->texel[1];
  const float y = centre[1] - p->height;
  if (p->sphere_row == 0 && x >= 0 && z >= 0 && x < n && z < n && y < k_pile_highest)
    pile_put_column(p, to_whole<int32_t>(x), to_whole<int32_t>(z), share, y - rise, y + rise);
  if (is_finer_than_texels(*p)) return true;
  const PileReach reach = pile_reach(*p, centre, radius);
  const int32_t wide = reach.last[0] - reach.first[0] + 1;
  for (int32_t v = reach.first[1] + static_cast<int32_t>(p->sphere_row); v <= reach.last[1] && wide > 0; ++v) {
    if (*visits < static_cast<uint32_t>(wide)) {
      p->sphere_row = static_cast<uint32_t>(v - reach.first[1]);
      return false;
    }
    *visits -= static_cast<uint32_t>(wide);
    for (int32_t u = reach.first[0]; u <= reach.last[0]; ++u) {
      const float dx = (static_cast<float>(u) + 0.5f - x) * p->texel[0];
      const float dz = (static_cast<float>(v) + 0.5f - z) * p->texel[1];
      const float square = radius * radius - dx * dx - dz * dz;
      if (!(square > 0)) continue;
      const float half = __builtin_sqrtf(square);
      pile_put_column(p, u, v, 1, y - half, y + half);
    }
  }
  p->sphere_row = 0;
  return true;
}

// Columns that a sphere may cover along an axis.
float columns_across(const Pile& p, uint32_t axis) {
  const float columns = 2 * p.source.radius / p.texel[axis] + 1, n = static_cast<float>(p.texels);
  return columns < n ? columns : n;
}

uint32_t unit_spheres(const Pile& p) {
  if (p.source.skin != nullptr) return k_pile_unit_triangles;
  const float count = static_cast<float>(k_pile_unit_columns) / (columns_across(p, 0) * columns_across(p, 1));
  return count > 1024 ? 1024u : count > 1 ? to_whole<uint32_t>(count) : 1u;
}

// The range of elevations that the light fills in one vertical half plane, as squares of sines. `cosine` is that of the
// angle between the half plane's azimuth and the light's. The light is where a cos e + b sin e >= cos(half), with
// a = flat * cosine and b = up; `flat` and `up` are the horizontal and vertical components of its direction. False: the
// half plane does not meet the light.
bool elevations(double flat, double up, double cosine, double half_cosine, double* low, double* high) {
  const double a = flat * cosine, b = up, norm = square_root(a * a + b * b);
  if (!(norm > half_cosine)) return false;
  const double c1 = a / norm, s1 = b / norm, c2 = half_cosine / norm, s2 = square_root(1 - c2 * c2);
  const double sin_high = s1 * c2 + c1 * s2, cos_high = c1 * c2 - s1 * s2;
  const double sin_low = s1 * c2 - c1 * s2, cos_low = c1 * c2 + s1 * s2;
  if (!(cos_low > 0)) return false;  // it lies in the opposite half plane
  *high = cos_high > 0 ? (sin_high > 0 ? sin_high * sin_high : 0) : 1;
  *low = sin_low > 0 ? sin_low * sin_low : 0;
  return *high > *low;
}

// The steps along an azimuth, out to the distance at which the highest sand no longer reaches the light's lower edge.
uint32_t walk(const Pile& p, double cosine, double sine, double low, PileStep* steps) {
  const double texel = static_cast<double>(p.texel[0] < p.texel[1] ? p.texel[0] : p.texel[1]);
  const double slope = square_root(low / (1 - (low < 1 ? low : 0)));
  const double across = 1.5 * p.texels;
  const double reach =
      slope * across * texel > static_cast<double>(p.top) ? static_cast<double>(p.top) / (slope * texel) : across;
  uint32_t count = 0;
  // The receiver's own column: two random places in it are a third of its width apart on average. The first of
  // the other columns counts as if it lay just where the step ends, so that a thin layer is met within a texel's width
  // whatever the azimuth is.
  steps[count++] = {0, 0, static_cast<float>(3 / texel)};
  for (double distance = 1; distance <= reach + 1 && count < k_pile_steps;
       distance = distance < k_even_steps ? distance + 1 : distance * k_step_growth) {
    const double x = distance * texel * cosine / static_cast<double>(p.texel[0]);
    const double z = distance * texel * sine / static_cast<double>(p.texel[1]);
    const int64_t columns = floor_index(x + 0.5), rows = floor_index(z + 0.5);
    const double dx = static_cast<double>(columns) * static_cast<double>(p.texel[0]);
    const double dz = static_cast<double>(rows) * static_cast<double>(p.texel[1]);
    const double length = distance <= k_near_steps ? distance * texel : square_root(dx * dx + dz * dz);
    if ((columns == 0 && rows == 0) || !(length > 0)) continue;
    steps[count++] = {static_cast<int32_t>(columns), static_cast<int32_t>(rows), static_cast<float>(1 / length)};
  }
  return count;
}

// Cuts the light into azimuths. They lie evenly in the sine of the angle from the light's own azimuth, over its width.
// A light that holds the zenith is cut all round.
void cut_light(Pile* p) {
  const double flat = square_root(p->made_for[0] * p->made_for[0] + p->made_for[2] * p->made_for[2]);
  const double up = p->made_for[1];
  const bool round = flat <= p->half_sine;
  const double ahead_x = flat > 0 ? p->made_for[0] / flat : 1, ahead_z = flat > 0 ? p->made_for[2] / flat : 0;
  const uint32_t count = round ? k_pile_azimuths : k_pile_azimuths / 2;
  double total = 0;
  uint32_t steps = 0;
  p->azimuth_count = 0;
  for (uint32_t k = 0; k < count; ++k) {
    double cosine, sine, weight;
    if (round) {
      const SinCos turn = sin_cos_turns((k + 0.5) / count);
      cosine = turn.cos;
      sine = turn.sin;
      weight = 1;
    } else {
      const double widest = p->half_sine / flat;
      sine = widest * ((2.0 * k + 1.0) / count - 1.0);
      cosine = square_root(1 - sine * sine);
      weight = 1 / cosine;  // d(azimuth) / d(sine)
    }
    double low = 0, high = 0;
    if (!elevations(flat, up, cosine, p->half_cosine, &low, &high)) continue;
    PileAzimuth& azimuth = p->azimuths[p->azimuth_count++];
    azimuth.low = static_cast<float>(low);
    azimuth.high = static_cast<float>(high);
    azimuth.weight = static_cast<float>(weight);
    const double cap = low + k_cap_share * (high - low);
    azimuth.foot = static_cast<float>(square_root(low / (1 - low)));
    azimuth.cap = static_cast<float>(square_root(cap / (1 - cap)));
    azimuth.first_step = steps;
    steps += walk(*p, ahead_x * cosine - ahead_z * sine, ahead_z * cosine + ahead_x * sine, low, p->steps + steps);
    azimuth.last_step = steps;
    thin_own_column(*p, p->steps + azimuth.first_step, steps - azimuth.first_step, &azimuth);
    total += static_cast<double>(azimuth.weight) * static_cast<double>(azimuth.high - azimuth.low);
  }
  p->inverse_total = total > 0 ? static_cast<float>(1 / total) : 0.0f;
}

void begin_columns(Pile* p) {
  p->cursor = p->sphere_row = p->chunk = p->chunk_first = 0;
  p->skin_brick[0] = k_no_brick;
  if (p->source.skin != nullptr) p->skin_version = p->source.skin->front_version;
  clear_columns(p);
}

void begin(Pile* p) {
  p->phase = PilePhase::columns;
  p->restarts = 0;
  p->making = pile_wanted(*p);
  // While sand moves, what it leaves of the room's light is made every other time: it is softer.
  p->skips_sky = p->source.moving && p->making == k_ask_all && !p->skips_sky;
  p->asked &= ~p->making;
  if (p->skips_sky) p->making = k_ask_light;  // the next frame asks again
  p->back.frame = p->frame;
  if ((p->making & k_ask_sky) != 0) sky_begin(p);
  for (uint32_t axis = 0; axis < 3; ++axis) p->made_for[axis] = p->light[axis];
  const SinCos half = sin_cos_turns(0.25 / k_pi * p->width);
  p->half_sine = half.sin;
  p->half_cosine = half.cos;
  begin_columns(p);
}

// The centres of a source: the first one, and how many floats lie from each to the next.
struct Centres {
  const float* first;
  uint64_t stride;
};

Centres centres_of(const DrawnSand& source) {
  if (source.grains != nullptr) return {(*source.grains)->position, sizeof(Grain) / sizeof(float)};
  if (source.particles != nullptr) return {(*source.particles)->position, sizeof(Particle) / sizeof(float)};
  return {source.positions, 3};
}

// A skin that is exchanged before its columns stand is taken from the start, so that all are of one; not for ever.
void run_columns(Pile* p) {
  constexpr uint32_t k_restarts = 3;
  const DrawnSand& source = p->source;
  if (p->phase == PilePhase::idle) begin(p);
  else if (source.skin != nullptr && source.skin->front_version != p->skin_version && p->restarts++ < k_restarts)
    begin_columns(p);
  const uint32_t count = source.skin != nullptr ? skin_items(*source.skin) : source.count;
  const uint32_t left = count > p->cursor ? count - p->cursor : 0, most = unit_spheres(*p);
  const uint32_t end = p->cursor + (left < most ? left : most);
  uint32_t visits = k_pile_unit_columns;
  if (source.skin != nullptr) {
    for (; p->cursor < end; ++p->cursor)
      if (!pile_put_skin(p, p->cursor, &visits)) return;
  } else {
    const Centres centres = centres_of(source);
    const float share = sphere_share(*p);
    for (; p->cursor < end; ++p->cursor)
      if (!put_sphere(p, centres.first + p->cursor * centres.stride, share, &visits)) return;
  }
  if (p->cursor < count) return;
  p->cursor = 0;
  if ((p->making & k_ask_light) == 0) {
    p->phase = PilePhase::levels;
    return;
  }
  cut_light(p);
  p->phase = PilePhase::floor;
}

// The steps of a row that meet rows with sand; the receiver's own column stays. Texels from `begin` to before `end` may
// meet sand.
void gather_row(Pile* p, int32_t row, uint32_t* begin, uint32_t* end) {
  uint32_t count = 0;
  int32_t least = INT32_MAX, most = INT32_MIN;
  for (uint32_t k = 0; k < p->azimuth_count; ++k) {
    PileAzimuth* out = &p->row_azimuths[k];
    *out = p->azimuths[k];
    const uint32_t first = out->first_step, last = out->last_step;
    out->first_step = count;
    for (uint32_t s = first; s < last; ++s) {
      const int32_t at = row + p->steps[s].rows;
      const bool meets = at >= p->sand_rows[0] && at <= p->sand_rows[1];
      if (s == first || meets) p->row_steps[count++] = p->steps[s];
      if (!meets) continue;
      const int32_t from = p->sand_columns[0] - p->steps[s].columns, to = p->sand_columns[1] - p->steps[s].columns;
      least = from < least ? from : least;
      most = to > most ? to : most;
    }
    out->last_step = count;
  }
  const int32_t n = static_cast<int32_t>(p->texels);
  least = least > 0 ? least : 0;
  most = most < n ? most : n - 1;
  *begin = *end = 0;
  if (least > most) return;
  *begin = static_cast<uint32_t>(least) / k_lane_group * k_lane_group;
  *end = (static_cast<uint32_t>(most) / k_lane_group + 1) * k_lane_group;
}

void light_row(Pile* p, uint32_t row, const float* receivers, uint8_t* coverage) {
  PileLightArgs args = {};
  args.tops = p->tops;
  args.bottoms = p->bottoms;
  args.fills = p->fills;
  args.pitch = p->pitch;
  args.row = static_cast<int32_t>(row);
  for (uint32_t side = 0; side < 2; ++side) {
    args.sand_rows[side] = p->sand_rows[side];
    args.sand_columns[side] = p->sand_columns[side];
  }
  args.receivers = receivers;
  args.on_floor = receivers == p->nothing ? 1 : 0;
  uint32_t begin, end;
  gather_row(p, args.row, &begin, &end);
  for (uint32_t u = 0; u < p->texels; ++u) p->shares[u] = 1;
  args.azimuths = p->row_azimuths;
  args.azimuth_count = p->azimuth_count;
  args.steps = p->row_steps;
  args.inverse_total = p->inverse_total;
  args.shares = p->shares;
  uint32_t unused = 0;
  p->kernels->pile_light(&args, begin, end, &unused);
  if (p->in_air)
    for (uint32_t u = 0; u < p->texels; ++u) p->shares[u] *= p->air[row * p->texels + u];
  for (uint32_t u = 0; u < p->texels; ++u)
    coverage[u] = static_cast<uint8_t>(to_whole<uint32_t>(255.0f * (1.0f - p->shares[u]) + 0.5f));
}

void run_rows(Pile* p) {
  const bool floor = p->phase == PilePhase::floor;
  const uint32_t end = p->cursor + k_pile_unit_texels / p->texels > p->texels
                           ? p->texels
                           : p->cursor + (k_pile_unit_texels / p->texels > 0 ? k_pile_unit_texels / p->texels : 1);
  for (; p->cursor < end; ++p->cursor) {
    uint8_t* coverage = (floor ? p->back.floor : p->back.sand) + uint64_t{p->cursor} * p->texels;
    if (p->sand_rows[1] < 0 && !p->in_air) {
      memset(coverage, 0, p->texels);
    } else if (floor) {
      light_row(p, p->cursor, p->nothing, coverage);
    } else {
      const float* tops = p->tops + uint64_t{p->cursor} * p->pitch;
      for (uint32_t u = 0; u < p->texels; ++u)
        p->receivers[u] = tops[u] > 0 ? tops[u] + k_surface_lift * p->source.radius : 0;
      light_row(p, p->cursor, p->receivers, coverage);
    }
  }
  if (p->cursor < p->texels) return;
  p->cursor = 0;
  if (floor && p->back.sand != nullptr) {
    p->phase = PilePhase::sand;
    return;
  }
  const uint64_t texels = uint64_t{p->texels} * p->texels;
  const bool same = p->front.version != 0 && memcmp(p->front.floor, p->back.floor, texels) == 0 &&
                    (p->back.sand == nullptr || memcmp(p->front.sand, p->back.sand, texels) == 0);
  p->back.version = p->front.version + (same ? 0 : 1);
  const PileTexture swap = p->front;
  p->front = p->back;
  p->back = swap;
  p->valid = true;
  p->making &= ~k_ask_light;
  p->phase = p->making != 0 ? PilePhase::levels : PilePhase::idle;
}

void run_sky(Pile* p) {
  PileSky* s = &p->sky;
  if (p->phase == PilePhase::levels) {
    p->cursor = sky_run_levels(p, p->cursor);
    if (p->cursor == s->rows) {
      p->phase = PilePhase::sky;
      p->cursor = 0;
    }
    return;
  }
  p->cursor = sky_run_rows(p, p->cursor);
  if (p->cursor < s->texels) return;
  p->cursor = 0;
  s->back.top = p->top;
  const uint64_t texels = uint64_t{s->texels} * s->texels, heights = uint64_t{p->texels} * p->texels;
  const bool same =
      s->front.version != 0 && s->front.top == s->back.top && memcmp(s->front.floor, s->back.floor, texels) == 0 &&
      memcmp(s->front.sand, s->back.sand, texels) == 0 && memcmp(s->front.heights, s->back.heights, heights) == 0;
  s->back.version = s->front.version + (same ? 0 : 1);
  const SkyTexture swap = s->front;
  s->front = s->back;
  s->back = swap;
  s->valid = true;
  p->making = 0;
  p->phase = PilePhase::idle;
}

bool has_work(const Pile& p) { return p.phase != PilePhase::idle || pile_wanted(p) != 0; }

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const Pile& p = static_cast<const sandglass_pile_shadow*>(state)->pile;
  if (!has_work(p)) return false;
  *unit = pile_next(p);
  return true;
}

void run(void* state, uint32_t) { pile_run(&static_cast<sandglass_pile_shadow*>(state)->pile); }

// What is left of the texture under way or asked for.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const Pile& p = static_cast<const sandglass_pile_shadow*>(state)->pile;
  if (!has_work(p)) return 0;
  const PileSky& sky = p.sky;
  const uint32_t making = p.phase == PilePhase::idle ? pile_wanted(p) : p.making;
  uint64_t columns = 0, rows = 0, levels = 0, sky_rows = 0;
  if ((making & k_ask_light) != 0) rows = (p.back.sand != nullptr ? 2u : 1u) * p.texels;
  if ((making & k_ask_sky) != 0) {
    levels = sky.rows;
    sky_rows = sky.texels;
  }
  if (p.phase == PilePhase::idle) columns = p.source.count;
  else if (p.phase == PilePhase::columns) columns = p.source.count > p.cursor ? p.source.count - p.cursor : 0;
  else if (p.phase == PilePhase::levels) levels -= p.cursor;
  else if (p.phase == PilePhase::sky) {
    levels = 0;
    sky_rows -= p.cursor;
  } else rows -= p.cursor + (p.phase == PilePhase::sand ? p.texels : 0);
  const Forecast all[] = {{k_pile_columns, columns, true},
                          {k_pile_rows, rows * p.texels, true},
                          {k_pile_levels, levels * sky.texels, true},
                          {k_pile_sky_rows, sky_rows * sky.texels, true}};
  uint32_t count = 0;
  for (const Forecast& entry : all)
    if (entry.items != 0) entries[count++] = entry;
  return count;
}

bool under_way(const void* handle) {
  return static_cast<const sandglass_pile_shadow*>(handle)->pile.phase != PilePhase::idle;
}

uint32_t begin_frame(void* handle, const FrameView& view) {
  Pile& p = static_cast<sandglass_pile_shadow*>(handle)->pile;
  const DrawnSand& sand = view.drawn;
  ++p.frame;
  // Also in the frame after the last motion: the texture under way then shows sand that still moved.
  const bool changed = sand.count != p.source.count || sand.version != p.source.version;
  if (sand.moving || p.source.moving || changed) p.asked = k_ask_all;
  p.source = sand;
  return 0;
}

}  // namespace

PileReach pile_reach(const Pile& p, const float* centre, float radius) {
  PileReach reach = {{0, 0}, {-1, -1}};
  const float y = centre[1] - p.height, n = static_cast<float>(p.texels);
  if (!(radius > 0 && radius < k_pile_radius_limit && y < k_pile_highest && y + radius > 0)) return reach;
  float from[2], to[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const float middle = (centre[2 * axis] - p.low[axis]) / p.texel[axis], half = radius / p.texel[axis];
    from[axis] = middle - half - 0.5f;
    to[axis] = middle + half - 0.5f;
    if (!(from[axis] < n && to[axis] >= 0)) return reach;
  }
  for (uint32_t axis = 0; axis < 2; ++axis) {  // what is converted lies from 0 to n
    const double first = from[axis] > 0 ? static_cast<double>(from[axis]) : 0.0;
    const double last = to[axis] < n - 1 ? static_cast<double>(to[axis]) : static_cast<double>(n) - 1;
    reach.first[axis] = static_cast<int32_t>(ceiling_index(first));
    reach.last[axis] = static_cast<int32_t>(floor_index(last));
  }
  return reach;
}

WorkUnit pile_next(const Pile& p) {
  if (p.phase == PilePhase::idle || p.phase == PilePhase::columns) {
    const uint32_t from = p.phase == PilePhase::idle ? 0 : p.cursor, most = unit_spheres(p);
    const uint32_t left = p.source.count > from ? p.source.count - from : 0;
    return {k_pile_columns, left == 0 ? 1 : left < most ? left : most, "pile_shadow.columns"};
  }
  if (p.phase == PilePhase::levels) return {k_pile_levels, k_sky_unit_windows, "pile_shadow.levels"};
  if (p.phase == PilePhase::sky) return {k_pile_sky_rows, k_sky_unit_texels, "pile_shadow.sky"};
  return {k_pile_rows, k_pile_unit_texels, p.phase == PilePhase::floor ? "pile_shadow.floor" : "pile_shadow.sand"};
}

void pile_run(Pile* p) {
  if (p->phase == PilePhase::idle || p->phase == PilePhase::columns) run_columns(p);
  else if (p->phase == PilePhase::levels || p->phase == PilePhase::sky) run_sky(p);
  else run_rows(p);
}

extern const Capability k_pile_capability = {
    .begin_frame = begin_frame, .next = next, .run = run, .forecast = forecast, .under_way = under_way};

}  // namespace sandglass

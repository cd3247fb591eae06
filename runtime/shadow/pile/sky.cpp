// See sky.h.
#include "runtime/shadow/pile/sky.h"

#include <cstring>

#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"

namespace sandglass {
namespace {

// Empty columns stand around each row, so that a vector may begin before it or end behind it.
constexpr uint32_t k_before = 1u << (k_sky_levels - 1);  // where windows begin that reach into the row
constexpr uint32_t k_after = k_lane_group;

// Which level a step reads, and how far from the receiver its window's middle is, in texels.
struct Walk {
  uint32_t level;
  double distance;
};
constexpr Walk k_walk[k_sky_steps] = {{0, 0},    {0, 1},    {1, 2.5},  {1, 4.5},  {2, 7.5},  {2, 11.5},
                                      {2, 15.5}, {2, 19.5}, {2, 23.5}, {2, 27.5}, {3, 33.5}, {3, 41.5},
                                      {3, 49.5}, {3, 57.5}, {3, 65.5}, {3, 73.5}, {3, 81.5}, {3, 89.5}};

constexpr float k_cap = 2.0f;           // slope: from here on sand is as good as up to the zenith
constexpr float k_flat = 1e-6f;         // metres: lower sand has no height
constexpr float k_on_floor = 1.0f;      // radii: a column whose bottom is lower stands on the floor
constexpr int32_t k_widest_sphere = 2;  // columns: the radius of spheres that are joined to one surface
// What a grain loses for each radius that its topmost point lies below the surface of the sand. Fitted to rays at
// grains of lattices and of a scene.
constexpr float k_depth_loss = 0.9f;

uint32_t window(uint32_t level) { return 1u << level; }

// First and last texel with sand along an axis. None: last < first.
struct Extent {
  int32_t first, last;
};
Extent extent(const int32_t columns[2], uint32_t joined) {
  if (columns[1] < 0) return {0, -1};
  const auto n = static_cast<int32_t>(joined);
  return {columns[0] / n, columns[1] / n};
}

bool has_sand(const Extent& sand, uint32_t level, int32_t first) {
  return first <= sand.last && first + static_cast<int32_t>(window(level)) > sand.first;
}

struct Column {
  float top, bottom, fill;
};
constexpr Column k_no_sand = {-k_pile_empty, k_pile_empty, 0};

// Four columns as one: two of the first row, two of the second. Heights are means over what is filled. Seen along a
// row, the columns of the row hide the light one behind the other, and the rows lie side by side. Seen across it is
// the other way round. The fill is the mean of both.
Column join(const Column& a, const Column& b, const Column& c, const Column& d) {
  const float sum = (a.fill + b.fill) + (c.fill + d.fill);
  if (!(sum > 0)) return k_no_sand;
  const float pairs = (a.fill * b.fill + c.fill * d.fill) + (a.fill * c.fill + b.fill * d.fill);
  const float inverse = 1 / sum;
  return {((a.fill * a.top + b.fill * b.top) + (c.fill * c.top + d.fill * d.top)) * inverse,
          ((a.fill * a.bottom + b.fill * b.bottom) + (c.fill * c.bottom + d.fill * d.bottom)) * inverse,
          0.5f * sum - 0.25f * pairs};
}

Column column_of(const Pile& p, uint32_t u, uint32_t v) {
  const uint64_t at = uint64_t{v} * p.columns.pitch + u;
  return {p.columns.tops[at], p.columns.bottoms[at], p.columns.fills[at]};
}

Column joined_four(const Pile& p, uint32_t u, uint32_t v) {
  return join(column_of(p, u, v), column_of(p, u + 1, v), column_of(p, u, v + 1), column_of(p, u + 1, v + 1));
}

// The pile's columns over a square of 1, 2 or 4 of them.
Column joined_columns(const Pile& p, uint32_t u, uint32_t v, uint32_t side) {
  if (side == 1) return column_of(p, u, v);
  if (side == 2) return joined_four(p, u, v);
  return join(joined_four(p, u, v), joined_four(p, u + 2, v), joined_four(p, u, v + 2), joined_four(p, u + 2, v + 2));
}

// A row of a level, or nothing where no sand lies under it.
struct LevelRow {
  const float *tops, *bottoms, *fills;
};
Column window_at(const LevelRow& row, int32_t u) {
  if (row.tops == nullptr) return k_no_sand;
  return {row.tops[u], row.bottoms[u], row.fills[u]};
}
// The row of windows that begin at texel row `first`, in the arrays.
uint32_t array_row(const PileSky& s, uint32_t level, int32_t first) {
  return static_cast<uint32_t>(static_cast<int32_t>(s.origins[level]) + first);
}

LevelRow row_at(const PileSky& s, const Extent& sand, uint32_t level, int32_t first) {
  if (!has_sand(sand, level, first)) return {};
  const uint64_t at = uint64_t{array_row(s, level, first)} * s.pitch;
  return {s.tops + at, s.bottoms + at, s.fills + at};
}

void put(PileSky* s, uint64_t row, int32_t u, const Column& column) {
  const int64_t at = static_cast<int64_t>(row * s->pitch) + u;
  s->tops[at] = column.top;
  s->bottoms[at] = column.bottom;
  s->fills[at] = column.fill;
  if (column.fill > 0 && column.bottom > 0) s->in_air[row] = 1;
}

int32_t columns_within(float radius, float texel) {
  const float count = radius / texel + 0.5f;
  return count < k_widest_sphere ? to_whole<int32_t>(count) : k_widest_sphere;
}

// The surface of the sand over the columns under one row of level 0: the highest column within a sphere's radius, so
// that the gaps between spheres lie below it also where columns are finer than spheres. A skin has no gaps.
void make_heights(PileSky* s, const Pile& p, uint32_t row) {
  const int32_t n = static_cast<int32_t>(p.rectangle.texels), joined = static_cast<int32_t>(s->joined);
  const float per_metre = p.columns.top > k_flat ? 255 / p.columns.top : 0;
  const float gaps = p.request.source.skin == nullptr ? p.request.source.radius : 0;
  const int32_t across = columns_within(gaps, p.rectangle.texel[0]), along = columns_within(gaps, p.rectangle.texel[1]);
  for (int32_t v = static_cast<int32_t>(row) * joined, end = v + joined; v < end; ++v) {
    uint8_t* heights = s->back.heights + static_cast<int64_t>(v) * n;
    memset(heights, 0, p.rectangle.texels);
    if (v + along < p.columns.sand_rows[0] || v - along > p.columns.sand_rows[1]) continue;
    const int32_t left = p.columns.sand_columns[0] - across, right = p.columns.sand_columns[1] + across;
    for (int32_t u = left > 0 ? left : 0; u <= right && u < n; ++u) {
      float top = 0;
      for (int32_t y = v > along ? v - along : 0; y <= v + along && y < n; ++y)
        for (int32_t x = u > across ? u - across : 0; x <= u + across && x < n; ++x) {
          const float here = p.columns.tops[static_cast<int64_t>(y) * p.columns.pitch + x];
          top = here > top ? here : top;
        }
      heights[u] = static_cast<uint8_t>(to_whole<uint32_t>(top * per_metre + 0.5f));
    }
  }
}

// A window of a level that is above 0, of four windows of the level below.
Column joined_windows(const LevelRow& a, const LevelRow& b, int32_t u, int32_t half) {
  return join(window_at(a, u), window_at(a, u + half), window_at(b, u), window_at(b, u + half));
}

void make_level_row(PileSky* s, const Pile& p, uint32_t row) {
  if (row < s->texels) make_heights(s, p, row);
  uint32_t level = 0;
  while (level + 1 < k_sky_levels && row + window(level + 1) > s->origins[level + 1]) ++level;
  const Extent rows = extent(p.columns.sand_rows, s->joined), columns = extent(p.columns.sand_columns, s->joined);
  const int32_t first = static_cast<int32_t>(row) - static_cast<int32_t>(s->origins[level]);
  if (!has_sand(rows, level, first)) return;
  s->in_air[row] = 0;
  LevelRow a = {}, b = {};
  const int32_t half = static_cast<int32_t>(window(level)) / 2;
  if (level > 0) {
    a = row_at(*s, rows, level - 1, first);
    b = row_at(*s, rows, level - 1, first + half);
  }
  for (int32_t u = 1 - static_cast<int32_t>(window(level)); u < static_cast<int32_t>(s->texels); ++u) {
    Column column = k_no_sand;
    if (level == 0 && has_sand(columns, level, u)) {
      const uint32_t joined = s->joined;
      column = joined_columns(p, static_cast<uint32_t>(u) * joined, static_cast<uint32_t>(first) * joined, joined);
      if (column.bottom < k_on_floor * p.request.source.radius) column.bottom = 0;
    } else if (has_sand(columns, level, u)) {
      column = joined_windows(a, b, u, half);
    }
    put(s, row, u, column);
  }
}

void place_steps(const PileRectangle& r, uint32_t joined, uint32_t sector, SkyStep* steps) {
  const SinCos turn = sin_cos_turns((sector + 0.5) / k_cell_sectors);
  const double side[2] = {static_cast<double>(r.texel[0]) * joined, static_cast<double>(r.texel[1]) * joined};
  const double texel = side[0] < side[1] ? side[0] : side[1];
  for (const Walk& walk : k_walk) {
    const double to_middle = 0.5 * (window(walk.level) - 1);
    const int64_t columns = floor_index(walk.distance * texel * turn.cos / side[0] - to_middle + 0.5);
    const int64_t rows = floor_index(walk.distance * texel * turn.sin / side[1] - to_middle + 0.5);
    const double dx = (static_cast<double>(columns) + to_middle) * side[0];
    const double dz = (static_cast<double>(rows) + to_middle) * side[1];
    const double distance = square_root(dx * dx + dz * dz);
    // Along an axis two random places in the receiver's own texel are a third of its width apart on average.
    *steps++ = {walk.level, static_cast<int32_t>(columns), static_cast<int32_t>(rows),
                static_cast<float>(distance > 0 ? 1 / distance : 3 / texel)};
  }
}

bool has_light(const PileSector& sector) {
  for (const float bend : sector.bends)
    if (bend != 0) return true;
  return false;
}

// The steps and sectors of a row, without those that meet no sand or have no light.
void gather_steps(const PileSky& s, const PileColumns& sand, uint32_t row, PileSkyArgs* args) {
  const Extent rows = extent(sand.sand_rows, s.joined), columns = extent(sand.sand_columns, s.joined);
  uint32_t count = 0;
  for (uint32_t k = 0; k < k_cell_sectors; ++k) {
    if (!has_light(s.sectors[k])) continue;
    PileSector* out = &s.row_sectors[args->sector_count];
    *out = s.sectors[k];
    out->first_step = count;
    out->in_air = 0;
    for (uint32_t i = 0; i < k_sky_steps; ++i) {
      const SkyStep& step = s.walks[k * k_sky_steps + i];
      const int32_t first = static_cast<int32_t>(row) + step.rows, wide = static_cast<int32_t>(window(step.level));
      if (!has_sand(rows, step.level, first)) continue;
      const uint32_t at = array_row(s, step.level, first);
      out->in_air |= s.in_air[at];
      s.steps[count++] = {static_cast<int32_t>(at * s.pitch) + step.columns, columns.first - wide + 1 - step.columns,
                          columns.last - step.columns, step.inverse_distance};
    }
    out->last_step = count;
    if (count > out->first_step) ++args->sector_count;
  }
}

uint8_t byte_of(float share) { return static_cast<uint8_t>(to_whole<uint32_t>(255.0f * share + 0.5f)); }

void light_row(PileSky* s, const Pile& p, uint32_t row) {
  const uint32_t n = s->texels;
  const uint64_t at = uint64_t{row} * n;
  uint8_t *floor = s->back.floor + at, *sand = s->back.sand + at;
  PileSkyArgs args = {};
  args.tops = s->tops;
  args.bottoms = s->bottoms;
  args.fills = s->fills;
  args.steps = s->steps;
  args.sectors = s->row_sectors;
  args.cap = k_cap;
  ground_row(p.ground, row, n, s->joined, s->ground);
  args.receivers = s->ground;
  args.lights = s->lights;
  gather_steps(*s, p.columns, row, &args);
  uint32_t unused = 0;
  p.kernels->pile_sky(&args, 0, n, &unused);
  for (uint32_t u = 0; u < n; ++u) floor[u] = byte_of(s->lights[u]);
  memcpy(sand, floor, n);
  const Extent rows = extent(p.columns.sand_rows, s->joined), columns = extent(p.columns.sand_columns, s->joined);
  if (!has_sand(rows, 0, static_cast<int32_t>(row))) return;
  const float* tops = s->tops + uint64_t{row} * s->pitch;
  for (uint32_t u = 0; u < n; ++u) s->receivers[u] = tops[u] > 0 ? tops[u] : 0;
  args.receivers = s->receivers;
  const uint32_t begin = static_cast<uint32_t>(columns.first) / k_lane_group * k_lane_group;
  const uint32_t end = (static_cast<uint32_t>(columns.last) / k_lane_group + 1) * k_lane_group;
  p.kernels->pile_sky(&args, begin, end, &unused);
  for (uint32_t u = begin; u < end; ++u)
    if (tops[u] > 0) sand[u] = byte_of(s->lights[u]);
}

// Where a coordinate lies between the middles of two texels.
struct Place {
  uint32_t texel;
  float beyond;  // the share of the distance to the next texel
};
Place place_of(const PileRectangle& r, float coordinate, uint32_t axis, uint32_t texels) {
  const float count = static_cast<float>(texels);
  float at = (coordinate - r.low[axis]) / (r.high[axis] - r.low[axis]) * count - 0.5f;
  at = at > 0 ? (at < count - 1 ? at : count - 1) : 0;
  uint32_t texel = to_whole<uint32_t>(at);
  if (texel > texels - 2) texel = texels - 2;
  return {texel, at - static_cast<float>(texel)};
}

// A texture between the middles of its texels.
float sampled(const PileRectangle& r, const uint8_t* texture, uint32_t texels, const float* point) {
  const Place x = place_of(r, point[0], 0, texels), z = place_of(r, point[2], 1, texels);
  const uint8_t* at = texture + uint64_t{z.texel} * texels + x.texel;
  const auto along = [&](const uint8_t* row) {
    const float a = row[0], b = row[1];
    return a + x.beyond * (b - a);
  };
  const float near = along(at), far = along(at + texels);
  return near + z.beyond * (far - near);
}

// Where a unit of `items` ends that begins at row `cursor` of `rows`. It has one row at least.
uint32_t unit_end(const PileSky& s, uint32_t items, uint32_t cursor, uint32_t rows) {
  const uint32_t count = items / s.texels > 0 ? items / s.texels : 1;
  return cursor + count < rows ? cursor + count : rows;
}

}  // namespace

void sky_lay_out(PileSky* s, uint32_t texels, uint32_t joined, Layout* layout) {
  s->texels = texels;
  s->joined = joined;
  if (texels == 0) return;
  s->pitch = texels + k_before + k_after;
  uint32_t rows = 0;
  for (uint32_t level = 0; level < k_sky_levels; ++level) {
    s->origins[level] = rows + window(level) - 1;
    rows = s->origins[level] + texels;
  }
  s->rows = rows;
  const uint64_t columns = uint64_t{rows} * s->pitch + k_lane_group, n = texels;
  float** const arrays[] = {&s->tops, &s->bottoms, &s->fills};
  for (float** array : arrays) *array = layout_region<float>(layout, "pile_shadow.levels", columns);
  s->in_air = layout_region<uint8_t>(layout, "pile_shadow.levels", rows);
  float** const lines[] = {&s->ground, &s->receivers, &s->lights};
  for (float** line : lines) *line = layout_region<float>(layout, "pile_shadow.row", n);
  s->walks = layout_region<SkyStep>(layout, "pile_shadow.steps", k_cell_sectors * k_sky_steps);
  s->steps = layout_region<PileSkyStep>(layout, "pile_shadow.steps", k_cell_sectors * k_sky_steps);
  s->sectors = layout_region<PileSector>(layout, "pile_shadow.sectors", k_cell_sectors);
  s->row_sectors = layout_region<PileSector>(layout, "pile_shadow.sectors", k_cell_sectors);
  s->cells = layout_region<float>(layout, "pile_shadow.cells", k_light_cells);
  s->made_for = layout_region<float>(layout, "pile_shadow.cells", k_light_cells);
  SkyTexture* const textures[] = {&s->front, &s->back};
  for (SkyTexture* texture : textures) {
    texture->floor = layout_region<uint8_t>(layout, "pile_shadow.sky", n * n);
    texture->sand = layout_region<uint8_t>(layout, "pile_shadow.sky", n * n);
    texture->heights = layout_region<uint8_t>(layout, "pile_shadow.sky", joined * n * joined * n);
  }
}

void sky_build(PileSky* s, const PileRectangle& rectangle) {
  if (s->texels == 0) return;
  const uint64_t columns = uint64_t{s->rows} * s->pitch + k_lane_group, texels = uint64_t{s->texels} * s->texels;
  for (uint64_t i = 0; i < columns; ++i) {
    s->tops[i] = k_no_sand.top;
    s->bottoms[i] = k_no_sand.bottom;
    s->fills[i] = k_no_sand.fill;
  }
  constexpr uint32_t k_first = k_lane_group + k_before;  // row 0, column 0
  s->tops += k_first;
  s->bottoms += k_first;
  s->fills += k_first;
  for (uint32_t u = 0; u < s->texels; ++u) s->ground[u] = s->receivers[u] = s->lights[u] = 0;
  for (uint32_t k = 0; k < k_cell_sectors; ++k) place_steps(rectangle, s->joined, k, s->walks + k * k_sky_steps);
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    s->cells[i] = k_prior_ring_shares[i / k_cell_sectors];
    s->made_for[i] = 0;
  }
  memset(s->front.floor, 255, texels);
  memset(s->front.sand, 255, texels);
  memset(s->front.heights, 0, texels * s->joined * s->joined);
}

void sky_begin(PileSky* s, uint64_t frame) {
  memcpy(s->made_for, s->cells, k_light_cells * sizeof(float));
  for (uint32_t i = 0; i < k_light_cells; ++i)
    s->sectors[i % k_cell_sectors].bends[i / k_cell_sectors] =
        s->cells[i] - (i < k_cell_sectors ? 0 : s->cells[i - k_cell_sectors]);
  s->back.frame = frame;
  s->level_row = s->row = 0;
}

bool sky_run_levels(PileSky* s, const Pile& p) {
  const uint32_t end = unit_end(*s, k_sky_unit_windows, s->level_row, s->rows);
  for (; s->level_row < end; ++s->level_row) make_level_row(s, p, s->level_row);
  return s->level_row == s->rows;
}

bool sky_run_rows(PileSky* s, const Pile& p) {
  const uint32_t end = unit_end(*s, k_sky_unit_texels, s->row, s->texels);
  for (; s->row < end; ++s->row) light_row(s, p, s->row);
  return s->row == s->texels;
}

void sky_end(PileSky* s, const Pile& p) {
  SkyTexture &front = s->front, &back = s->back;
  back.top = p.columns.top;
  const uint64_t texels = uint64_t{s->texels} * s->texels, heights = uint64_t{p.rectangle.texels} * p.rectangle.texels;
  const bool same = front.version != 0 && front.top == back.top && memcmp(front.floor, back.floor, texels) == 0 &&
                    memcmp(front.sand, back.sand, texels) == 0 && memcmp(front.heights, back.heights, heights) == 0;
  back.version = front.version + (same ? 0 : 1);
  const SkyTexture swap = front;
  front = back;
  back = swap;
  s->valid = true;
}

void sky_light_grains(const Pile& p, const float* positions, uint32_t count, float radius, uint8_t* visibility) {
  const SkyTexture& sky = p.sky.front;
  if (!p.sky.valid || !(radius > 0)) {
    memset(visibility, 255, count);
    return;
  }
  const float per_radius = 1 / radius, step = sky.top * (1.0f / 255);
  for (uint32_t i = 0; i < count; ++i) {
    const float* centre = positions + 3 * uint64_t{i};
    const float surface = step * sampled(p.rectangle, sky.heights, p.rectangle.texels, centre);
    const float depth = (surface - (centre[1] + radius - p.rectangle.height)) * per_radius,
                below = depth > 0 ? depth : 0;
    visibility[i] = static_cast<uint8_t>(
        to_whole<uint32_t>(sampled(p.rectangle, sky.sand, p.sky.texels, centre) / (1 + k_depth_loss * below) + 0.5f));
  }
}

}  // namespace sandglass

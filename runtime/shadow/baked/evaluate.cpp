// One texture, unit by unit.
#include <cstring>

#include "runtime/math/math.h"
#include "runtime/shadow/baked/shadow.h"

namespace sandglass {
namespace {

int16_t saturated(int32_t x) { return static_cast<int16_t>(x < -32768 ? -32768 : x > 32767 ? 32767 : x); }

// The light's part of the first layer: encoded components times their weights, in double, rounded once.
void sum_light(Shadow* s) {
  const uint32_t width = s->network.width, inputs = 1 + 2 * s->light_frequencies;
  for (uint32_t c = 0; c < width; ++c) {
    double sum = static_cast<double>(s->first_bias[c]);
    s->light_sums[c] = 0;
    const float* weight = s->light_weights + c;
    for (uint32_t axis = 0; axis < 3; ++axis, weight += uint64_t{inputs} * width) {
      sum += s->back.light[axis] * static_cast<double>(weight[0]);
      double turns = 0.5 * s->back.light[axis];
      for (uint32_t k = 0; k < s->light_frequencies; ++k, turns *= 2) {
        const SinCos wave = sin_cos_turns(turns);
        sum += wave.sin * static_cast<double>(weight[(1 + 2 * k) * width]) +
               wave.cos * static_cast<double>(weight[(2 + 2 * k) * width]);
      }
    }
    // The kernels shift down: half a step makes that a rounding.
    const double units = sum * s->table_scale + 0.5 * static_cast<double>(1u << s->network.shift);
    const double clamped = units < -32768 ? -32768 : units > 32767 ? 32767 : units;
    s->light_sums[c] = static_cast<int16_t>(floor_index(clamped + 0.5) > 32767 ? 32767 : floor_index(clamped + 0.5));
  }
}

void begin_texture(Shadow* s, uint32_t light) {
  ShadowLight& l = s->lights[light];
  for (uint32_t axis = 0; axis < 3; ++axis) s->back.light[axis] = l.wanted[axis];
  s->back.rectangle = shadow_rectangle(s->box, s->plane, l.wanted, s->half_sine, s->reach);
  s->back.light_call = l.calls;
  s->back.evaluated = 0;
  s->active = light;
  l.pending = false;
}

void end_texture(Shadow* s) {
  s->back.valid = true;
  ShadowTexture& front = s->lights[s->active].front;
  const bool same = front.version != 0 && memcmp(front.coverage, s->back.coverage, k_shadow_size * k_shadow_size) == 0;
  s->back.version = front.version + (same ? 0 : 1);
  const ShadowTexture swap = front;
  front = s->back;
  s->back = swap;
  s->phase = ShadowPhase::idle;
  s->cursor = 0;
}

void go_to(Shadow* s, ShadowPhase phase) {
  s->phase = phase;
  s->cursor = 0;
}

void evaluate_unit(Shadow* s, uint32_t count) {
  const TexelRange range = {s->unit_u, s->unit_v, count, s->scratch, s->unit_coverage};
  s->kernels->shadow_texels(&s->network, &range);
  s->back.evaluated += count;
}

void run_rows(Shadow* s) {
  if (s->cursor == 0) sum_light(s);
  const uint32_t width = s->network.width;
  const uint32_t end = s->cursor + k_unit_table_rows < k_table_rows ? s->cursor + k_unit_table_rows : k_table_rows;
  for (; s->cursor < end; ++s->cursor)
    for (uint32_t c = 0; c < width; ++c)
      s->rows[s->cursor * width + c] = saturated(s->row_base[s->cursor * width + c] + s->light_sums[c]);
  if (s->cursor == k_table_rows) go_to(s, s->mode == SANDGLASS_SHADOW_FULL ? ShadowPhase::full : ShadowPhase::coarse);
}

void run_coarse(Shadow* s) {
  uint32_t count = 0;
  const uint32_t first = s->cursor;
  for (; s->cursor < k_grid * k_grid && count < s->unit_texels; ++s->cursor, ++count) {
    s->unit_u[count] = static_cast<uint16_t>(s->cursor % k_grid * k_cell);
    s->unit_v[count] = static_cast<uint16_t>(s->cursor / k_grid * k_cell);
  }
  evaluate_unit(s, count);
  for (uint32_t i = 0; i < count; ++i) s->coarse[first + i] = s->unit_coverage[i];
  if (s->cursor == k_grid * k_grid) go_to(s, ShadowPhase::decide);
}

uint32_t spread(uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
  const uint8_t low = a < b ? a : b, high = a < b ? b : a, low2 = c < d ? c : d, high2 = c < d ? d : c;
  return static_cast<uint32_t>((high > high2 ? high : high2) - (low < low2 ? low : low2));
}

// Bilinear between the corners, in sixteenths, rounded.
void interpolate_cell(const Shadow* s, uint32_t cell_u, uint32_t cell_v) {
  const uint8_t* corner = s->coarse + cell_v * k_grid + cell_u;
  for (uint32_t y = 0; y < k_cell; ++y)
    for (uint32_t x = 0; x < k_cell; ++x) {
      const uint32_t top = corner[0] * (k_cell - x) + corner[1] * x;
      const uint32_t bottom = corner[k_grid] * (k_cell - x) + corner[k_grid + 1] * x;
      s->back.coverage[(cell_v * k_cell + y) * k_shadow_size + cell_u * k_cell + x] =
          static_cast<uint8_t>((top * (k_cell - y) + bottom * y + k_cell * k_cell / 2) / (k_cell * k_cell));
    }
}

// Two passes: cells whose corners differ are marked, then each cell is looked at with its neighbours. So the rows of
// cells count twice.
void run_decide(Shadow* s) {
  for (uint32_t end = s->cursor + k_unit_cell_rows; s->cursor < end; ++s->cursor) {
    const uint32_t v = s->cursor % k_cells;
    for (uint32_t u = 0; u < k_cells; ++u) {
      if (s->cursor < k_cells) {
        const uint8_t* corner = s->coarse + v * k_grid + u;
        s->marked[v * k_cells + u] =
            spread(corner[0], corner[1], corner[k_grid], corner[k_grid + 1]) > s->threshold ? 1 : 0;
        continue;
      }
      uint8_t near = 0;
      for (uint32_t y = v == 0 ? 0 : v - 1; y <= v + 1 && y < k_cells; ++y)
        for (uint32_t x = u == 0 ? 0 : u - 1; x <= u + 1 && x < k_cells; ++x) near |= s->marked[y * k_cells + x];
      if (near != 0) s->refined[s->refined_count++] = static_cast<uint16_t>(v * k_cells + u);
      else interpolate_cell(s, u, v);
    }
  }
  if (s->cursor < 2 * k_cells) return;
  if (s->refined_count == 0) return end_texture(s);
  go_to(s, ShadowPhase::refine);
}

// All texels of the refined cells, except the corner that is known from the coarse grid.
constexpr uint32_t k_new_texels = k_cell * k_cell - 1;

void run_refine(Shadow* s) {
  const uint32_t first = s->cursor;
  const uint32_t cells = s->unit_texels / k_new_texels;
  const uint32_t end = first + cells < s->refined_count ? first + cells : s->refined_count;
  uint32_t count = 0;
  for (; s->cursor < end; ++s->cursor) {
    const uint32_t u = s->refined[s->cursor] % k_cells * k_cell, v = s->refined[s->cursor] / k_cells * k_cell;
    for (uint32_t i = 1; i < k_cell * k_cell; ++i, ++count) {
      s->unit_u[count] = static_cast<uint16_t>(u + i % k_cell);
      s->unit_v[count] = static_cast<uint16_t>(v + i / k_cell);
    }
    s->back.coverage[v * k_shadow_size + u] = s->coarse[v / k_cell * k_grid + u / k_cell];
  }
  evaluate_unit(s, count);
  for (uint32_t i = 0; i < count; ++i)
    s->back.coverage[s->unit_v[i] * k_shadow_size + s->unit_u[i]] = s->unit_coverage[i];
  if (s->cursor == s->refined_count) end_texture(s);
}

void run_full(Shadow* s) {
  const uint32_t texels = k_shadow_size * k_shadow_size, first = s->cursor;
  uint32_t count = 0;
  for (; s->cursor < texels && count < s->unit_texels; ++s->cursor, ++count) {
    s->unit_u[count] = static_cast<uint16_t>(s->cursor % k_shadow_size);
    s->unit_v[count] = static_cast<uint16_t>(s->cursor / k_shadow_size);
  }
  evaluate_unit(s, count);
  for (uint32_t i = 0; i < count; ++i) s->back.coverage[first + i] = s->unit_coverage[i];
  if (s->cursor == texels) end_texture(s);
}

}  // namespace

// Twice what rounding a direction to floats can take from its cosine. So a light that an app puts exactly at the limit
// counts as within it.
constexpr double k_limit_rounding = 2.4e-7;

// A light beyond polar_max is turned up to it at the same azimuth, and its shadow fades towards the horizon.
void shadow_set_light(Shadow* s, uint32_t number, const double unit_vector[3], float irradiance) {
  ShadowLight& l = s->lights[number];
  ++l.calls;
  double light[3] = {unit_vector[0], unit_vector[1], unit_vector[2]};
  l.irradiance = irradiance;
  l.opacity = 1;
  l.beyond = light[1] < s->polar_cosine - k_limit_rounding;
  if (l.beyond) {
    const double flat = square_root(light[0] * light[0] + light[2] * light[2]);
    const double polar = arc_tangent2(flat, light[1]);
    const double fade = (0.5 * k_pi - polar) / (0.5 * k_pi - s->polar_max);
    l.opacity = fade > 0 ? static_cast<float>(fade < 1 ? fade : 1) : 0.0f;
    // Straight down it has no azimuth, and no shadow.
    const double scale = flat > 0 ? s->polar_sine / flat : 0;
    light[0] = flat > 0 ? light[0] * scale : s->polar_sine;
    light[1] = s->polar_cosine;
    light[2] *= scale;
  }
  if (l.beyond && !(l.opacity > 0)) {  // there is nothing to see
    l.pending = false;
    return;
  }
  const bool under_way = s->phase != ShadowPhase::idle && s->active == number;
  if (l.pending || under_way || l.front.valid) {
    const double* last = l.pending ? l.wanted : under_way ? s->back.light : l.front.light;
    double chord = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) chord += (light[axis] - last[axis]) * (light[axis] - last[axis]);
    if (!(chord > s->tolerance_squared)) return;
  }
  for (uint32_t axis = 0; axis < 3; ++axis) l.wanted[axis] = light[axis];
  if (!l.pending) l.pending_since = l.calls;
  l.pending = true;
}

// The two kinds that run the network count its size too, in units of 1024 products a texel. So one prediction serves
// networks of any size.
ShadowUnit shadow_unit(const Shadow& s, uint32_t kind) {
  const uint32_t weight = s.network.layers * s.network.width * s.network.width / 1024;
  switch (kind) {
    case k_kind_rows:
      return {k_unit_table_rows, k_unit_table_rows * s.network.width};
    case k_kind_decide:
      return {k_unit_cell_rows, k_unit_cell_rows};
    case k_kind_refine:
      return {s.unit_texels / k_new_texels, s.unit_texels * weight};
    case k_kind_ambient:
      return {k_unit_ambient_texels, k_unit_ambient_texels * s.ambient.components.count};
    default:
      return {s.unit_texels, s.unit_texels * weight};
  }
}

WorkUnit shadow_next(const Shadow& s) {
  const auto of_kind = [&](uint32_t kind, const char* name) -> WorkUnit {
    return {kind, shadow_unit(s, kind).items, name};
  };
  switch (s.phase) {
    case ShadowPhase::idle:
    case ShadowPhase::rows:
      return of_kind(k_kind_rows, "shadow.rows");
    case ShadowPhase::coarse:
      return of_kind(k_kind_texels, "shadow.coarse");
    case ShadowPhase::decide:
      return of_kind(k_kind_decide, "shadow.decide");
    case ShadowPhase::refine:
      return of_kind(k_kind_refine, "shadow.refine");
    case ShadowPhase::full:
      return of_kind(k_kind_texels, "shadow.texels");
  }
  return {};
}

WorkUnit shadow_ambient_next(const Shadow& s) {
  return {k_kind_ambient, shadow_unit(s, k_kind_ambient).items, "shadow.ambient"};
}

void shadow_run(Shadow* s, uint32_t light) {
  switch (s->phase) {
    case ShadowPhase::idle:
      begin_texture(s, light);
      s->phase = ShadowPhase::rows;
      s->cursor = 0;
      s->refined_count = 0;
      [[fallthrough]];
    case ShadowPhase::rows:
      return run_rows(s);
    case ShadowPhase::coarse:
      return run_coarse(s);
    case ShadowPhase::decide:
      return run_decide(s);
    case ShadowPhase::refine:
      return run_refine(s);
    case ShadowPhase::full:
      return run_full(s);
  }
}

ShadowWork shadow_work_left(const Shadow& s, bool likely) {
  ShadowWork left = {};
  uint64_t &rows = left.pieces[k_kind_rows], &texels = left.pieces[k_kind_texels];
  uint64_t &decide = left.pieces[k_kind_decide], &refine = left.pieces[k_kind_refine];
  const bool full = s.mode == SANDGLASS_SHADOW_FULL;
  const uint64_t all = full ? k_shadow_size * k_shadow_size : k_grid * k_grid;
  const auto cells_of = [&](uint32_t light) -> uint64_t {
    const ShadowTexture& last = s.lights[light].front;
    return likely && last.valid ? (last.evaluated - all) / k_new_texels : k_cells * k_cells;
  };
  const auto whole = [&](uint32_t light) {
    rows += k_table_rows;
    texels += all;
    if (!full) {
      decide += 2 * k_cells;
      refine += cells_of(light);
    }
  };
  switch (s.phase) {
    case ShadowPhase::idle:
      break;
    case ShadowPhase::rows:
      whole(s.active);
      rows -= s.cursor;
      break;
    case ShadowPhase::coarse:
      texels += all - s.cursor;
      decide += 2 * k_cells;
      refine += cells_of(s.active);
      break;
    case ShadowPhase::decide:
      decide += 2 * k_cells - s.cursor;
      refine += cells_of(s.active);
      break;
    case ShadowPhase::refine:
      refine += s.refined_count - s.cursor;
      break;
    case ShadowPhase::full:
      texels += all - s.cursor;
      break;
  }
  for (uint32_t i = 0; i < s.light_count; ++i)
    if (s.lights[i].pending) whole(i);
  left.pieces[k_kind_ambient] = ambient_texels_left(s.ambient);
  return left;
}

}  // namespace sandglass

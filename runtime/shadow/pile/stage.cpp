// A pile's part in a frame: what asks for textures, and their phases one after another.
#include <cstdint>
#include <cstring>

#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

void begin_columns(Pile* p) {
  columns_begin(&p->columns, p->rectangle.texels);
  walk_begin(&p->skin, p->request.source);
  air_begin(&p->air, p->rectangle.texels);
}

void begin(Pile* p) {
  p->progress.phase = PilePhase::columns;
  p->progress.restarts = 0;
  p->progress.making = pile_wanted(*p);
  // While sand moves, what it leaves of the room's light is made every other time: it is softer.
  p->progress.skips_sky = p->request.source.moving && p->progress.making == k_ask_all && !p->progress.skips_sky;
  p->request.asked &= ~p->progress.making;
  if (p->progress.skips_sky) p->progress.making = k_ask_light;  // the next frame asks again
  p->textures.back.frame = p->request.frame;
  if ((p->progress.making & k_ask_sky) != 0) sky_begin(&p->sky, p->request.frame);
  for (uint32_t axis = 0; axis < 3; ++axis) p->lighting.made_for[axis] = p->request.light[axis];
  const SinCos half = sin_cos_turns(0.25 / k_pi * p->request.width);
  p->lighting.half_sine = half.sin;
  p->lighting.half_cosine = half.cos;
  begin_columns(p);
}

// A skin that is exchanged before its columns stand is taken from the start, so that all are of one; not for ever.
void run_columns(Pile* p) {
  constexpr uint32_t k_restarts = 3;
  const SkinState* skin = p->request.source.skin;
  if (p->progress.phase == PilePhase::idle) begin(p);
  else if (skin != nullptr && skin->front_version != p->skin.version && p->progress.restarts++ < k_restarts)
    begin_columns(p);
  if (!columns_run(&p->columns, &p->skin, &p->air, *p)) return;
  const bool light = (p->progress.making & k_ask_light) != 0;
  if (light) lighting_cut(&p->lighting, *p);
  p->progress.phase = light ? PilePhase::floor : PilePhase::levels;
}

void run_rows(Pile* p) {
  PileTexture &front = p->textures.front, &back = p->textures.back;
  const bool floor = p->progress.phase == PilePhase::floor;
  if (!lighting_run(&p->lighting, *p, floor ? back.floor : back.sand, floor)) return;
  if (floor && back.sand != nullptr) {
    p->progress.phase = PilePhase::sand;
    return;
  }
  const uint64_t texels = uint64_t{p->rectangle.texels} * p->rectangle.texels;
  const bool same = front.version != 0 && memcmp(front.floor, back.floor, texels) == 0 &&
                    (back.sand == nullptr || memcmp(front.sand, back.sand, texels) == 0);
  back.version = front.version + (same ? 0 : 1);
  const PileTexture swap = front;
  front = back;
  back = swap;
  p->textures.valid = true;
  p->progress.making &= ~k_ask_light;
  p->progress.phase = p->progress.making != 0 ? PilePhase::levels : PilePhase::idle;
}

void run_sky(Pile* p) {
  if (p->progress.phase == PilePhase::levels) {
    if (sky_run_levels(&p->sky, *p)) p->progress.phase = PilePhase::sky;
    return;
  }
  if (!sky_run_rows(&p->sky, *p)) return;
  sky_end(&p->sky, *p);
  p->progress.making = 0;
  p->progress.phase = PilePhase::idle;
}

bool has_work(const Pile& p) { return p.progress.phase != PilePhase::idle || pile_wanted(p) != 0; }

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
  const uint32_t making = p.progress.phase == PilePhase::idle ? pile_wanted(p) : p.progress.making;
  uint64_t columns = 0, rows = 0, levels = 0, sky_rows = 0;
  if ((making & k_ask_light) != 0) rows = (p.textures.back.sand != nullptr ? 2u : 1u) * p.rectangle.texels;
  if ((making & k_ask_sky) != 0) {
    levels = sky.rows;
    sky_rows = sky.texels;
  }
  if (p.progress.phase == PilePhase::idle) columns = p.request.source.count;
  else if (p.progress.phase == PilePhase::columns)
    columns = p.request.source.count > p.columns.next ? p.request.source.count - p.columns.next : 0;
  else if (p.progress.phase == PilePhase::levels) levels -= sky.level_row;
  else if (p.progress.phase == PilePhase::sky) {
    levels = 0;
    sky_rows -= sky.row;
  } else rows -= p.lighting.row + (p.progress.phase == PilePhase::sand ? p.rectangle.texels : 0);
  const Forecast all[] = {{k_pile_columns, columns, true},
                          {k_pile_rows, rows * p.rectangle.texels, true},
                          {k_pile_levels, levels * sky.texels, true},
                          {k_pile_sky_rows, sky_rows * sky.texels, true}};
  uint32_t count = 0;
  for (const Forecast& entry : all)
    if (entry.items != 0) entries[count++] = entry;
  return count;
}

bool under_way(const void* handle) {
  return static_cast<const sandglass_pile_shadow*>(handle)->pile.progress.phase != PilePhase::idle;
}

uint32_t begin_frame(void* handle, const FrameView& view) {
  Pile& p = static_cast<sandglass_pile_shadow*>(handle)->pile;
  const DrawnSand& sand = view.drawn;
  ++p.request.frame;
  // Also in the frame after the last motion: the texture under way then shows sand that still moved.
  const bool changed = sand.count != p.request.source.count || sand.version != p.request.source.version;
  if (sand.moving || p.request.source.moving || changed) p.request.asked = k_ask_all;
  p.request.source = sand;
  return 0;
}

}  // namespace

WorkUnit pile_next(const Pile& p) {
  if (p.progress.phase == PilePhase::idle || p.progress.phase == PilePhase::columns) {
    const uint32_t from = p.progress.phase == PilePhase::idle ? 0 : p.columns.next, limit = columns_unit_items(p);
    const uint32_t left = p.request.source.count > from ? p.request.source.count - from : 0;
    return {k_pile_columns, left == 0 ? 1 : left < limit ? left : limit, "pile_shadow.columns"};
  }
  if (p.progress.phase == PilePhase::levels) return {k_pile_levels, k_sky_unit_windows, "pile_shadow.levels"};
  if (p.progress.phase == PilePhase::sky) return {k_pile_sky_rows, k_sky_unit_texels, "pile_shadow.sky"};
  return {k_pile_rows, k_pile_unit_texels,
          p.progress.phase == PilePhase::floor ? "pile_shadow.floor" : "pile_shadow.sand"};
}

void pile_run(Pile* p) {
  if (p->progress.phase == PilePhase::idle || p->progress.phase == PilePhase::columns) run_columns(p);
  else if (p->progress.phase == PilePhase::levels || p->progress.phase == PilePhase::sky) run_sky(p);
  else run_rows(p);
}

extern const Capability k_pile_capability = {
    .begin_frame = begin_frame, .next = next, .run = run, .forecast = forecast, .under_way = under_way};

}  // namespace sandglass

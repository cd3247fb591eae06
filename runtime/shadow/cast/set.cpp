// Which unit is next: within a cast, the phases of a texture, and which of its two textures; and among several casts. A
// texture under way is completed first; then the cast that was served longest ago comes.
#include "platform/floating_point.h"
#include "runtime/shadow/baked/shadow.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

bool wanted(const CastState& c, uint32_t which) {
  return c.targets[which].asked && (which != k_cast_light || c.light_known);
}

bool has_work(const CastState& c) {
  return c.phase != CastPhase::idle || wanted(c, k_cast_light) || wanted(c, k_cast_ambient);
}

// Each texture in turn; a better one follows a first one at once.
uint32_t next_target(const CastState& c) {
  const uint32_t other = 1 - c.last_target;
  const bool improves =
      c.last_target == k_cast_light && c.targets[k_cast_light].front.directions == k_cast_draft_directions;
  return wanted(c, other) && !(improves && wanted(c, c.last_target)) ? other : c.last_target;
}

void complete(CastState* c) {
  CastTarget* target = &c->targets[c->target];
  const CastTexture swap = target->front;
  target->front = target->back;
  target->back = swap;
  target->valid = true;
  ++target->completed;
  c->phase = CastPhase::idle;
  c->restarts = 0;
  c->last_target = c->target;
  if (c->target == k_cast_ambient && c->shade_found != c->in_shade) {
    c->in_shade = c->shade_found;
    c->targets[k_cast_light].asked = c->targets[k_cast_light].texels != 0;
  }
  cast_compare(c);  // meshes or plane may have changed meanwhile
}

void begin(CastState* c) {
  c->target = next_target(*c);
  if (c->stale) cast_begin_gather(c);
  else cast_begin_draw(c);
}

void run_unit(CastState* c) {
  if (c->phase == CastPhase::idle) begin(c);
  if (c->phase == CastPhase::gather) {
    if (!cast_gather(c)) return;
    cast_begin_draw(c);
  } else if (c->phase == CastPhase::draw) {
    if (cast_draw(c)) cast_begin_calm(c);
  } else if (cast_calm(c)) {
    complete(c);
  }
}

WorkUnit unit_of(const CastState& c) {
  const bool gathers = c.phase == CastPhase::gather || (c.phase == CastPhase::idle && c.stale);
  if (gathers) return {k_cast_gather, k_cast_unit_triangles, "cast.gather"};
  if (c.phase == CastPhase::calm) return {k_cast_calm, k_cast_unit_texels, "cast.calm"};
  return {k_cast_draw, k_cast_unit_rows, "cast.draw"};
}

const CastSet& set_of(const void* state) { return *static_cast<const CastSet*>(state); }

// The cast whose unit is next, or null.
CastState* choose(const CastSet& set) {
  CastState* chosen = nullptr;
  for (uint32_t i = 0; i < set.count; ++i) {
    CastState* c = &set.casts[i]->cast;
    if (c->phase != CastPhase::idle) return c;
    if (has_work(*c) && (chosen == nullptr || c->served < chosen->served)) chosen = c;
  }
  return chosen;
}

void run_next(const CastSet& set) {
  CastState* c = choose(set);
  if (c == nullptr) return;
  run_unit(c);
  uint64_t latest = 0;
  for (uint32_t i = 0; i < set.count; ++i)
    latest = set.casts[i]->cast.served > latest ? set.casts[i]->cast.served : latest;
  c->served = latest + 1;
  if (c->phase == CastPhase::idle) set.casts[0]->cast.gives_way = true;
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const CastState* c = choose(set_of(state));
  if (c == nullptr) return false;
  *unit = unit_of(*c);
  return true;
}

void run(void* state, uint32_t) { run_next(set_of(state)); }

// What a texture takes is known by the one before: rows are about as many.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const CastSet& set = set_of(state);
  uint64_t items[k_cast_kinds] = {};
  for (uint32_t i = 0; i < set.count; ++i) {
    const CastState& c = set.casts[i]->cast;
    if (c.phase == CastPhase::gather || c.stale) items[k_cast_gather] += c.triangles;
    for (uint32_t which = 0; which < k_cast_targets; ++which) {
      const bool active = c.phase != CastPhase::idle && c.target == which;
      if (!active && !wanted(c, which)) continue;
      const CastTarget& target = c.targets[which];
      const uint64_t texels = uint64_t{target.texels} * target.texels;
      items[k_cast_draw] += target.rows;
      items[k_cast_calm] += 3 * texels;
    }
  }
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_cast_kinds; ++kind)
    if (items[kind] != 0) entries[count++] = {kind, items[kind], true};
  return count;
}

Stage stage(CastSet* set) { return {set, next, run, forecast, k_cast_kinds, 1, k_shadow_share}; }

bool under_way(const CastSet& set) {
  for (uint32_t i = 0; i < set.count; ++i)
    if (set.casts[i]->cast.phase != CastPhase::idle) return true;
  return false;
}

uint32_t pending(const CastSet& set) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < set.count; ++i) {
    const CastState& c = set.casts[i]->cast;
    for (uint32_t which = 0; which < k_cast_targets; ++which)
      count += wanted(c, which) || (c.phase != CastPhase::idle && c.target == which) ? 1 : 0;
  }
  return count;
}

}  // namespace

extern const CastFunctions k_cast_functions = {stage, under_way, pending};

}  // namespace sandglass

using namespace sandglass;

uint32_t sandglass_cast_run(sandglass_cast* const* casts, uint32_t count, uint32_t units) {
  if (casts == nullptr) return 0;
  for (uint32_t i = 0; i < count; ++i)
    if (casts[i] == nullptr) return 0;
  const CastSet set = {casts, count};
  const ExactFloatingPoint exact;
  uint32_t done = 0;
  for (; done < units && choose(set) != nullptr; ++done) run_next(set);
  return done;
}

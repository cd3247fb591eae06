// A cast's part in a frame: which of its two textures is next, and the phases of one.
#include "platform/floating_point.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

bool wanted(const CastState& c, uint32_t which) {
  return c.targets[which].asked && (which != k_cast_light || c.request.light_known);
}

// Whether that texture is asked for or under way.
bool is_pending(const CastState& c, uint32_t which) {
  return wanted(c, which) || (c.progress.phase != CastPhase::idle && c.progress.target == which);
}

bool has_work(const CastState& c) {
  return c.progress.phase != CastPhase::idle || wanted(c, k_cast_light) || wanted(c, k_cast_ambient);
}

// Each texture in turn; a better one follows a first one at once.
uint32_t next_target(const CastState& c) {
  const uint32_t other = 1 - c.progress.last_target;
  const bool improves =
      c.progress.last_target == k_cast_light && c.targets[k_cast_light].front.directions == k_cast_draft_directions;
  return wanted(c, other) && !(improves && wanted(c, c.progress.last_target)) ? other : c.progress.last_target;
}

void complete(CastState* c) {
  CastProgress* progress = &c->progress;
  CastTarget* target = &c->targets[progress->target];
  const CastTexture swap = target->front;
  target->front = target->back;
  target->back = swap;
  target->valid = true;
  ++target->completed;
  progress->phase = CastPhase::idle;
  c->comparison.restarts = 0;
  progress->last_target = progress->target;
  if (progress->target == k_cast_ambient && c->calm.shade_found != progress->in_shade) {
    progress->in_shade = c->calm.shade_found;
    c->targets[k_cast_light].asked = c->targets[k_cast_light].texels != 0;
  }
  cast_compare(c);  // meshes or plane may have changed meanwhile
}

void begin_draw(CastState* c) {
  cast_begin_draw(&c->drawing, &c->targets[c->progress.target], *c);
  c->progress.phase = CastPhase::draw;
}

void begin(CastState* c) {
  c->progress.target = next_target(*c);
  if (!c->comparison.stale) return begin_draw(c);
  c->comparison.stale = false;
  cast_begin_gather(&c->gathered, c->request.meshes, c->request);
  c->progress.phase = CastPhase::gather;
}

void run_unit(CastState* c) {
  CastProgress* progress = &c->progress;
  if (progress->phase == CastPhase::idle) begin(c);
  CastTarget* target = &c->targets[progress->target];
  if (progress->phase == CastPhase::gather) {
    if (cast_gather(&c->gathered, c->request.meshes, c->request.mesh_count, c->desc.reach)) begin_draw(c);
  } else if (progress->phase == CastPhase::draw) {
    if (!cast_draw(&c->drawing, target, *c)) return;
    cast_begin_calm(&c->calm);
    progress->phase = CastPhase::calm;
  } else if (cast_calm(&c->calm, target->back.bytes, *c)) {
    complete(c);
  }
}

WorkUnit unit_of(const CastState& c) {
  const bool gathers =
      c.progress.phase == CastPhase::gather || (c.progress.phase == CastPhase::idle && c.comparison.stale);
  if (gathers) return {k_cast_gather, k_cast_unit_triangles, "cast.gather"};
  if (c.progress.phase == CastPhase::calm) return {k_cast_calm, k_cast_unit_texels, "cast.calm"};
  return {k_cast_draw, k_cast_unit_rows, "cast.draw"};
}

const CastState& cast_of(const void* handle) { return static_cast<const sandglass_cast*>(handle)->cast; }

bool next(const void* handle, uint32_t, WorkUnit* unit) {
  const CastState& c = cast_of(handle);
  if (!has_work(c)) return false;
  *unit = unit_of(c);
  return true;
}

void run(void* handle, uint32_t) { run_unit(&static_cast<sandglass_cast*>(handle)->cast); }

// What a texture takes is known by the one before: rows are about as many.
uint32_t forecast(const void* handle, uint32_t, Forecast* entries) {
  const CastState& c = cast_of(handle);
  uint64_t items[k_cast_kinds] = {};
  if (c.progress.phase == CastPhase::gather || c.comparison.stale)
    items[k_cast_gather] = uint64_t{c.comparison.triangles} * c.desc.layers;
  for (uint32_t which = 0; which < k_cast_targets; ++which) {
    if (!is_pending(c, which)) continue;
    const CastTarget& target = c.targets[which];
    items[k_cast_draw] += target.rows;
    items[k_cast_calm] += 3 * uint64_t{c.desc.layers} * target.texels * target.texels;
  }
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_cast_kinds; ++kind)
    if (items[kind] != 0) entries[count++] = {kind, items[kind], true};
  return count;
}

bool under_way(const void* handle) { return cast_of(handle).progress.phase != CastPhase::idle; }

uint32_t begin_frame(void*, const FrameView&) { return 0; }

void end_frame(void* handle, sandglass_frame_report* report) {
  for (uint32_t which = 0; which < k_cast_targets; ++which)
    report->shadows.pending += is_pending(cast_of(handle), which) ? 1 : 0;
}

}  // namespace

extern const Capability k_cast_capability = {.begin_frame = begin_frame,
                                             .next = next,
                                             .run = run,
                                             .forecast = forecast,
                                             .under_way = under_way,
                                             .end_frame = end_frame};

}  // namespace sandglass

using namespace sandglass;

uint32_t sandglass_cast_run(sandglass_cast* const* casts, uint32_t count, uint32_t units) {
  if (casts == nullptr) return 0;
  for (uint32_t i = 0; i < count; ++i)
    if (casts[i] == nullptr) return 0;
  const ExactFloatingPoint exact;
  return run_members(Members{casts, count, k_cast_kinds}, units);
}

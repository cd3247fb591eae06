// Objects, sand and casts take turns. A texture under way is completed first, whoever casts it. Then one of each follows
// another for as long as all ask: who has completed one gives way to the others.
//
// This file calls them only through the tables that creation left in their handles: a scene links it, and with it none of
// them.
#include "runtime/shadow/stage.h"

namespace sandglass {
namespace {

enum : uint32_t { k_objects, k_sand, k_casts };

bool object_under_way(const ShadowSet& set) {
  for (uint32_t i = 0; i < set.count; ++i)
    if (set.shadows[i]->shadow.phase != ShadowPhase::idle || set.shadows[i]->shadow.ambient.under_way) return true;
  return false;
}

bool under_way(const FrameShadows& shadows, uint32_t part) {
  if (part == k_objects) return object_under_way(shadows.objects);
  if (part == k_sand) return shadows.pile->pile.phase != PilePhase::idle;
  return shadows.casts.casts[0]->functions->under_way(shadows.casts);
}

// Objects come when sand and casts both give way.
bool gives_way(const FrameShadows& shadows, uint32_t part) {
  if (part == k_objects) return false;
  return part == k_sand ? shadows.pile->pile.gives_way : shadows.casts.casts[0]->cast.gives_way;
}

// Which part's unit is next. False: none offers one.
bool choose(const FrameShadows& shadows, uint32_t level, uint32_t* chosen, WorkUnit* unit) {
  constexpr uint32_t k_order[k_shadow_parts] = {k_sand, k_casts, k_objects};
  bool any = false, waits = true;
  for (const uint32_t part : k_order) {
    WorkUnit offer;
    if (!stage_next(shadows.parts[part], level, &offer)) continue;
    const bool goes_on = under_way(shadows, part), first = waits && !gives_way(shadows, part);
    if (any && !goes_on && !first) continue;
    *chosen = part;
    *unit = offer;
    any = true;
    waits = waits && !first;
    if (goes_on) return true;
  }
  return any;
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  uint32_t part;
  return choose(*static_cast<const FrameShadows*>(state), level, &part, unit);
}

void run(void* state, uint32_t level) {
  FrameShadows* shadows = static_cast<FrameShadows*>(state);
  uint32_t part;
  WorkUnit unit;
  if (!choose(*shadows, level, &part, &unit)) return;
  const bool all = part == k_objects || gives_way(*shadows, part);  // a round is over
  if (all && shadows->pile != nullptr) shadows->pile->pile.gives_way = false;
  if (all && shadows->casts.count != 0) shadows->casts.casts[0]->cast.gives_way = false;
  shadows->parts[part].run(shadows->parts[part].state, level);
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const FrameShadows& shadows = *static_cast<const FrameShadows*>(state);
  uint32_t count = 0;
  for (const Stage& part : shadows.parts) count += stage_forecast(part, level, entries + count);
  return count;
}

}  // namespace

Stage shadow_stage(FrameShadows* shadows, const Sand& sand) {
  ShadowSet* objects = &shadows->objects;
  shadows->parts[k_objects] =
      objects->count == 0 ? stage_without_work(k_shadow_kinds) : objects->shadows[0]->functions->stage(objects);
  shadows->parts[k_sand] = shadows->pile == nullptr
                               ? stage_without_work(k_pile_kinds)
                               : shadows->pile->functions->begin_frame(shadows->pile, sand.source, sand.moving);
  CastSet* casts = &shadows->casts;
  shadows->parts[k_casts] =
      casts->count == 0 ? stage_without_work(k_cast_kinds) : casts->casts[0]->functions->stage(casts);
  assign_kinds(shadows->parts, k_shadow_parts);
  return {shadows, next, run, forecast, k_shadow_stage_kinds, 1, k_shadow_share};
}

void shadow_end_frame(const FrameShadows& shadows, sandglass_frame_report* report) {
  const ShadowSet& objects = shadows.objects;
  if (objects.count != 0) objects.shadows[0]->functions->report(objects, report);
  const CastSet& casts = shadows.casts;
  if (casts.count != 0) report->shadows.pending += casts.casts[0]->functions->pending(casts);
}

}  // namespace sandglass

// Objects and sand take turns. A texture under way is completed first, whoever casts it. Then one of an object and one
// of the sand follow each other for as long as both ask.
//
// This file calls objects and sand only through the tables that creation left in their handles: a scene links it, and
// with it neither of the two.
#include "runtime/shadow/stage.h"

namespace sandglass {
namespace {

enum : uint32_t { k_objects, k_sand };

bool object_under_way(const ShadowSet& set) {
  for (uint32_t i = 0; i < set.count; ++i)
    if (set.shadows[i]->shadow.phase != ShadowPhase::idle || set.shadows[i]->shadow.ambient.under_way) return true;
  return false;
}

// Whether the sand's unit comes before that of an object, where both offer one.
bool sand_goes_first(const FrameShadows& shadows) {
  const Pile& pile = shadows.pile->pile;
  if (pile.phase != PilePhase::idle) return true;
  return !object_under_way(shadows.objects) && !pile.gives_way;
}

// Which part's unit is next. False: neither offers one.
bool choose(const FrameShadows& shadows, uint32_t level, uint32_t* part, WorkUnit* unit) {
  WorkUnit of_object, of_sand;
  const bool objects = stage_next(shadows.parts[k_objects], level, &of_object);
  const bool sand = stage_next(shadows.parts[k_sand], level, &of_sand);
  *part = sand && (!objects || sand_goes_first(shadows)) ? k_sand : k_objects;
  *unit = *part == k_sand ? of_sand : of_object;
  return objects || sand;
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
  shadows->parts[part].run(shadows->parts[part].state, level);
  if (part == k_objects && shadows->pile != nullptr) shadows->pile->pile.gives_way = false;
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const FrameShadows& shadows = *static_cast<const FrameShadows*>(state);
  const uint32_t count = stage_forecast(shadows.parts[k_objects], level, entries);
  return count + stage_forecast(shadows.parts[k_sand], level, entries + count);
}

}  // namespace

Stage shadow_stage(FrameShadows* shadows, const Sand& sand) {
  ShadowSet* objects = &shadows->objects;
  shadows->parts[k_objects] =
      objects->count == 0 ? stage_without_work(k_shadow_kinds) : objects->shadows[0]->functions->stage(objects);
  shadows->parts[k_sand] = shadows->pile == nullptr
                               ? stage_without_work(k_pile_kinds)
                               : shadows->pile->functions->begin_frame(shadows->pile, sand.source, sand.moving);
  assign_kinds(shadows->parts, 2);
  return {shadows, next, run, forecast, k_shadow_stage_kinds, 1, k_shadow_share};
}

void shadow_end_frame(const FrameShadows& shadows, sandglass_frame_report* report) {
  const ShadowSet& objects = shadows.objects;
  if (objects.count != 0) objects.shadows[0]->functions->report(objects, report);
}

}  // namespace sandglass

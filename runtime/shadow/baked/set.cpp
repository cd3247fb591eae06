// Several objects, each with several lights, under one budget: which texture is computed next.
//
// A texture under way is completed first. An ambient shadow costs about a hundredth of the network's texture, so one
// that waits is begun before any light's, but while lights wait no object gets a second one before a light has got its
// own. An object without any shadow gets its ambient one at once. Among lights the texture with the greatest visible
// change is begun. Its visible change is the product of
//   the turn of the light since the texture that is shown, as a chord (2 where none is shown),
//   the light's share of all irradiance on the object,
//   the opacity,
//   a factor that grows while it waits, so that a strong light that always moves cannot starve a weak one.
#include "runtime/math/math.h"
#include "runtime/shadow/baked/shadow.h"

namespace sandglass {
namespace {

constexpr double k_no_texture = 2;           // the chord of half a turn
constexpr double k_growth_a_call = 1.0 / 8;  // growth of the factor with every call of set_light

struct Choice {
  uint32_t shadow, light;
  bool ambient;  // the ambient shadow, and no light
};

double visible_change(const Shadow& s, const ShadowLight& light, double irradiance) {
  double chord = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double turn = light.wanted[axis] - light.front.light[axis];
    chord += turn * turn;
  }
  const double change = light.front.valid ? square_root(chord) : k_no_texture;
  const double share = irradiance > 0 ? static_cast<double>(light.irradiance) / irradiance : 1.0 / s.light_count;
  const double waited = static_cast<double>(light.calls - light.pending_since);
  return change * share * static_cast<double>(light.opacity) * (1 + k_growth_a_call * waited);
}

// The first ambient shadow that the rule takes.
template <class Rule>
bool choose_ambient(const ShadowSet& set, Rule rule, Choice* choice) {
  for (uint32_t i = 0; i < set.count; ++i) {
    const AmbientShadow& ambient = set.shadows[i]->shadow.ambient;
    if (!ambient_waits(ambient) || !rule(ambient)) continue;
    *choice = {i, 0, true};
    return true;
  }
  return false;
}

// Of the lights' textures: the one under way, else the one with the greatest visible change.
bool choose_light(const ShadowSet& set, Choice* choice) {
  for (uint32_t i = 0; i < set.count; ++i)
    if (set.shadows[i]->shadow.phase != ShadowPhase::idle) {
      *choice = {i, set.shadows[i]->shadow.active, false};
      return true;
    }
  double most = -1;
  for (uint32_t i = 0; i < set.count; ++i) {
    const Shadow& s = set.shadows[i]->shadow;
    double irradiance = 0;
    for (uint32_t l = 0; l < s.light_count; ++l) irradiance += static_cast<double>(s.lights[l].irradiance);
    for (uint32_t l = 0; l < s.light_count; ++l) {
      if (!s.lights[l].pending) continue;
      const double change = visible_change(s, s.lights[l], irradiance);
      if (change > most) most = change, *choice = {i, l, false};
    }
  }
  return most >= 0;
}

bool choose(const ShadowSet& set, Choice* choice) {
  if (choose_ambient(
          set, [](const AmbientShadow& a) { return !a.valid || a.under_way; }, choice))
    return true;
  const bool light = choose_light(set, choice);
  if (light && set.shadows[choice->shadow]->shadow.phase != ShadowPhase::idle) return true;
  return choose_ambient(
             set, [&](const AmbientShadow& a) { return !light || !a.gives_way; }, choice) ||
         light;
}

const ShadowSet& set_of(const void* state) { return *static_cast<const ShadowSet*>(state); }

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const ShadowSet& set = set_of(state);
  Choice choice;
  if (!choose(set, &choice)) return false;
  const Shadow& s = set.shadows[choice.shadow]->shadow;
  *unit = choice.ambient ? shadow_ambient_next(s) : shadow_next(s);
  return true;
}

void run(void* state, uint32_t) {
  const ShadowSet& set = set_of(state);
  Choice choice;
  if (!choose(set, &choice)) return;
  Shadow* s = &set.shadows[choice.shadow]->shadow;
  if (choice.ambient) return ambient_run(*s->kernels, &s->ambient);
  shadow_run(s, choice.light);
  if (s->phase != ShadowPhase::idle) return;
  for (uint32_t i = 0; i < set.count; ++i) set.shadows[i]->shadow.ambient.gives_way = false;
}

uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const ShadowSet& set = set_of(state);
  uint64_t items[k_shadow_kinds] = {};
  for (uint32_t i = 0; i < set.count; ++i) {
    const Shadow& s = set.shadows[i]->shadow;
    const ShadowWork left = shadow_work_left(s, true);
    for (uint32_t kind = 0; kind < k_shadow_kinds; ++kind) {
      const ShadowUnit unit = shadow_unit(s, kind);
      items[kind] += (left.pieces[kind] * unit.items + unit.pieces - 1) / unit.pieces;
    }
  }
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_shadow_kinds; ++kind)
    if (items[kind] != 0) entries[count++] = {kind, items[kind], true};
  return count;
}

void report_set(const ShadowSet& set, sandglass_frame_report* report) {
  uint64_t oldest = 0;
  uint32_t pending = 0;
  for (uint32_t i = 0; i < set.count; ++i) {
    const Shadow& s = set.shadows[i]->shadow;
    pending += ambient_waits(s.ambient) ? 1 : 0;
    for (uint32_t l = 0; l < s.light_count; ++l) {
      const bool under_way = s.phase != ShadowPhase::idle && s.active == l;
      if (!s.lights[l].pending && !under_way) continue;
      ++pending;
      const uint64_t calls = s.lights[l].calls - s.lights[l].front.light_call;
      oldest = calls > oldest ? calls : oldest;
    }
  }
  report->shadows.pending = pending;
  report->shadows.calls_behind = static_cast<uint32_t>(oldest);
}

}  // namespace

Stage shadow_set_stage(ShadowSet* set) { return {set, next, run, forecast, k_shadow_kinds, 1, k_shadow_share}; }

extern const ShadowFunctions k_shadow_functions = {shadow_set_stage, report_set};

}  // namespace sandglass

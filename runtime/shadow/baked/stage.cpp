// An object's part in a frame: which of its textures is next, and how urgent it is beside those of other objects.
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

// What is more urgent than the visible change of any light: an ambient shadow, a light's texture under way, an object's first
// ambient shadow or one under way. And what is less: an ambient shadow that gives way to a light.
constexpr double k_ambient = 1e30, k_begun = 1e31, k_first = 1e32, k_gives_way = -1;

struct Choice {
  double urgency;
  uint32_t light;
  bool any, ambient;  // the ambient shadow, and no light
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

// The greatest visible change of a light that waits.
Choice choose_light(const Shadow& s) {
  if (s.phase != ShadowPhase::idle) return {k_begun, s.active, true, false};
  Choice choice = {};
  double irradiance = 0;
  for (uint32_t l = 0; l < s.light_count; ++l) irradiance += static_cast<double>(s.lights[l].irradiance);
  for (uint32_t l = 0; l < s.light_count; ++l) {
    if (!s.lights[l].pending) continue;
    const double change = visible_change(s, s.lights[l], irradiance);
    if (!choice.any || change > choice.urgency) choice = {change, l, true, false};
  }
  return choice;
}

Choice choose(const Shadow& s) {
  const AmbientShadow& a = s.ambient;
  const Choice light = choose_light(s);
  if (!ambient_waits(a)) return light;
  const double ambient = !a.valid || a.under_way ? k_first : a.gives_way ? k_gives_way : k_ambient;
  return light.any && light.urgency > ambient ? light : Choice{ambient, 0, true, true};
}

const Shadow& shadow_of(const void* handle) { return static_cast<const sandglass_shadow*>(handle)->shadow; }

bool next(const void* handle, uint32_t, WorkUnit* unit) {
  const Shadow& s = shadow_of(handle);
  const Choice choice = choose(s);
  if (choice.any) *unit = choice.ambient ? shadow_ambient_next(s) : shadow_next(s);
  return choice.any;
}

void run(void* handle, uint32_t) {
  Shadow* s = &static_cast<sandglass_shadow*>(handle)->shadow;
  const Choice choice = choose(*s);
  s->light_done = false;
  if (choice.ambient) return ambient_run(*s->kernels, &s->ambient);
  shadow_run(s, choice.light);
  s->light_done = s->phase == ShadowPhase::idle;
}

bool under_way(const void* handle) {
  const Shadow& s = shadow_of(handle);
  return s.phase != ShadowPhase::idle || s.ambient.under_way;
}

double urgency(const void* handle) { return choose(shadow_of(handle)).urgency; }

void served(void* handle, const void* by) {
  if (shadow_of(by).light_done) static_cast<sandglass_shadow*>(handle)->shadow.ambient.gives_way = false;
}

uint32_t forecast(const void* handle, uint32_t, Forecast* entries) {
  const Shadow& s = shadow_of(handle);
  const ShadowWork left = shadow_work_left(s, true);
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_shadow_kinds; ++kind) {
    const ShadowUnit unit = shadow_unit(s, kind);
    const uint64_t items = (left.pieces[kind] * unit.items + unit.pieces - 1) / unit.pieces;
    if (items != 0) entries[count++] = {kind, items, true};
  }
  return count;
}

uint32_t begin_frame(void*, const FrameView&) { return 0; }

void end_frame(void* handle, sandglass_frame_report* report) {
  const Shadow& s = shadow_of(handle);
  report->shadows.pending += ambient_waits(s.ambient) ? 1 : 0;
  for (uint32_t l = 0; l < s.light_count; ++l) {
    const bool active = s.phase != ShadowPhase::idle && s.active == l;
    if (!s.lights[l].pending && !active) continue;
    ++report->shadows.pending;
    const auto behind = static_cast<uint32_t>(s.lights[l].calls - s.lights[l].front.light_call);
    if (behind > report->shadows.calls_behind) report->shadows.calls_behind = behind;
  }
}

}  // namespace

extern const Capability k_shadow_capability = {.begin_frame = begin_frame,
                                               .next = next,
                                               .run = run,
                                               .forecast = forecast,
                                               .under_way = under_way,
                                               .urgency = urgency,
                                               .served = served,
                                               .end_frame = end_frame};

}  // namespace sandglass

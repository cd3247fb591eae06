// The skin's stage of a frame: what asks for a skin, and its phases one after another.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

// To the state without sand.
void forget(SkinState* s) {
  bricks_forget(&s->bricks);
  sand_forget(&s->sand, s->desc.particle_capacity);
  s->progress.phase = SkinPhase::idle;
}

constexpr uint32_t k_kind_of[] = {k_skin_gather, k_skin_gather, k_skin_gather, k_skin_gather, k_skin_density,
                                  k_skin_fill,   k_skin_calm,   k_skin_mesh,   k_skin_loose};
constexpr const char* k_names[k_skin_kinds] = {"skin.gather", "skin.density", "skin.fill",
                                               "skin.calm",   "skin.mesh",    "skin.loose"};
constexpr uint32_t k_items[k_skin_kinds] = {k_skin_unit_items,
                                            k_skin_unit_bricks,
                                            k_skin_unit_layers,
                                            k_skin_unit_bricks,
                                            k_skin_unit_mesh,
                                            k_skin_unit_items,
                                            0};

bool takes(const SkinState& s) { return s.progress.phase <= SkinPhase::take; }

uint32_t kind_of(const SkinState& s) { return k_kind_of[static_cast<uint32_t>(s.progress.phase)]; }

uint32_t items_of(const SkinState& s) { return takes(s) ? skin_take_items(s) : k_items[kind_of(s)]; }

// Follows gravity: if up has changed, all bricks are filled anew, or the skin starts over.
void follow_up(SkinState* s) {
  const SkinTurn turn = lattice_follow(&s->lattice, *s->granular);
  if (turn == SkinTurn::none) return;
  if (turn == SkinTurn::other_axes) forget(s);
  for (uint32_t b = 0; b < s->bricks.count; ++b) s->bricks.records[b].stale |= k_stale_fill;
  s->requests.asked = true;
}

void begin(SkinState* s) {
  s->requests.asked = false;
  if (s->requests.whole_asked) forget(s);
  s->requests.whole_asked = false;
  s->progress.begun = s->frame;
  sand_begin_cycle(&s->sand, s->desc.particle_capacity);
  s->filter.next = 0;
  memset(s->progress.spent, 0, sizeof s->progress.spent);
  s->progress.phase = SkinPhase::take;
}

// Sand and colliders of one moment.
bool take(SkinState* s) {
  if (sand_begins(&s->sand, *s)) {
    solids_take(&s->solids, &s->bricks, *s, colliders_behind(*s->granular), &s->requests.asked);
    for (uint32_t b = 0; b < s->bricks.count; ++b)
      if ((s->bricks.records[b].stale & k_stale_solid) != 0) s->bricks.records[b].stale |= k_stale_density;
  }
  return skin_take(&s->sand, *s);
}

void run_unit(SkinState* s) {
  if (s->progress.phase == SkinPhase::idle) begin(s);
  // Sand that was taken as the frame began is taken again after its sub-steps.
  const bool early = s->sand.frame == s->frame && s->sand.substeps != s->granular->counts.moments();
  if (s->progress.phase == SkinPhase::gather_moved && s->sand.next_taken == 0 && early)
    s->progress.phase = SkinPhase::take;
  s->progress.spent[kind_of(*s)] += items_of(*s);
  s->requests.ran = true;
  switch (s->progress.phase) {
    case SkinPhase::take:
      if (take(s)) s->progress.phase = SkinPhase::gather_moved;
      break;
    case SkinPhase::gather_moved:
      if (skin_gather_moved(&s->sand, &s->bricks, *s)) s->progress.phase = SkinPhase::gather_gone;
      break;
    case SkinPhase::gather_gone:
      if (skin_gather_gone(&s->sand, &s->bricks)) s->progress.phase = SkinPhase::density;
      break;
    case SkinPhase::density:
      if (!skin_density(&s->filter, &s->solids, &s->bricks, *s)) break;
      skin_begin_fill(&s->fill, s->bricks);
      s->progress.phase = SkinPhase::fill;
      break;
    case SkinPhase::fill:
      if (skin_fill(&s->fill, &s->bricks, s->lattice)) s->progress.phase = SkinPhase::calm;
      break;
    case SkinPhase::calm:
      if (!skin_calm(&s->filter, &s->bricks, s->desc.capped != 0)) break;
      skin_begin_mesh(&s->meshes, *s);
      s->progress.phase = SkinPhase::mesh;
      break;
    case SkinPhase::mesh:
      if (!skin_mesh(&s->meshes, &s->bricks, *s)) break;
      skin_begin_loose(&s->meshes);
      s->progress.phase = SkinPhase::loose;
      break;
    default:
      if (!skin_loose(&s->meshes, &s->bricks, *s)) break;
      skin_publish(s);
      s->progress.phase = SkinPhase::idle;
  }
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  if (!skin_has_work(s)) return false;
  *unit = {kind_of(s), items_of(s), k_names[kind_of(s)]};
  return true;
}

void run(void* state, uint32_t) { run_unit(&static_cast<sandglass_skin*>(state)->skin); }

// What is left of the skin under way, or asked for, if it takes what the last one took. One that takes more than a
// frame is followed by another at once: then quality must not follow what is left of it.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  if (!skin_has_work(s)) return 0;
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_skin_carry; ++kind) {
    const uint32_t spent = s.progress.phase == SkinPhase::idle || skin_is_late(s) ? 0 : s.progress.spent[kind];
    const uint32_t left = s.progress.usual[kind] > spent ? s.progress.usual[kind] - spent : 0;
    const uint32_t next_items = kind == kind_of(s) ? items_of(s) : 0;
    if ((left > next_items ? left : next_items) != 0)
      entries[count++] = {kind, left > next_items ? left : next_items, true};
  }
  return count;
}

bool under_way(const void* handle) {
  return static_cast<const sandglass_skin*>(handle)->skin.progress.phase != SkinPhase::idle;
}

uint32_t begin_frame(void* handle, const FrameView& view) {
  SkinState* s = &static_cast<sandglass_skin*>(handle)->skin;
  const Granular& granular = *view.granular;
  ++s->frame;
  s->granular = &granular;
  s->kernels = granular.kernels;
  follow_up(s);
  // Also in the frame after the last motion: the skin under way then shows sand that still moved.
  const bool moving = granular.sleep.awake_count != 0;
  if (moving || s->requests.moving || granular.particles.count != s->requests.particles) s->requests.asked = true;
  s->requests.moving = moving;
  s->requests.particles = granular.particles.count;
  // A skin under way keeps the colliders of its moment: else, beside one that moves, it would begin anew in each frame.
  const bool idle = s->progress.phase == SkinPhase::idle;
  if (!idle) solids_drop_gone_fields(&s->solids, &s->bricks, *s, &s->requests.asked);
  else if (!s->requests.asked)
    solids_take(&s->solids, &s->bricks, *s, granular.time.frame_step > 0 ? 0.0f : colliders_behind(granular),
                &s->requests.asked);
  // A mandatory unit comes before the frame's sub-steps: too early for particles to be taken, unless nothing ran in the
  // last frame either.
  const uint32_t mandatory = takes(*s) && s->requests.ran ? 0 : 1;
  s->requests.ran = false;
  if (!idle) s->progress.in_time = 0;
  return mandatory;
}

}  // namespace

extern const Capability k_skin_capability = {.begin_frame = begin_frame,
                                             .next = next,
                                             .run = run,
                                             .forecast = forecast,
                                             .under_way = under_way,
                                             .closing = skin_carry_stage};

}  // namespace sandglass

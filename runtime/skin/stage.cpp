// The skin's stage of a frame: what asks for a skin, and its phases one after another.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_turned = 0.05f;  // of the unit vector up: so far it turns before sand is filled anew
constexpr uint32_t k_kind_of[] = {k_skin_gather, k_skin_gather, k_skin_gather, k_skin_gather, k_skin_density,
                                  k_skin_fill,   k_skin_calm,   k_skin_mesh,   k_skin_loose};
constexpr const char* k_names[k_skin_kinds] = {"skin.gather", "skin.density", "skin.fill",
                                               "skin.calm",   "skin.mesh",    "skin.loose"};
constexpr uint32_t k_items[k_skin_kinds] = {k_skin_unit_items,
                                            k_skin_unit_bricks,
                                            8 * k_skin_unit_bricks,
                                            k_skin_unit_bricks,
                                            k_skin_unit_mesh,
                                            k_skin_unit_items,
                                            0};

bool takes(const SkinState& s) { return s.phase <= SkinPhase::take; }

uint32_t kind_of(const SkinState& s) { return k_kind_of[static_cast<uint32_t>(s.phase)]; }

uint32_t items_of(const SkinState& s) { return takes(s) ? skin_take_items(s) : k_items[kind_of(s)]; }

// The lattice's axes, right-handed: y is the world's axis nearest to up.
void choose_axes(SkinState* s, const float up[3]) {
  uint32_t most = s->axis[1];
  for (uint32_t k = 0; k < 3; ++k)
    if (__builtin_fabsf(up[k]) > 1.2f * __builtin_fabsf(up[most])) most = k;
  const float sign = up[most] < 0 ? -1.0f : 1.0f;
  if (s->axis[1] == most && s->sign[1] == sign) return;
  const uint32_t x = (most + 2) % 3, z = (most + 1) % 3;  // x, y, z in a cycle, or with two of them turned round
  s->axis[0] = x;
  s->axis[1] = most;
  s->axis[2] = z;
  s->sign[0] = sign;
  s->sign[1] = sign;
  s->sign[2] = 1.0f;
  skin_forget(s);
}

// Up as gravity has it; the world's y where there is none. Held still while it turns little.
void find_up(SkinState* s, const Granular& g) {
  float up[3] = {0, 1, 0}, turned = 0;
  if (g.gravity_length > 0)
    for (uint32_t k = 0; k < 3; ++k) up[k] = -g.gravity[k] / g.gravity_length;
  for (uint32_t a = 0; a < 3; ++a) {
    const float d = s->sign[a] * up[s->axis[a]] - s->up[a];
    turned += d * d;
  }
  const bool falls = g.gravity_length > 0;
  if (turned <= k_turned * k_turned && falls == s->falls) return;
  s->falls = falls;
  choose_axes(s, up);
  for (uint32_t a = 0; a < 3; ++a) s->up[a] = s->sign[a] * up[s->axis[a]];
  for (uint32_t k = 0; k < 2; ++k) {
    const float lean = -s->up[2 * k] / s->up[1];  // aside for one down
    const float bounded = lean > -1.0f ? (lean < 1.0f ? lean : 1.0f) : -1.0f;
    s->lean[k] = floor_whole(bounded * k_skin_one + 0.5f);
  }
  for (uint32_t b = 0; b < s->brick_count; ++b) s->bricks[b].stale |= k_stale_fill;
  s->asked = true;
}

void publish(SkinState* s) {
  SkinMesh &back = s->back, &front = s->front;
  SkinShown& shown = s->shown;
  const size_t loose = (back.flying + back.lying) * sizeof *back.loose;
  bool changed = !s->valid || back.flying != shown.flying || back.lying != shown.lying ||
                 memcmp(back.loose, shown.loose, loose) != 0;
  for (uint32_t c = 0; c < s->chunk_capacity; ++c) {
    sandglass_skin_chunk& chunk = back.chunks[c];
    const bool carried = shown.chunks[c].vertices != front.chunks[c].vertices;
    if (chunk.version == k_chunk_changed || carried) {
      chunk.version = s->version + 1;
      changed = true;
    }
    shown.chunks[c] = chunk;
  }
  memcpy(shown.loose, back.loose, loose);
  shown.flying = back.flying;
  shown.lying = back.lying;
  memcpy(s->met, s->colliders, s->desc.collider_capacity * sizeof *s->met);
  if (changed) ++s->version;
  const SkinMesh swap = front;
  front = back;
  back = swap;
  s->front_version = s->version;
  shown.frame = s->gathered_frame;
  shown.substeps = s->gathered_substeps;
  s->carry.frame = 0;
  shown.lost = false;
  s->in_time = s->begun == s->frame ? s->in_time + 1 : 0;
  s->valid = true;
  s->front_frame = s->begun;
  s->left_out = s->left_out_now;
  memcpy(s->usual, s->spent, sizeof s->usual);
}

void begin(SkinState* s) {
  s->asked = false;
  if (s->whole_asked) skin_forget(s);
  s->whole_asked = false;
  s->begun = s->frame;
  s->left_out_now = 0;
  ++s->cycle;
  s->cursor = s->restarts = 0;
  memset(s->spent, 0, sizeof s->spent);
  for (uint32_t i = 0; i < s->desc.particle_capacity; ++i) s->back.from[3 * i] = k_skin_nowhere;
  s->phase = SkinPhase::take;
}

void run_unit(SkinState* s) {
  if (s->phase == SkinPhase::idle) begin(s);
  // Sand that was taken as the frame began is taken again after its sub-steps.
  const bool early = s->gathered_frame == s->frame && s->gathered_substeps != s->granular->counts.moments();
  if (s->phase == SkinPhase::gather && s->cursor == 0 && early) s->phase = SkinPhase::take;
  s->spent[kind_of(*s)] += items_of(*s);
  s->ran = true;
  switch (s->phase) {
    case SkinPhase::take:
      if (skin_take(s)) s->phase = SkinPhase::gather;
      break;
    case SkinPhase::gather:
      if (skin_gather(s)) s->phase = SkinPhase::leave;
      break;
    case SkinPhase::leave:
      if (skin_leave(s)) s->phase = SkinPhase::density;
      break;
    case SkinPhase::density:
      if (!skin_density(s)) break;
      skin_begin_fill(s);
      s->phase = SkinPhase::fill;
      break;
    case SkinPhase::fill:
      if (skin_fill(s)) s->phase = SkinPhase::calm;
      break;
    case SkinPhase::calm:
      if (!skin_calm(s)) break;
      skin_begin_mesh(s);
      s->phase = SkinPhase::mesh;
      break;
    case SkinPhase::mesh:
      if (!skin_mesh(s)) break;
      skin_begin_loose(s);
      s->phase = SkinPhase::loose;
      break;
    default:
      if (!skin_loose(s)) break;
      publish(s);
      s->phase = SkinPhase::idle;
  }
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  if (!skin_has_work(s)) return false;
  *unit = {kind_of(s), items_of(s), k_names[kind_of(s)]};
  return true;
}

void run(void* state, uint32_t) { run_unit(&static_cast<sandglass_skin*>(state)->skin); }

// What is left of the skin under way, or asked for, if it takes what the last one took. One that takes more than a frame is
// followed by another at once: then quality must not follow what is left of it.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  if (!skin_has_work(s)) return 0;
  uint32_t count = 0;
  for (uint32_t kind = 0; kind < k_skin_carry; ++kind) {
    const uint32_t spent = s.phase == SkinPhase::idle || skin_is_late(s) ? 0 : s.spent[kind];
    const uint32_t left = s.usual[kind] > spent ? s.usual[kind] - spent : 0;
    const uint32_t least = kind == kind_of(s) ? items_of(s) : 0;
    if ((left > least ? left : least) != 0) entries[count++] = {kind, left > least ? left : least, true};
  }
  return count;
}

bool under_way(const void* handle) { return static_cast<const sandglass_skin*>(handle)->skin.phase != SkinPhase::idle; }

uint32_t begin_frame(void* handle, const FrameView& view) {
  SkinState* s = &static_cast<sandglass_skin*>(handle)->skin;
  const Granular& granular = *view.granular;
  ++s->frame;
  s->granular = &granular;
  s->kernels = granular.kernels;
  find_up(s, granular);
  // Also in the frame after the last motion: the skin under way then shows sand that still moved.
  const bool moving = granular.sleep.awake_count != 0;
  if (moving || s->moving || granular.particles.count != s->sand) s->asked = true;
  s->moving = moving;
  s->sand = granular.particles.count;
  // A skin under way keeps the colliders of its moment: else, beside one that moves, it would begin anew in each frame.
  const bool idle = s->phase == SkinPhase::idle;
  if (!idle) skin_drop_gone_fields(s);
  else if (!s->asked) skin_take_colliders(s, granular.time.frame_step > 0 ? 0.0f : colliders_behind(granular));
  // A mandatory unit comes before the frame's sub-steps: too early for particles to be taken, unless nothing ran in the
  // last frame either.
  const uint32_t mandatory = takes(*s) && s->ran ? 0 : 1;
  s->ran = false;
  if (!idle) s->in_time = 0;
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

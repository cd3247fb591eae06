// The scene: one walk over the description lays it out, the governor runs its stages, the report says what happened.
#include "kernels/kernels.h"
#include "platform/floating_point.h"
#include "runtime/core/filled_struct.h"
#include "runtime/core/governor.h"
#include "runtime/core/layout.h"
#include "runtime/granular/granular.h"
#include "runtime/light/light.h"
#include "runtime/shadow/pile.h"
#include "runtime/shadow/shadow.h"
#include "sandglass/sandglass.h"

using sandglass::Governor;
using sandglass::Granular;
using sandglass::Layout;
using sandglass::Stage;

struct sandglass_scene {
  sandglass_scene_desc desc;
  Layout layout;
  Governor governor;
  Granular granular;
  const sandglass::Kernels* kernels;
  uint64_t frame;
};

namespace {

constexpr float k_grain_radii =
    0.35f;  // grain_radius 0: about the size at which 16 grains fill a particle's share of space

// Sub-step of the calibrated scheme in units of sqrt(r/g): 20 ms / 72 for r = 1 cm.
constexpr float k_substep_units = 0.00871f;

struct Failure {
  const char** reason;
  sandglass_status operator()(sandglass_status status, const char* sentence) const {
    if (reason != nullptr) *reason = sentence;
    return status;
  }
};

constexpr char k_no_scene[] = "scene is NULL: pass the scene that sandglass_scene_create made.";

sandglass_status succeed(const char** reason) {
  if (reason != nullptr) *reason = nullptr;
  return SANDGLASS_OK;
}

float length_of(const float* v) { return __builtin_sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

sandglass_status check(const sandglass_scene_desc* desc, const char** reason) {
  const Failure fail = {reason};
  if (desc == nullptr)
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "desc is NULL: pass a description filled by sandglass_scene_desc_default.");
  if (desc->struct_size != sizeof(sandglass_scene_desc)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "desc.struct_size is not this library's: fill the description with sandglass_scene_desc_default.");
  }
  const float g = length_of(desc->gravity);
  if (!(g <= 1000.0f))
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, "desc.gravity must be finite and at most 1000 m/s^2.");
  if (desc->unit_items < 16 || desc->unit_items > 65536 || desc->unit_items % 16 != 0) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, "desc.unit_items must be a multiple of 16 from 16 to 65536.");
  }
  if (desc->isa < SANDGLASS_ISA_AUTOMATIC || desc->isa > SANDGLASS_ISA_NEON_I8MM) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, "desc.isa must be a SANDGLASS_ISA value.");
  }
  if (desc->finest_level >= SANDGLASS_LEVEL_COUNT)
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, "desc.finest_level must be below SANDGLASS_LEVEL_COUNT; 0 is best.");
  const char* granular = sandglass::granular_refuse(desc->granular);
  return granular == nullptr ? SANDGLASS_OK : fail(SANDGLASS_ERROR_INVALID_ARGUMENT, granular);
}

// The one walk: the scene itself, then every stage's regions.
sandglass_scene* lay_out(const sandglass_scene_desc& desc, Layout* layout, Granular* granular) {
  sandglass_scene* scene = sandglass::layout_region<sandglass_scene>(layout, "scene", 1);
  sandglass::granular_layout(granular, desc.granular, layout);
  return scene;
}

// The shadows that a frame was given, as a stage. What is left of their textures may take several frames.
constexpr float k_shadow_share = 0.2f;  // of the optional time, while grains want theirs: as much as is left to them

struct Shadows {
  sandglass::ShadowSet set;
  sandglass_pile_shadow* pile;  // null without
};
constexpr uint32_t k_pile_kinds_from = uint32_t{sandglass::k_granular_kinds} + uint32_t{sandglass::k_shadow_kinds};

// Of objects and the pile: whichever has a texture under way, else in turns.
bool shadow_unit(const Shadows& all, bool* of_pile, sandglass::WorkUnit* unit) {
  const sandglass::ShadowSet& set = all.set;
  const bool of_set = set.count != 0 && set.shadows[0]->set->next(set, unit);
  if (of_set) unit->kind += sandglass::k_granular_kinds;
  *of_pile = false;
  if (all.pile == nullptr) return of_set;
  bool under_way = false;
  for (uint32_t i = 0; i < set.count; ++i)
    under_way = under_way || set.shadows[i]->shadow.phase != sandglass::ShadowPhase::idle;
  sandglass::WorkUnit of;
  *of_pile = all.pile->functions->next(all.pile, of_set, under_way, &of);
  if (!*of_pile) return of_set;
  *unit = of;
  unit->kind += k_pile_kinds_from;
  return true;
}

uint32_t shadow_forecast(const Shadows& all, sandglass::Forecast* entries) {
  uint32_t count = all.set.count == 0 ? 0 : all.set.shadows[0]->set->forecast(all.set, entries);
  for (uint32_t i = 0; i < count; ++i) entries[i].kind += sandglass::k_granular_kinds;
  if (all.pile != nullptr) {
    const uint32_t of_pile = all.pile->functions->forecast(all.pile, entries + count);
    for (uint32_t i = 0; i < of_pile; ++i) entries[count + i].kind += k_pile_kinds_from;
    count += of_pile;
  }
  return count;
}

constexpr uint32_t k_light_kinds_from = k_pile_kinds_from + uint32_t{sandglass::k_pile_kinds};
static_assert(k_light_kinds_from + uint32_t{sandglass::k_light_stage_kinds} <= sandglass::k_unit_kinds);

// The frame's light as a stage. `mandatory`: units that must run, 1 and those of an image that was taken.
constexpr float k_light_share = 0.2f;  // of the optional time, while something else wants its own

Stage light_stage(sandglass_light** light, uint32_t mandatory) {
  return {light,
          [](const void* state, uint32_t, sandglass::WorkUnit* unit) {
            const sandglass_light* owner = *static_cast<sandglass_light* const*>(state);
            if (owner == nullptr || !owner->functions->next(owner, unit)) return false;
            unit->kind += k_light_kinds_from;
            return true;
          },
          [](void* state, uint32_t) {
            sandglass_light* owner = *static_cast<sandglass_light**>(state);
            owner->functions->run(owner);
          },
          [](const void* state, uint32_t, sandglass::Forecast* entries) -> uint32_t {
            const sandglass_light* owner = *static_cast<sandglass_light* const*>(state);
            const uint32_t count = owner == nullptr ? 0 : owner->functions->forecast(owner, entries);
            for (uint32_t i = 0; i < count; ++i) entries[i].kind += k_light_kinds_from;
            return count;
          },
          mandatory,
          k_light_share};
}

Stage shadow_stage(Shadows* shadows) {
  return {shadows,
          [](const void* state, uint32_t, sandglass::WorkUnit* unit) {
            bool of_pile;
            return shadow_unit(*static_cast<const Shadows*>(state), &of_pile, unit);
          },
          [](void* state, uint32_t) {
            const Shadows& all = *static_cast<const Shadows*>(state);
            sandglass::WorkUnit unit;
            bool of_pile;
            if (!shadow_unit(all, &of_pile, &unit)) return;
            if (of_pile) {
              all.pile->functions->run(all.pile);
            } else {
              all.set.shadows[0]->set->run(all.set);
              if (all.pile != nullptr) all.pile->functions->gave_way(all.pile);
            }
          },
          [](const void* state, uint32_t, sandglass::Forecast* entries) -> uint32_t {
            return shadow_forecast(*static_cast<const Shadows*>(state), entries);
          },
          1,
          k_shadow_share};
}

void reset(sandglass_scene* scene) {
  sandglass::governor_init(&scene->governor, scene->desc.clock, scene->desc.trace, SANDGLASS_LEVEL_COUNT);
  scene->governor.finest_level = scene->desc.finest_level;
  sandglass::granular_reset(&scene->granular);
  scene->frame = 0;
}

// The frame proper, out of line: it runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) bool run_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                         sandglass_frame_report* report) {
  Granular* granular = &scene->granular;
  sandglass::granular_begin_frame(granular, input);
  sandglass_light* light = input->light;
  const char* refused = nullptr;
  const uint32_t light_units = light == nullptr ? 1 : light->functions->begin_frame(light, input->camera, &refused);
  Shadows shadows = {{input->shadows, input->shadow_count}, input->pile_shadow};
  if (shadows.pile != nullptr) {
    // Sand is what is drawn: grains where there are any. Particles that stray carry none.
    const bool drawn = granular->grain_count != 0;
    const sandglass::PileSource source = {drawn ? nullptr : &granular->records[0],
                                          drawn ? &granular->grains[0] : nullptr, nullptr,
                                          drawn ? granular->grain_count : granular->particle_count,
                                          drawn ? granular->desc.grain_radius : granular->desc.particle_radius};
    const bool moving = granular->awake_count != 0 || (drawn && granular->grain_group_count != 0);
    shadows.pile->functions->begin_frame(shadows.pile, source, moving);
  }
  const Stage stages[SANDGLASS_STAGE_COUNT] = {
      sandglass::granular_particle_stage(granular), light_stage(&light, light_units), shadow_stage(&shadows),
      sandglass::granular_grain_stage(granular), sandglass::granular_output_stage(granular)};
  const uint64_t target = sandglass::governor_target(input->budget_ns, input->thermal_headroom);
  const bool ran =
      sandglass::governor_frame(&scene->governor, stages, SANDGLASS_STAGE_COUNT, target, input->plan, report);
  report->budget_ns = input->budget_ns;
  if (light != nullptr) light->functions->end_frame(light, report);
  if (refused != nullptr) {
    report->ignored_images = 1;
    if (scene->desc.log.write != nullptr) scene->desc.log.write(scene->desc.log.user, refused);
  }
  return ran;
}

void describe(const sandglass_scene& scene, sandglass_frame_report* report) {
  const Granular& g = scene.granular;
  report->frame = scene.frame;
  report->simulated_time = g.simulated;
  const double debt = g.owed + g.slipped;
  report->time_debt = debt > 1e-9 ? debt : 0.0;
  report->grain_lag = g.grain_count == 0 ? 0.0f : static_cast<float>(g.unswept);
  report->substep = g.substep;
  report->substeps = g.substeps;
  report->list_builds = g.list_builds;
  report->particles = g.particle_count;
  report->awake = g.awake_count;
  report->grains = g.grain_count;
  const uint32_t awake_grains = g.grain_group_count * sandglass::k_lane_group;
  report->awake_grains = awake_grains < g.grain_count ? awake_grains : g.grain_count;
  report->dropped_contacts = g.dropped_contacts;
  report->quarantined = g.quarantined;
  report->ignored_colliders = g.ignored_colliders;
  report->particle_numbers = g.particle_count + g.free_particle_count;
  report->grain_numbers = g.grain_count + g.free_grain_count;
  report->emitted_particles = g.emitted_particles;
  report->emitted_grains = g.emitted_grains;
  report->removed_particles = g.removed_particles;
  report->removed_grains = g.removed_grains;
  report->denied_particles = g.denied_particles;
  report->speed_max = g.speed_max;
}

void say(const sandglass_scene& scene) {
  const sandglass_log& log = scene.desc.log;
  if (log.write == nullptr) return;
  const Granular& g = scene.granular;
  if (g.dropped_contacts != 0)
    log.write(log.user, "granular: more neighbours than a list holds; some contacts were left out in this frame.");
  if (g.quarantined != 0)
    log.write(log.user,
              "granular: a particle or grain left the coordinate range or was not finite; it was put to rest.");
  if (g.ignored_colliders != 0)
    log.write(
        log.user,
        "granular: a collider, emitter or sink was left out: it is not finite, has no size, or is beyond the capacity "
        "for its kind. Check what the frame input holds.");
}

constexpr uint64_t k_fnv_basis = 14695981039346656037ull, k_fnv_prime = 1099511628211ull;

uint64_t fnv(uint64_t hash, const void* bytes, uint64_t count) {
  const uint8_t* p = static_cast<const uint8_t*>(bytes);
  for (uint64_t i = 0; i < count; ++i) hash = (hash ^ p[i]) * k_fnv_prime;
  return hash;
}

// FNV-1a of one item: its kind, number, position and velocity. Items are added up, so storage order does not matter.
uint64_t item_hash(uint32_t kind, uint32_t id, const float* position, const float* velocity) {
  uint64_t hash = fnv(k_fnv_basis, &kind, sizeof kind);
  hash = fnv(hash, &id, sizeof id);
  hash = fnv(hash, position, 3 * sizeof(float));
  return fnv(hash, velocity, 3 * sizeof(float));
}

uint32_t number_in(const sandglass::Particle& particle) { return number_of(particle); }
uint32_t number_in(const sandglass::Grain& grain) { return grain.number; }

// Particles or grains in the order of their numbers; removed ones are told by their place.
template <class Item>
void copy_items(const Item* items, uint32_t count, const uint32_t* removed, uint32_t removed_count, float* positions,
                float* velocities) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t to = 3ull * number_in(items[i]);
    for (int k = 0; k < 3; ++k) {
      if (positions != nullptr) positions[to + k] = items[i].position[k];
      if (velocities != nullptr) velocities[to + k] = items[i].velocity[k];
    }
  }
  for (uint32_t i = 0; i < removed_count; ++i) {
    const uint64_t to = 3ull * removed[i];
    for (int k = 0; k < 3; ++k) {
      if (positions != nullptr) positions[to + k] = k == 1 ? SANDGLASS_REMOVED_Y : 0.0f;
      if (velocities != nullptr) velocities[to + k] = 0.0f;
    }
  }
}

}  // namespace

void sandglass_scene_desc_default(sandglass_scene_desc* desc) {
  if (desc == nullptr) return;
  *desc = sandglass_scene_desc{};
  desc->struct_size = sizeof *desc;
  desc->unit_items = 1024;
  desc->gravity[1] = -9.81f;
  sandglass_granular_desc& g = desc->granular;
  g.collider_capacity = 16;
  g.particle_radius = 0.01f;
  g.static_friction = 0.14f;
  g.kinetic_friction = 0.14f;
  g.height_weighting = 0.3f;
  g.courant = 0.5f;
  g.list_skin = 0.6f;
  g.sleep_after = 0.5f;
  g.refine_step = 0.008f;
  g.reference.scheme = SANDGLASS_SCHEME_SMALL_STEP;
  g.reference.blend = SANDGLASS_BLEND_CONTINUOUS;
  g.reference.solver_iterations = 1;
  g.reference.relaxation = 0.45f;
}

void sandglass_frame_input_default(sandglass_frame_input* input) {
  if (input == nullptr) return;
  *input = sandglass_frame_input{};
  input->struct_size = sizeof *input;
  input->thermal_headroom = 1.0f;
  input->grain_stride = sizeof(sandglass_grain);
}

sandglass_status sandglass_scene_bytes(const sandglass_scene_desc* desc, uint64_t* bytes, const char** reason) {
  const sandglass_status status = check(desc, reason);
  if (status != SANDGLASS_OK) return status;
  if (bytes == nullptr)
    return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, "bytes is NULL: pass where to store the size.");
  Layout layout;
  Granular granular = {};
  lay_out(*desc, &layout, &granular);
  *bytes = layout.size;
  return succeed(reason);
}

sandglass_status sandglass_scene_create(const sandglass_scene_desc* desc, void* block, uint64_t bytes,
                                        sandglass_scene** scene, const char** reason) {
  const Failure fail = {reason};
  uint64_t need = 0;
  const sandglass_status status = sandglass_scene_bytes(desc, &need, reason);
  if (status != SANDGLASS_OK) return status;
  if (scene == nullptr || block == nullptr)
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "block or scene is NULL: pass the memory and where to store the scene.");
  const sandglass::Kernels* kernels = sandglass::select_kernels(desc->isa);
  if (kernels == nullptr)
    return fail(SANDGLASS_ERROR_UNSUPPORTED,
                "desc.isa is not available on this CPU or in this build: use SANDGLASS_ISA_AUTOMATIC.");
  if (reinterpret_cast<uintptr_t>(block) % SANDGLASS_BLOCK_ALIGNMENT != 0) {
    return fail(SANDGLASS_ERROR_MEMORY_ALIGNMENT,
                "block is not aligned to SANDGLASS_BLOCK_ALIGNMENT (64 bytes): allocate it aligned.");
  }
  if (bytes < need)
    return fail(SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                "block is smaller than sandglass_scene_bytes says this description needs.");

  __builtin_memset(block, 0, need);
  Layout layout;
  layout.base = static_cast<uint8_t*>(block);
  Granular granular = {};
  sandglass_scene* s = lay_out(*desc, &layout, &granular);
  s->desc = *desc;
  s->layout = layout;
  s->kernels = kernels;
  s->granular = granular;
  Granular& g = s->granular;
  g.kernels = kernels;
  g.parallel = desc->parallel;
  g.unit = desc->unit_items;
  for (int k = 0; k < 3; ++k) g.gravity[k] = desc->gravity[k];
  g.gravity_length = length_of(desc->gravity);
  sandglass_granular_desc& d = g.desc;
  const float pull = g.gravity_length > 0.1f ? g.gravity_length : 9.81f;  // weightless scenes keep the Earth's step
  g.substep_max = d.substep_max > 0.0f ? d.substep_max : k_substep_units * __builtin_sqrtf(d.particle_radius / pull);
  g.substep_min = d.substep_min > 0.0f ? d.substep_min : 0.25f * g.substep_max;
  if (d.grain_radius <= 0.0f) d.grain_radius = k_grain_radii * d.particle_radius;
  reset(s);
  *scene = s;
  return succeed(reason);
}

void sandglass_scene_reset(sandglass_scene* scene) {
  if (scene != nullptr) reset(scene);
}

sandglass_status sandglass_scene_move(sandglass_scene* scene, const float rotation[4], const float translation[3],
                                      const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  const sandglass::FloatingPointControl saved = sandglass::floating_point_enter();
  const sandglass_status status = sandglass::granular_move(&scene->granular, rotation, translation, reason);
  sandglass::floating_point_restore(saved);
  return status;
}

uint64_t sandglass_scene_save_bytes(const sandglass_scene* scene) {
  return scene == nullptr ? 0 : sandglass::granular_save_bytes(scene->granular);
}

sandglass_status sandglass_scene_save(sandglass_scene* scene, void* data, uint64_t bytes, uint64_t* written,
                                      const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  const sandglass::FloatingPointControl saved = sandglass::floating_point_enter();
  const sandglass_status status = sandglass::granular_save(&scene->granular, data, bytes, written, reason);
  sandglass::floating_point_restore(saved);
  return status;
}

sandglass_status sandglass_scene_restore(sandglass_scene* scene, const void* data, uint64_t bytes,
                                         const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  return sandglass::granular_restore(&scene->granular, data, bytes, reason);
}

uint32_t sandglass_scene_regions(const sandglass_scene* scene, sandglass_region* regions, uint32_t capacity) {
  if (scene == nullptr) return 0;
  const Layout& layout = scene->layout;
  for (uint32_t i = 0; regions != nullptr && i < layout.region_count && i < capacity; ++i)
    regions[i] = layout.regions[i];
  return layout.region_count;
}

sandglass_isa sandglass_scene_isa(const sandglass_scene* scene) {
  return scene == nullptr ? SANDGLASS_ISA_AUTOMATIC : scene->kernels->isa;
}

sandglass_status sandglass_granular_add(sandglass_scene* scene, const float* particle_positions,
                                        const float* particle_velocities, uint32_t particle_count,
                                        const float* grain_positions, const float* grain_velocities,
                                        uint32_t grain_count, const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  return sandglass::granular_add(&scene->granular, particle_positions, particle_velocities, particle_count,
                                 grain_positions, grain_velocities, grain_count, reason);
}

sandglass_status sandglass_granular_remove(sandglass_scene* scene, const sandglass_collider* region,
                                           uint32_t* particles, uint32_t* grains, const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  return sandglass::granular_remove(&scene->granular, region, particles, grains, reason);
}

void sandglass_body_default(sandglass_body* body) {
  if (body == nullptr) return;
  *body = sandglass_body{};
  body->struct_size = sizeof *body;
  body->density_ratio = 1.0f;
}

sandglass_status sandglass_granular_add_body(sandglass_scene* scene, const sandglass_body* body, uint32_t* index,
                                             const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  return sandglass::granular_add_body(&scene->granular, body, index, reason);
}

sandglass_body_pose sandglass_granular_body_pose(const sandglass_scene* scene, uint32_t index) {
  sandglass_body_pose pose = {};
  pose.rotation[3] = 1.0f;
  if (scene != nullptr && index < scene->granular.body_count)
    sandglass::granular_body_pose(scene->granular, index, &pose);
  return pose;
}

sandglass_status sandglass_granular_set_boundary(sandglass_scene* scene, const float* positions, uint32_t count,
                                                 const char** reason) {
  if (scene == nullptr) return Failure{reason}(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  return sandglass::granular_set_boundary(&scene->granular, positions, count, reason);
}

sandglass_status sandglass_granular_set_friction(sandglass_scene* scene, float static_friction, float kinetic_friction,
                                                 const char** reason) {
  const Failure fail = {reason};
  if (scene == nullptr) return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  if (!(static_friction >= 0.0f && static_friction <= 10.0f && kinetic_friction >= 0.0f && kinetic_friction <= 10.0f)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "sandglass_granular_set_friction: both coefficients must be 0 to 10.");
  }
  scene->granular.desc.static_friction = static_friction;
  scene->granular.desc.kinetic_friction = kinetic_friction;
  sandglass::granular_wake_all(&scene->granular);
  return succeed(reason);
}

sandglass_status sandglass_scene_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                       sandglass_frame_report* report, const char** reason) {
  const Failure fail = {reason};
  if (scene == nullptr) return fail(SANDGLASS_ERROR_INVALID_ARGUMENT, k_no_scene);
  if (input == nullptr) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "input is NULL: pass a frame input filled by sandglass_frame_input_default.");
  }
  if (input->struct_size != sizeof *input) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "input.struct_size is not this library's: fill the input with sandglass_frame_input_default.");
  }
  if (input->grains != nullptr && (input->grain_stride < sizeof(sandglass_grain) || input->grain_stride % 4 != 0)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "input.grain_stride must be a multiple of 4 and at least sizeof(sandglass_grain).");
  }
  for (uint32_t i = 0; i < input->shadow_count; ++i)
    if (input->shadows == nullptr || input->shadows[i] == nullptr)
      return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                  "input.shadows is NULL or has a NULL among its first shadow_count: pass the shadows, or set "
                  "shadow_count to 0.");
  if (input->plan != nullptr &&
      (input->plan->struct_size != sizeof(sandglass_plan) || input->plan->run_count > SANDGLASS_PLAN_RUNS ||
       input->plan->level >= static_cast<uint32_t>(SANDGLASS_LEVEL_COUNT))) {
    return fail(SANDGLASS_ERROR_REPLAY, "input.plan is not a plan of this library: pass the plan of a frame report.");
  }
  if (report != nullptr && !sandglass::can_fill(report)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "report.struct_size is not set: set it to sizeof(sandglass_frame_report).");
  }
  sandglass_frame_report done = {};
  ++scene->frame;
  const sandglass::FloatingPointControl saved = sandglass::floating_point_enter();
  const bool ran = run_frame(scene, input, &done);
  sandglass::floating_point_restore(saved);
  describe(*scene, &done);
  if (input->shadow_count != 0)
    input->shadows[0]->set->describe({input->shadows, input->shadow_count}, &done.pending_shadows, &done.shadow_age);
  if (report != nullptr) sandglass::fill_struct(&done, sizeof done, report);
  say(*scene);
  return ran ? succeed(reason)
             : fail(SANDGLASS_ERROR_REPLAY,
                    "input.plan does not fit this scene's state: replay from the state it was recorded in.");
}

void sandglass_granular_particles(const sandglass_scene* scene, float* positions, float* velocities) {
  if (scene == nullptr) return;
  const Granular& g = scene->granular;
  copy_items(g.records[0], g.particle_count, g.free_particles, g.free_particle_count, positions, velocities);
}

void sandglass_granular_grains(const sandglass_scene* scene, float* positions, float* velocities) {
  if (scene == nullptr) return;
  const Granular& g = scene->granular;
  copy_items(g.grains[0], g.grain_count, g.free_grains, g.free_grain_count, positions, velocities);
}

uint64_t sandglass_scene_hash(const sandglass_scene* scene) {
  if (scene == nullptr) return 0;
  const Granular& g = scene->granular;
  uint64_t hash = 0;
  for (uint32_t i = 0; i < g.particle_count; ++i) {
    const sandglass::Particle& p = g.records[0][i];
    hash += item_hash(0, p.identity, p.position, p.velocity);
  }
  for (uint32_t i = 0; i < g.grain_count; ++i) {
    const sandglass::Grain& grain = g.grains[0][i];
    hash += item_hash(1, grain.number, grain.position, grain.velocity);
  }
  return hash;
}

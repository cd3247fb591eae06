// One frame, top to bottom: check the input, let every capability look at it, collect their stages, let the governor run them,
// report. capabilities.inc says who takes part.
#include "platform/floating_point.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/scene/scene.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr sandglass_stage k_first_group = SANDGLASS_STAGE_GRANULAR + 1;
constexpr sandglass_stage k_group_stages[] = {
#define STAGE(name, title, share, units) SANDGLASS_STAGE_##name,
#include "runtime/frame/capabilities.inc"
};
constexpr uint32_t k_groups = sizeof k_group_stages / sizeof *k_group_stages;
constexpr bool stages_follow_one_another() {
  constexpr sandglass_stage k_member_stages[] = {
#define ONE(stage, ...) SANDGLASS_STAGE_##stage,
#define MANY(stage, ...) SANDGLASS_STAGE_##stage,
#include "runtime/frame/capabilities.inc"
  };
  for (uint32_t i = 0; i < k_groups; ++i) {
    uint32_t members = 0;
    for (const sandglass_stage stage : k_member_stages) members += stage == k_group_stages[i] ? 1 : 0;
    if (k_group_stages[i] != k_first_group + static_cast<sandglass_stage>(i) || members > k_group_capacity)
      return false;
  }
  return SANDGLASS_STAGE_REFINE == k_groups + 1 && SANDGLASS_STAGE_OUTPUT == k_groups + 2;
}
static_assert(stages_follow_one_another());

template <class Handle>
bool all_there(Handle* const* handles, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    if (handles == nullptr || handles[i] == nullptr) return false;
  return true;
}

// What is wrong with the arrays of handles, or null.
const char* check_handles(const sandglass_frame_input& input) {
#define MANY(stage, field, number, ...)                                      \
  if (!all_there(input.field, input.number))                                 \
    return "input." #field " is NULL or has a NULL among its first " #number \
           ": pass what was created, or set " #number " to 0.";
#include "runtime/frame/capabilities.inc"
  return nullptr;
}

void find_groups(const sandglass_frame_input& input, Group groups[k_groups]) {
#define STAGE(name, title, share, units) clear_group(&groups[SANDGLASS_STAGE_##name - k_first_group], share, units);
#define ONE(stage, field, kinds) \
  add_members(&groups[SANDGLASS_STAGE_##stage - k_first_group], member_of(input.field, kinds));
#define MANY(stage, field, number, handle, kinds) \
  add_members(&groups[SANDGLASS_STAGE_##stage - k_first_group], {input.field, input.number, kinds});
#include "runtime/frame/capabilities.inc"
}

sandglass_status check(const sandglass_scene* scene, const sandglass_frame_input* input,
                       const sandglass_frame_report* report, const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  if (input == nullptr) {
    return refuse(reason, "input is NULL: pass a frame input filled by sandglass_frame_input_default.");
  }
  if (input->struct_size != sizeof *input) {
    return refuse(reason,
                  "input.struct_size is not this library's: fill the input with sandglass_frame_input_default.");
  }
  if (input->grains != nullptr && (input->grain_stride < sizeof(sandglass_grain) || input->grain_stride % 4 != 0)) {
    return refuse(reason, "input.grain_stride must be a multiple of 4 and at least sizeof(sandglass_grain).");
  }
  if (input->collider_count != 0 && input->colliders == nullptr)
    return refuse(reason, "input.colliders is NULL but collider_count is above 0: pass the colliders, or set it to 0.");
  if (input->emitter_count != 0 && input->emitters == nullptr)
    return refuse(reason, "input.emitters is NULL but emitter_count is above 0: pass the emitters, or set it to 0.");
  if (input->sink_count != 0 && input->sinks == nullptr)
    return refuse(reason, "input.sinks is NULL but sink_count is above 0: pass the sinks, or set it to 0.");
  if (const char* wrong = check_handles(*input)) return refuse(reason, wrong);
  if (input->plan != nullptr &&
      (input->plan->struct_size != sizeof(sandglass_plan) || input->plan->run_count > SANDGLASS_PLAN_RUNS ||
       input->plan->level >= static_cast<uint32_t>(SANDGLASS_LEVEL_COUNT))) {
    return refuse(reason, SANDGLASS_ERROR_REPLAY,
                  "input.plan is not a plan of this library: pass the plan of a frame report.");
  }
  if (report != nullptr && !can_fill(report)) {
    return refuse(reason, "report.struct_size is not set: set it to sizeof(sandglass_frame_report).");
  }
  return accept(reason);
}

// The sand as the app draws it: by its skin, as soon as there is one; its grains; or the particles of a scene without
// grains. Particles that stray carry no grains.
DrawnSand sand_as_drawn(const Granular& g, const sandglass_skin* skin) {
  if (skin != nullptr && skin->skin.valid) {
    const SkinState& s = skin->skin;
    return {nullptr, nullptr, nullptr, skin_items(s), s.desc.particle_radius, &s, s.front_version, false};
  }
  if (g.grains.count == 0) {
    const bool moving = g.sleep.awake_count != 0;
    return {&g.particles.records[0], nullptr, nullptr, g.particles.count, g.desc.particle_radius, nullptr, 0, moving};
  }
  const bool moving = output_is_moving(g.output);
  return {nullptr, &g.grains.records, nullptr, g.grains.count, g.desc.grain_radius, nullptr, 0, moving};
}

const Stage* closing_part(const void* state, uint32_t level, WorkUnit* unit) {
  for (const Stage& part : static_cast<const Closing*>(state)->parts)
    if (stage_next(part, level, unit)) return &part;
  return nullptr;
}

Stage closing_stage(Closing* closing) {
  const auto next = [](const void* state, uint32_t level, WorkUnit* unit) {
    return closing_part(state, level, unit) != nullptr;
  };
  const auto run = [](void* state, uint32_t level) {
    WorkUnit unit;
    const Stage* part = closing_part(state, level, &unit);
    if (part != nullptr) part->run(part->state, level);
  };
  const auto forecast = [](const void* state, uint32_t level, Forecast* entries) {
    uint32_t count = 0;
    for (const Stage& part : static_cast<const Closing*>(state)->parts)
      count += stage_forecast(part, level, entries + count);
    return count;
  };
  const auto close = [](void* state) {
    for (const Stage& part : static_cast<Closing*>(state)->parts)
      if (part.close != nullptr) part.close(part.state);
  };
  return {closing, next, run, forecast, 0, k_all_units, 1.0f, 0, close};
}

// Out of line: it runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) bool run_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                         sandglass_frame_report* report) {
  Granular* granular = &scene->granular;
  granular_begin_frame(granular, input);
  const char* refused_image = nullptr;
  Group groups[k_groups];
  find_groups(*input, groups);
  FrameView view = {input, granular, {}, &refused_image};
  Closing& closing = scene->closing;
  closing = {{granular_carry_stage(granular), stage_without_work(0), granular_output_stage(granular)}};
  if (input->skin != nullptr) closing.parts[1] = input->skin->member.capability->closing(input->skin);
  Stage stages[SANDGLASS_STAGE_COUNT];
  stages[SANDGLASS_STAGE_GRANULAR] = granular_particle_stage(granular);
  for (uint32_t i = 0; i < k_groups; ++i) {
    if (groups[i].handles != 0) view.drawn = sand_as_drawn(*granular, input->skin);
    stages[k_group_stages[i]] = begin_group(&groups[i], view);
  }
  stages[SANDGLASS_STAGE_REFINE] = granular_grain_stage(granular);
  stages[SANDGLASS_STAGE_OUTPUT] = closing_stage(&closing);
  assign_kinds(stages, SANDGLASS_STAGE_COUNT);
  closing.parts[1].first_kind = stages[SANDGLASS_STAGE_SKIN].first_kind;
  closing.parts[0].first_kind = closing.parts[2].first_kind = stages[SANDGLASS_STAGE_GRANULAR].first_kind;
  stages[SANDGLASS_STAGE_OUTPUT].first_kind = 0;

  const uint64_t target = governor_target(input->budget_ns, input->thermal_headroom);
  const bool ran = governor_frame(&scene->governor, stages, SANDGLASS_STAGE_COUNT, target, input->plan, report);
  report->time.budget_ns = input->budget_ns;
  granular_end_frame(granular);
  for (const Group& group : groups)
    if (group.handles != 0) end_group(group, report);
  if (refused_image != nullptr) {
    report->estimator.ignored_images = 1;
    if (scene->desc.log.write != nullptr) scene->desc.log.write(scene->desc.log.user, refused_image);
  }
  return ran;
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_scene_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                       sandglass_frame_report* report, const char** reason) {
  if (const sandglass_status status = check(scene, input, report, reason)) return status;
  sandglass_frame_report done;  // the governor clears it
  ++scene->frame;
  const FloatingPointControl saved = floating_point_enter();
  const bool ran = run_frame(scene, input, &done);
  floating_point_restore(saved);
  follow_bodies(scene);
  report_scene(*scene, &done);
  if (report != nullptr) fill_struct(&done, sizeof done, report);
  log_frame(*scene);
  return ran ? accept(reason)
             : refuse(reason, SANDGLASS_ERROR_REPLAY,
                      "input.plan asks for a work unit that this state does not offer: replay from the state it was "
                      "recorded in, that of the shadows, the estimator and the room in the input included.");
}

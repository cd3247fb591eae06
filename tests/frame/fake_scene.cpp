// See fake_scene.h.
#include "fake_scene.h"

#include "runtime/math/hash.h"

namespace sandglass::governor_test {
namespace {

// The work units of a cycle: predict, neighbours, six solves, finish.
constexpr Kind k_cycle[] = {k_predict, k_neighbours, k_solve, k_solve, k_solve, k_solve, k_solve, k_solve, k_finish};
constexpr uint32_t k_cycle_units = sizeof(k_cycle) / sizeof(k_cycle[0]);

void run_kind(FakeScene* scene, uint32_t stage, Kind kind) {
  const uint64_t undisturbed = k_cost_ns[kind] * scene->scale_percent / 100;
  const uint64_t cost = scene->cost == nullptr ? undisturbed : scene->cost(scene, kind, undisturbed);
  scene->true_ns += cost;
  ++scene->stage_units[stage];
  scene->last_cost[stage] = cost;
  if (stage == k_closing) {
    scene->closing_ns += cost;
    scene->output_disturbed |= cost > undisturbed;
  }
  scene->order_hash = hash_with(scene->order_hash, kind);
}

FakeScene* scene_of(void* state) { return static_cast<FakeScene*>(state); }
const FakeScene* scene_of(const void* state) { return static_cast<const FakeScene*>(state); }

bool granular_next(const void* state, uint32_t, WorkUnit* unit) {
  const Kind kind = k_cycle[scene_of(state)->cycle];
  *unit = {kind, k_items[kind], "fake.granular"};
  return true;
}

void granular_run(void* state, uint32_t) {
  FakeScene* scene = scene_of(state);
  run_kind(scene, k_granular, k_cycle[scene->cycle]);
  scene->cycle = (scene->cycle + 1) % k_cycle_units;
  scene->cycles_this_frame += scene->cycle == 0;
}

// Eight cycles a frame at the best quality level, four and two at the others.
uint32_t granular_forecast(const void*, uint32_t level, Forecast* entries) {
  for (uint32_t kind = k_predict; kind <= k_finish; ++kind) {
    entries[kind] = {kind, static_cast<uint64_t>(k_items[kind]) * (kind == k_solve ? 6 : 1) * (8u >> level)};
  }
  return k_finish + 1;
}

bool refine_next(const void* state, uint32_t, WorkUnit* unit) {
  *unit = {k_refine, k_items[k_refine], "fake.refine"};
  return scene_of(state)->cycles_this_frame > 0;
}

void refine_run(void* state, uint32_t) { run_kind(scene_of(state), k_refinement, k_refine); }

uint32_t refine_forecast(const void*, uint32_t level, Forecast* entries) {
  entries[0] = {k_refine, static_cast<uint64_t>(k_items[k_refine]) * (16u >> level)};
  return 1;
}

bool output_next(const void* state, uint32_t, WorkUnit* unit) {
  *unit = {k_output, k_items[k_output], "fake.output"};
  return scene_of(state)->outputs_this_frame < k_output_units;
}

void output_run(void* state, uint32_t) {
  FakeScene* scene = scene_of(state);
  run_kind(scene, k_closing, k_output);
  ++scene->outputs_this_frame;
}

uint32_t output_forecast(const void* state, uint32_t, Forecast* entries) {
  entries[0] = {k_output,
                static_cast<uint64_t>(k_items[k_output]) * (k_output_units - scene_of(state)->outputs_this_frame)};
  return 1;
}

uint64_t read_fake_clock(void* user) {
  FakeScene* scene = static_cast<FakeScene*>(user);
  ++scene->readings;
  return scene->show == nullptr ? scene->true_ns : scene->show(scene);
}

}  // namespace

void fake_begin_frame(FakeScene* scene) {
  scene->frame_start_ns = scene->true_ns;
  for (uint64_t& units : scene->stage_units) units = 0;
  for (uint64_t& cost : scene->last_cost) cost = 0;
  scene->closing_ns = 0;
  scene->disturbed = scene->unforeseeable = scene->output_disturbed = false;
  scene->cycles_this_frame = 0;
  scene->outputs_this_frame = 0;
}

FakeRun::FakeRun(bool with_clock)
    : stages{{&scene, granular_next, granular_run, granular_forecast, k_kind_count, 4, 0.6f},
             {&scene, refine_next, refine_run, refine_forecast, k_kind_count, 0, 1.0f},
             {&scene, output_next, output_run, output_forecast, k_kind_count, k_all_units, 1.0f}} {
  governor_init(&governor, with_clock ? sandglass_clock{read_fake_clock, &scene} : sandglass_clock{}, {}, 3);
}

bool FakeRun::frame(uint64_t budget_ns, const sandglass_plan* plan) {
  fake_begin_frame(&scene);
  return governor_frame(&governor, stages, 3, budget_ns, plan, &report);
}

}  // namespace sandglass::governor_test

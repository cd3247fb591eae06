/* Sandglass frame: what one frame is given, what it does within its budget, and what it reports.
 *
 * Units, errors and the rule for NULL: see types.h. */
#ifndef SANDGLASS_FRAME_H
#define SANDGLASS_FRAME_H

#include "sandglass/sand.h"
#include "sandglass/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The camera's image (camera.h), and a depth image (relief.h). */
struct sandglass_camera_image;
struct sandglass_depth_image;

/* ------------------------------------------------------------------------------------------------ quality */

/* The quality ladder. When the work of a frame does not fit its budget, the frame runs at the first quality level that
 * does. A level includes what the levels before it gave up. */
enum {
  /* Everything. */
  SANDGLASS_LEVEL_FULL = 0,
  /* Neighbour lists are rebuilt after three times the motion that could outdate them. */
  SANDGLASS_LEVEL_KEEP_LISTS = 1,
  /* Sub-steps are 4/3 as long. AVERAGED with several iterations: 3/4 of them. */
  SANDGLASS_LEVEL_COARSE = 2,
  /* Sub-steps are twice as long. AVERAGED with several iterations: half of them. Grains are pushed to an even density
   * in one sweep of four instead of two. */
  SANDGLASS_LEVEL_COARSER = 3,
  /* As much simulated time as fits. The rest is the time debt: report.time.debt. */
  SANDGLASS_LEVEL_SLOW_MOTION = 4,
  SANDGLASS_LEVEL_COUNT = 5
};

/* What a quality level costs and what its error is. The numbers come from `sandglass_lab bench ladder`: a collapsing column
 * of 14,280 particles and 228,480 grains over two seconds. Costs are relative to the full quality in the same run. */
typedef struct sandglass_level {
  uint32_t struct_size;
  /* "full", for example. */
  const char* name;
  /* Of the particles, relative to level 0. */
  float cost_solver;
  /* Of the grains, relative to level 0. */
  float cost_refine;
  /* The overlap of touching pairs, (2r - distance) / r: its 99th percentile over the pairs, mean over the frames. */
  float overlap_p99;
  /* The same overlap: its mean over the pairs, mean over the frames. */
  float overlap_mean;
  /* The slope of the pile at the end, degrees. */
  float angle_deg;
} sandglass_level;

/* What a quality level costs, and its error. NULL beyond the last level. Slow motion has the errors of the level before
 * it. */
SANDGLASS_API const sandglass_level* sandglass_level_describe(uint32_t level);

/* The name of a quality level. NULL beyond the last level. */
SANDGLASS_API const char* sandglass_level_name(uint32_t level);

/* ------------------------------------------------------------------------------------------------ stages and plans */

/* Stages, in the order in which a frame runs them. */
typedef int32_t sandglass_stage;
enum {
  SANDGLASS_STAGE_GRANULAR = 0,
  SANDGLASS_STAGE_LIGHT = 1,
  SANDGLASS_STAGE_SKIN = 2,
  SANDGLASS_STAGE_SHADOW = 3,
  SANDGLASS_STAGE_RELIEF = 4,
  SANDGLASS_STAGE_REFINE = 5,
  SANDGLASS_STAGE_OUTPUT = 6,
  SANDGLASS_STAGE_COUNT = 7
};

/* What reports, traces and recordings call a stage, such as "granular". NULL where there is no such stage. */
SANDGLASS_API const char* sandglass_stage_name(uint32_t stage);

/* The most runs that a plan has. */
enum { SANDGLASS_PLAN_RUNS = 48 };

/* Consecutive work units of one stage. */
typedef struct sandglass_plan_run {
  /* A sandglass_stage. */
  uint32_t stage;
  /* How many. */
  uint32_t units;
} sandglass_plan_run;

/* The executed plan: what a frame did, in order. Given back to sandglass_scene_frame with the same input on the same
 * state, it reproduces the frame to the bit, on any instruction set and with any pool. The state includes that of the
 * shadows and the light in the input, whose work units are part of the plan. All of it then counts as mandatory. */
typedef struct sandglass_plan {
  uint32_t struct_size;
  /* The quality level. */
  uint32_t level;
  /* In the order in which they ran. */
  sandglass_plan_run runs[SANDGLASS_PLAN_RUNS];
  /* How many of `runs` are used. */
  uint32_t run_count;
} sandglass_plan;

/* ------------------------------------------------------------------------------------------------ a frame */

/* What one frame is given. */
typedef struct sandglass_frame_input {
  uint32_t struct_size;
  /* Seconds of simulated time to advance; at most 0.1 is taken. Where it is not finite or not above 0, the frame is a
   * pause: no particle, grain or body moves, nothing is poured or drained, nothing wakes or falls asleep, however much
   * time is owed. Time debt and grain_lag stay, and frames after the pause make them up. Colliders may be moved
   * meanwhile: that counts when time goes on. Grains are written, lights and shadows go on. Calls between frames work
   * as ever; a save still finishes the step of the grains. */
  float time_step;
  /* Nanoseconds that the frame may take by the scene's clock. 0 runs the mandatory part only. */
  uint64_t budget_ns;
  /* The share of the budget, 0..1, that the device can sustain without getting too hot: the frame is planned for
   * budget_ns times it. Default: 1, which anything above 1 or not a number counts as too; below 0 counts as 0. It is
   * not the number that Android calls headroom, in which 1 is hot. */
  float thermal_headroom;
  /* Colliders that are not usable or beyond collider_capacity are left out, and reported. */
  const sandglass_collider* colliders;
  /* How many colliders there are. */
  uint32_t collider_count;
  /* Emitters that are not usable or beyond emitter_capacity are left out, and reported. */
  const sandglass_emitter* emitters;
  /* How many emitters there are. */
  uint32_t emitter_count;
  /* Shapes that remove the sand whose centres come inside, and the rigid bodies all of whose particles' centres do. A
   * body goes as by sandglass_scene_remove_body: ask sandglass_scene_has_body where report.sand.removed_bodies
   * has changed. They are checked every 20 ms of simulated time; velocities mean nothing. Sand and bodies that are
   * asleep stay until they wake. Sinks that are not usable or beyond sink_capacity are left out, and reported. */
  const sandglass_collider* sinks;
  /* How many sinks there are. */
  uint32_t sink_count;
  /* Seconds, 0..0.1: grains are written where they were so long before the time of the state, for displays faster than
   * the simulation. 0: the newest. */
  float output_lag;
  /* Receives one sandglass_grain for each number that a grain has or had: report.sand.grain_numbers of them, but no
   * more than grain_capacity. Draw those whose speed is not below 0. NULL: none wanted. */
  sandglass_grain* grains;
  /* Bytes from one item to the next: a multiple of 4, at least sizeof(sandglass_grain), which is the default. */
  uint32_t grain_stride;
  /* How many items fit. */
  uint32_t grain_capacity;
  /* Frames since the library wrote this very buffer, with the same stride, capacity and output_lag: 1 where it is always
   * the same one, 3 where three take turns. Only what has changed since is written. 0 (the default): unknown, and all
   * is written; say so too after a lost graphics context. */
  uint32_t grains_age;
  /* NULL, or the skin of the sand to bring up to date (skin.h). One work unit runs in every second frame whatever the
   * budget, more as it admits. */
  struct sandglass_skin* skin;
  /* The shadows to bring up to date (shadow.h). One work unit a frame runs whatever the budget, more as it admits. Pass
   * all objects whose shadows are seen. None may be NULL. */
  struct sandglass_shadow* const* shadows;
  /* How many shadows there are. */
  uint32_t shadow_count;
  /* NULL, or the shadow of the sand (pile_shadow.h): of its grains where it has any, else of its particles. It and the
   * shadows of objects are brought up to date in turns. */
  struct sandglass_pile_shadow* pile_shadow;
  /* The casts to bring up to date (cast.h), in turns with the two above. None may be NULL. */
  struct sandglass_cast* const* casts;
  /* How many casts there are. */
  uint32_t cast_count;
  /* NULL, or the estimator to bring up to date (estimator.h). One work unit a frame runs whatever the budget, more as it
   * admits. An image that is taken is resampled in the frame that takes it, whatever the budget. */
  struct sandglass_estimator* estimator;
  /* NULL, or the room that the camera's images are gathered in (room.h). It takes an image when its own interval has
   * passed; the image is then read in this frame, whatever the budget. */
  struct sandglass_room* room;
  /* NULL, or the newest image. The estimator passes it over while an estimate is under way, and until its interval has
   * passed. It is read in this call only. */
  const struct sandglass_camera_image* camera;
  /* NULL, or the relief that depth images are gathered in (relief.h). An image that is taken is read in this frame,
   * whatever the budget; of what follows one work unit a frame runs, more as it admits. */
  struct sandglass_relief* relief;
  /* NULL, or the newest depth image. The relief passes it over while one before is under way. It is read in this call
   * only. */
  const struct sandglass_depth_image* depth;
  /* NULL, or a recorded plan to execute: the clock then decides nothing. */
  const sandglass_plan* plan;
} sandglass_frame_input;

/* Fills *input with the defaults: nothing but thermal_headroom 1 and grain_stride sizeof(sandglass_grain). */
SANDGLASS_API void sandglass_frame_input_default(sandglass_frame_input* input);

/* What one stage did in a frame. */
typedef struct sandglass_stage_report {
  /* Work units that were executed. */
  uint32_t units;
  /* 1: the stage had work left that the budget did not admit. */
  uint32_t denied;
  /* By the scene's clock; 0 without one. */
  uint64_t elapsed_ns;
} sandglass_stage_report;

/* The time of a frame: what it took by the scene's clock, and how far simulated time has come. */
typedef struct sandglass_time_report {
  /* The budget that the frame was given. */
  uint64_t budget_ns;
  /* budget_ns times thermal_headroom: the target duration of a performance hint session. */
  uint64_t target_ns;
  /* The actual duration of that session. */
  uint64_t elapsed_ns;
  /* The part of elapsed_ns that is done whatever the budget. */
  uint64_t mandatory_ns;
  /* The last work unit, plus what output took beyond its own prediction; see sandglass_scene_frame. */
  uint64_t last_unit_ns;
  /* The longest work unit of the frame. */
  uint64_t longest_unit_ns;
  /* 1: the clock went backward, stood still or jumped, and the frame ended at its cap of work units. */
  uint32_t clock_fault;
  /* Seconds simulated since create or reset. */
  double simulated;
  /* Seconds that were asked for since then and not simulated. Later frames make up two frames' worth; what is beyond
   * that is given up and stays in this sum. 0: no slow motion. */
  double debt;
} sandglass_time_report;

/* The sand and the rigid bodies after a frame, what the frame did and left out, and totals since create or reset. */
typedef struct sandglass_sand_report {
  /* Particles in the scene, and those of them that are not asleep. */
  uint32_t particles, awake;
  /* Grains in the scene, and those of the last pass over them that were not asleep, in whole groups of 16. */
  uint32_t grains, awake_grains;
  /* Numbers given out so far: the length of what sandglass_scene_particles writes, and sandglass_scene_grains. */
  uint32_t particle_numbers, grain_numbers;
  /* Seconds of simulated time: that which the grains have reached (the particles, in a scene without grains), and an even
   * one to draw, never beyond it. They are equal without slow motion. In it grains move in some frames and stand in the
   * others, so an app draws them 5 to 15 ms later, between its last two buffers:
   *     if (report.sand.grains_time > newer.time) older = newer, newer = this buffer and its grains_time;
   *                                               (else this buffer is written again in the next frame)
   *     share = (shown_time - older.time) / (newer.time - older.time), from 0 to 1      once a frame
   *     position = older.position + share * (newer.position - older.position)           in the vertex shader
   * A grain whose speed is below 0 in one of the two was removed or is new: it is drawn as in the newer one. So is one that
   * moved further than its speeds explain: its number was given anew. After move, restore and reset begin anew. */
  double grains_time, shown_time;
  /* Seconds by which the oldest grain is behind the particles. Never ten frames: simulated time slows before. */
  float grain_lag;
  /* Seconds: the length of the last sub-step. */
  float substep;
  /* m/s: the fastest particle in the last sub-step, of those that can reach something. */
  float speed_max;
  /* Sub-steps that were completed in this frame, and neighbour lists that were built. */
  uint32_t substeps, list_builds;
  /* Neighbours beyond the capacity of a list (32), summed over the list builds of the frame. 0 in any packing. */
  uint32_t dropped_contacts;
  /* Particles and grains that were found not finite, or beyond twice the coordinate limit, and put to rest inside. */
  uint32_t quarantined;
  /* What this frame left out: not finite, without size, or beyond its capacity. */
  uint32_t ignored_colliders, ignored_emitters, ignored_sinks;
  /* 1: the grid by which grains follow the particles had no room for some place in the last pass. Grains there follow
   * more roughly. It has room for sand of the scene's capacity, but not strewn thinly over wide floors. */
  uint32_t grid_full;
  /* What emitters added in all. */
  uint64_t emitted_particles, emitted_grains;
  /* Particles that emitters left out: for want of capacity, or because something was in their place. */
  uint64_t denied_particles;
  /* What sinks, sandglass_scene_remove and sandglass_scene_remove_body took away in all, what fell by
   * granular.lowest, and what left the coordinate limit. The particles of bodies count among the particles. */
  uint64_t removed_particles, removed_grains, removed_bodies;
} sandglass_sand_report;

/* Numbers that grow when a byte of what they stand for has changed, also by calls between frames (then in the next
 * frame's report), and else only by sandglass_scene_restore, _move and _reset. Textures, casts and skins have their own. */
typedef struct sandglass_version_report {
  /* What is written to input.grains. */
  uint64_t grains;
  /* The poses of the rigid bodies. */
  uint64_t bodies;
  /* The light of input.estimator. */
  uint64_t estimator;
  /* What input.room tells of its light: grows with each image that it learns from, and with each call that changes it. */
  uint64_t room;
} sandglass_version_report;

/* The shadows of objects that were in the input. */
typedef struct sandglass_shadow_report {
  /* Textures, over all shadows and lights, that are not yet those of their lights; ambient shadows that are not yet those
   * of their cells; and textures of casts that are out of date. */
  uint32_t pending;
  /* Calls of set_light since the oldest texture of a light among them was begun. */
  uint32_t calls_behind;
} sandglass_shadow_report;

/* The light of input.estimator, and the camera's image. */
typedef struct sandglass_estimator_report {
  /* 1: there is one. */
  uint32_t valid;
  /* 1: it changed in this frame. */
  uint32_t changed;
  /* Frames with this estimator since the frame that brought the image of its last estimate. */
  uint32_t frames_behind;
  /* Work units left of the estimate under way. */
  uint32_t units_left;
  /* 1: input.camera or input.depth cannot be used. sandglass_camera_check and the log hook say why. */
  uint32_t ignored_images;
} sandglass_estimator_report;

/* What a frame did: a group for each capability, which is all 0 where the frame has none of it. runtime/README.md says
 * how to read it. */
typedef struct sandglass_frame_report {
  uint32_t struct_size;
  /* The quality level: 0 is full; see sandglass_level_name. */
  uint32_t level;
  /* Frames since create or reset, this one included. */
  uint64_t frame;
  /* What was executed: record it to replay the frame. */
  sandglass_plan plan;
  /* How long it took. */
  sandglass_time_report time;
  /* What each sandglass_stage did. */
  sandglass_stage_report stages[SANDGLASS_STAGE_COUNT];
  /* The material. */
  sandglass_sand_report sand;
  /* What an app draws: where these are as they were, and the camera stands still, nothing need be drawn or uploaded. */
  sandglass_version_report versions;
  /* Those of objects. */
  sandglass_shadow_report shadows;
  /* The light by a network. */
  sandglass_estimator_report estimator;
} sandglass_frame_report;

/* Advances the scene by one frame. Simulated time moves on by input->time_step plus the time debt of earlier frames, as
 * far as the budget admits; without a time step it is a pause, and nothing moves. At most two frames' worth of debt is
 * made up; the rest is given up, as slow motion, and stays counted in report.time.debt. After the call, positions are
 * valid and grains are written, whatever the budget was.
 *
 * `report` is optional. The frame does not fail for lack of time: it degrades, along the quality ladder, and the report
 * says so. So its status need not be looked at once an app works. It fails with INVALID_ARGUMENT: NULL, a wrong or
 * unset struct_size, a grain_stride that is not usable, an array that is NULL while its count is above 0, or NULL among
 * the shadows or casts; nothing was changed. It fails with REPLAY: input->plan is malformed, and nothing was changed; or the
 * plan asks for a work unit that this state does not offer. Then the frame ended there: the scene is valid, but it is
 * not the recorded one. Reset it.
 *
 * Guarantee, for a clock that runs: elapsed_ns <= max(target_ns, mandatory_ns) + last_unit_ns. A frame is at most one
 * work unit late, plus what writing the grains, which comes last and is always done, took beyond its own prediction. */
SANDGLASS_API sandglass_status sandglass_scene_frame(sandglass_scene* scene, const sandglass_frame_input* input,
                                                     sandglass_frame_report* report, const char** reason);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* SANDGLASS_FRAME_H */

// Layer 3 of granular: how particles go through time. Time and the quality ladder, the sub-step and its passes, rigid
// bodies, what sleeps, and what has departed.
#pragma once

#include "kernels/kernels.h"
#include "runtime/frame/governor.h"
#include "runtime/frame/layout.h"
#include "runtime/sand/particles.h"
#include "sandglass/sandglass.h"

namespace sandglass {

struct Granular;

// ---- SimulatedTime (time_debt.cpp)
//
// Simulated time: what the frames ask for, what is still to make up (the debt), and how it is cut into equal intervals,
// after each of which the grains may follow, and these into equal sub-steps.

constexpr double k_time_resolution = 1e-9;  // seconds; a shorter debt counts as none
constexpr float k_longest_step = 0.1f;      // seconds; a frame asks for no more

// The instant that is drawn. In slow motion what is drawn catches up in some frames and stands in the others; between
// its last two states lies an instant that moves on evenly, and never beyond what was reached. In simulated seconds.
struct ShownTime {
  // What the simulation had reached in the last frame, and what was drawn.
  double reached, shown;
  // Simulated seconds a second of the app's, smoothed.
  double rate;
  // The smallest of the recent differences between the two: what is drawn could be as much nearer to what was reached.
  double spare;
};

void shown_reset(ShownTime* shown);
// A frame of `step` seconds is over. Full rate: it is shown at once.
void shown_follow(ShownTime* shown, double reached, double step);

// All in seconds.
struct SimulatedTime {
  float frame_step;      // the app's time step; 0: a pause
  double debt;           // simulated time to make up
  double interval_debt;  // the debt once the interval under way is complete
  double slipped;        // was asked for and is not made up any more: slow motion
  double simulated;      // in all
  double grain_lag;      // what the particles have gone through and the grains have not yet
  ShownTime grains;      // of the grains; of the particles where there are none
  double asked;          // the debt, with this frame's step
  float left_out;        // what the app asked for in this frame beyond the longest step
  // The share of the time asked for that is simulated while colliders move, smoothed. 1: no slow motion.
  double share;
  // The share of their given velocities that colliders have in simulated time.
  double rate;
};

// What the next sub-step will be.
struct SubstepPlan {
  double interval;  // the interval that it begins; 0: it goes on with the one under way
  uint32_t count;   // sub-steps left in the interval, this one included
  float substep;    // seconds
  bool stale;       // the lists must be rebuilt first
};

void time_reset(SimulatedTime* time);
void time_restore(SimulatedTime* time, const SavedScene& saved);

// Adds a frame's time step to the debt.
void time_take(SimulatedTime* time, const Granular& granular, float step);
// At the end of a frame in which colliders move: finds `share` and the next `rate`. Colliders end the frame where the
// app gives them, whatever was simulated. In the next frame they are slower than given: sand feels them for less time
// than the app's, and they must not go further than given in the debt and that frame's step. Returns the next rate over
// this one.
float time_find_rate(SimulatedTime* time);
// No collider moves.
void time_forget_rate(SimulatedTime* time);
// The frame is over.
void time_end_frame(SimulatedTime* time, const Granular& granular);
// Whether the frame is a pause: whatever is owed, the particles and the grains do nothing.
bool time_paused(const Granular& granular);
// A sub-step is complete: pays its part of the debt.
void time_pay(SimulatedTime* time, const Granular& granular);
// Pays the whole debt at once, while all sleep.
void time_skip(SimulatedTime* time, const Granular& granular);
// An interval of so many seconds begins. Between frames there may be none.
void time_begin_interval(SimulatedTime* time, double interval);
void time_forget_interval(SimulatedTime* time);
// The grains have followed through so many seconds, or have nothing to follow.
void time_grains_followed(SimulatedTime* time, double seconds);
void time_grains_followed(SimulatedTime* time);

// The next interval: equal parts of the debt, at most a frame long; with the dissertation's rule at most refine_step.
double time_interval(const Granular& granular);
// The number of equal sub-steps of an interval: (4.45) within the scheme's range (correction to Alg. 5).
uint32_t time_substeps(const Granular& granular, double interval, uint32_t level);
SubstepPlan time_plan_substep(const Granular& granular, uint32_t level);

// As much as the next sweep of the grains may cover, besides the one under way.
double time_lag_limit(const Granular& granular);
// Whether the next interval waits until the grains have followed. They follow whatever the particles have gone through
// once there is no time debt, and before they would be more than two frames behind: time slows rather than leave grains
// behind further. With the dissertation's rule they follow after each interval.
bool time_awaits_grains(const Granular& granular);

// ---- The quality ladder (time_debt.cpp)
//
// The quality ladder: what a frame gives up, in order, when its budget does not hold everything. A level includes what
// the levels before it gave up. The governor takes the first one whose predicted cost fits.
//
// The order is that of the measured errors (sandglass_lab bench ladder): the guarantee of the neighbour lists first, which
// on a collapsing column changes no percentile of the overlap, only single impacts; then the length of the sub-steps,
// whose error grows with its square; simulated time last. Twice the sub-step is the end: beyond it, impacts overlap by
// half a radius.

struct QualityLevel {
  // Neighbour lists are kept until the particles' motion could have closed so many skins.
  float list_reuse;
  // With one solver iteration, sub-steps are so many times as long; with several, there are so many times fewer
  // iterations.
  float coarsening;
  sandglass_level reported;  // to the app
};

extern const QualityLevel k_ladder[SANDGLASS_LEVEL_COUNT];

// What a level makes of the description's solver iterations and longest sub-step.
uint32_t level_iterations(const QualityLevel& level, uint32_t iterations);
float level_substep(const QualityLevel& level, uint32_t iterations, float longest);

// ---- Substep (substep.cpp)
//
// The particles' stage: simulated time in equal sub-steps, each a sequence of phases, each phase a sequence of units.
// One machine says which phase follows which (substep.cpp).
//
// A frame may end between any two units. records[0] of the particles then holds the last complete sub-step, so the
// scene is valid.

// In the order in which they run. The first, and those from touch on, run only where they are due.
enum class SubstepPhase : uint32_t {
  idle,        // between sub-steps
  departed,    // before an interval: what can reach nothing in it
  slack,       // what the lists are still good for
  sort,        // the particles by cell, where the lists are stale
  lists,       // new neighbour lists
  colours,     // of the pairs, where lists are new
  stabilise,   // passes that correct the start positions
  solve,       // the source's passes, which predict, resolve contacts and integrate
  predict,     // motion without contacts
  pairs,       // passes that resolve contacts, pair by pair
  complete,    // colliders, and the new state
  bodies,      // rigid motion instead of their particles' own
  touch,       // who is near a collider that moved wakes
  wake,        // who was run into wakes
  sleep,       // who has kept still falls asleep
  drain,       // who is inside a sink goes
  wake_lists,  // lists for those that woke
};

struct Substep {
  SubstepPhase phase;
  uint32_t level;           // quality level at which the sub-step began
  uint32_t due;             // phases that must run before the next sub-step begins: bit 1 << phase
  uint32_t cursor;          // next item of the phase
  uint32_t interval_left;   // sub-steps left in the interval, this one included
  float length;             // seconds
  float longest, shortest;  // seconds; what the scheme allows
};

// Nothing may be under way.
void substep_reset(Substep* substep);
void substep_set_limits(Substep* substep, float longest, float shortest);
// What must not find particles elsewhere ends: a measurement, a sort, the bodies' phase.
void substep_end_for_carry(Granular* granular);
// While all sleep there is no interval.
void substep_end_interval(Substep* substep);
Stage granular_particle_stage(Granular* granular);

// Nothing is under way and nothing is due.
bool substep_idle(const Granular& granular);
void substep_set_due(Substep* substep, SubstepPhase phase, bool due);
// Before material changes: the sub-step under way starts again from the last state, or ends where bodies have already
// moved.
void substep_abandon(Granular* granular);

// ---- Carry (carry.cpp)
//
// Colliders that go on without time for sand carry what they hold: rigidly, with its velocity. In a frame's first units
// those that have jumped do; in its last ones, before output, all that move where the frame's time was not enough. So
// sand is where its vessel is drawn, whatever the budget. Who is held is geometry alone:
//   enclosed   in a field that is solid outside, the nearest
//   supported  the first surface below, along gravity, is the collider's, and sand is within the box around all that
//              share its motion: a bucket of five boxes. Not above one ball or box alone, unless it goes along with it.
// Of several holders the innermost counts: a jar that is carried in a car. What only lies on a ball or a box goes by
// the share of its displacement that the sand has of its velocity, and friction adds to that. What is not held and
// would be in the collider gives way (giving.cpp). But what has jumped pushes nothing, and carries only what stands in
// a vessel.
//
// All copies of a particle are moved, so that the sub-step under way goes on where it was carried.

constexpr uint32_t k_carry_groups = 16;

struct HeldScratch;
struct Giving;

// Colliders that share a motion.
struct CarryGroup {
  uint32_t first, members;
  // Around all of them, in the axes of the first.
  Bounds box;
  // Sand may stand in the box.
  bool hollow;
  // They move so little that sand is not pressed into them by other colliders.
  bool slow;
};

struct Carry {
  enum class Moment : uint8_t { none, jump, close } due;
  bool moving;   // a collider moves sand
  bool may_lag;  // so far that it shows, if nothing of the frame is simulated
  bool closing;  // the frame's optional units are over
  bool known;    // motions and groups are found
  bool usual;    // it has closed a frame before: its own cost is known
  bool holds;    // the last that closed a frame carried sand in a vessel
  uint32_t cursor;
  // Velocities of colliders, over those before.
  float faster;
  // Of each solid collider: its group, or k_carry_groups where it carries nothing; and the box around where it starts.
  uint8_t* group_of;
  Bounds* reaches;
  HeldScratch* scratch;
  CarryGroup groups[k_carry_groups];
  uint32_t group_count;
  // The collider that holds a body, plus 1.
  uint16_t body_holders[256];
  // Boxes around particles that the units so far have found: those that each group holds, before and after; that were
  // pushed; that sleep and were moved; and that nothing holds.
  Bounds held[k_carry_groups], pushed, resting, standing;
  // The longest displacement of a particle, metres, and the greatest square of a speed.
  float displacement_max, fastest2;
  // Some particle has moved otherwise than its holder.
  bool gave_way;
  Giving* giving;
};

void carry_layout(Carry* carry, const sandglass_granular_desc& desc, Layout* layout);
void carry_reset(Carry* carry);
void carry_begin_frame(Carry* carry, const Granular& granular, bool jumped, bool moving);
// The optional units of the frame are over. Sand is carried now, unless it lags so little that nobody sees it.
void carry_close(Carry* carry, const Granular& granular);
// Whether units are to come, and the items of the next.
bool carry_is_due(const Granular& granular);
void carry_unit(const Granular& granular, WorkUnit* unit);
// How many items recent frames took for what gives way, at most.
uint32_t giving_usual(const Carry& carry);
// Units of a carry of all particles; and whether the end of this frame may have them.
uint32_t carry_units(const Granular& granular);
bool carry_is_expected(const Granular& granular);
// The carriers are known. `faster`: their velocities over those before.
void carry_begin(Carry* carry, const Granular& granular, float faster);
// Which of the carriers share a motion.
void carry_find_groups(Carry* carry, const Granular& granular);
// One unit. True once all particles are carried.
bool carry_run(Carry* carry, const Granular& granular);
void carry_end(Carry* carry);
// A box around all that was moved, where it was and where it is, wider by `margin`.
Bounds carry_bounds(const Carry& carry, float margin);
// Whether particles that are held by different groups, or not at all, may be near each other.
bool carry_mixes(const Granular& granular);

// ---- Contacts (contacts.cpp)
//
// The passes of a sub-step over the particles: what the contact kernels are given, and what they have seen.

// The extent of a pass that has seen no particle.
constexpr ContactExtent k_extent_of_none = {
    0.0f, {3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}, {3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}, 0, 0};

struct Contacts {
  uint32_t pass;         // of the stabilisation or of the solver
  uint32_t iterations;   // passes of the solver
  uint32_t dither;       // phase of the sequence by which gravity varies
  ContactExtent extent;  // what the last pass has seen so far
};

// Whether contacts are solved pair by pair. The other scheme is the source's.
bool solves_pairs(const Granular& granular);
// Metres a second that what is deep in a collider may leave it with, besides the collider's own velocity.
float contacts_leave_speed(const Granular& granular);

void contacts_reset(Contacts* contacts);
void contacts_restore(Contacts* contacts, const SavedScene& saved);
// As after a reset, but what varies gravity goes on.
void contacts_forget(Contacts* contacts);
// So many passes of the solver.
void contacts_begin(Contacts* contacts, uint32_t iterations);
// Nothing is seen yet.
void contacts_clear_extent(Contacts* contacts);
// One unit of a pass. True once the pass is complete.
bool contacts_run(Contacts* contacts, const Granular& granular, uint32_t* cursor);
bool contacts_run_pairs(Contacts* contacts, const Granular& granular, uint32_t* cursor);
// The next pass begins. False: there are only `passes` of them, and what comes next begins with its first.
bool contacts_next_pass(Contacts* contacts, uint32_t passes);
// Others have moved particles too.
void contacts_include(Contacts* contacts, const ContactExtent& extent);
// The sub-step is complete.
void contacts_complete(Contacts* contacts, FrameCounts* counts);

// ---- Bodies (bodies.cpp)
//
// Rigid bodies by shape matching (4.28-4.36). The particles of a body take part in the contact pass like sand, each
// with its own inverse mass. After it, the rigid motion that fits their displacements best replaces them. So contacts
// push bodies and bodies push sand, and linear momentum is what the particles' was.
//
// A body carries its pose (centre in double, rotation). What is matched is the displacement of the sub-step: small
// quantities, never differences of stored positions (correction to Alg. 4). Positions then follow from the pose, so a
// body stays rigid to the rounding of a float however often it moves.
//
// A body sleeps and wakes as a whole.

struct RigidBody {
  uint32_t first, count;        // slots of its particles
  double center[3];             // of mass
  double rotation[4];           // from the rest shape
  float linear[3], angular[3];  // velocities, m/s and rad/s
};

// Sums over a body's particles, and the motion that they give.
struct BodyMatch {
  double shift[3], stabilised[3], offset[3], a[9];
  double spread[9], spin[3];  // sums of r r^T and of r x displacement
  double turn[4];
};

// Each particle of a body has a slot; a body's slots follow each other, and no slot is free in between. A body that was
// removed leaves a number free: in its place stands a body of nothing but zeros. The last one has particles.
struct Bodies {
  RigidBody* all;
  float* rest_shape;  // 3 a slot: position from the centre of mass, unturned
  // Of each slot: its particle's index, and its number.
  uint32_t *rows, *numbers;
  // Of each body: particles that the drain under way found in a sink.
  uint32_t* inside;
  uint32_t count, particle_count;
  float densest;  // density relative to sand
  // Progress of the phase: the particles of a body are summed up, then moved.
  uint32_t cursor, particle;
  bool moves;
  BodyMatch match;
  ContactExtent extent;  // of the particles that the phase has moved
};

void bodies_layout(Bodies* bodies, const sandglass_granular_desc& desc, Layout* layout);
void bodies_reset(Bodies* bodies);
void bodies_restore(Bodies* bodies, const SavedScene& saved);

bool bodies_has(const Bodies& bodies, uint32_t index);
bool bodies_awake(const Granular& granular, const RigidBody& body);
// The lowest free number of a body; `capacity` where none is free.
uint32_t bodies_free_number(const Bodies& bodies, uint32_t capacity);
// Adds a body of the particles from this row on. Their records stay: who adds it lets them join, with its velocities.
void bodies_add(Bodies* bodies, const Granular& granular, uint32_t number, const sandglass_body& body,
                uint32_t first_row);
// Takes the body out. Its particles are gone. No phase of the bodies may be under way.
void bodies_remove(Bodies* bodies, const Granular& granular, uint32_t index);
// The body is elsewhere or has other velocities. Its particles are where they were.
void bodies_set(Bodies* bodies, uint32_t index, const RigidBody& changed);
// Gives the particles of a body the velocities that its own say.
void bodies_spread_velocities(const Granular& granular, const RigidBody& body);
// Where the pose of a body puts the particle of a slot.
void bodies_place(const Bodies& bodies, const RigidBody& body, uint32_t slot, float position[3]);
// The body falls asleep with its particles.
void bodies_stop(Bodies* bodies, uint32_t index);
void bodies_move(Bodies* bodies, const SceneMove& move);
// One goes along with what holds it, and takes on this velocity besides.
void bodies_carry(const Granular& granular, uint32_t index, const RigidMotion& motion, const float faster[3]);

// The phase of a sub-step. False: no body is awake.
bool bodies_begin(Bodies* bodies, const Granular& granular);
uint32_t bodies_items(const Granular& granular);                                 // of the next unit
bool bodies_run(Bodies* bodies, const Granular& granular, FrameCounts* counts);  // true once all are done

// Where the particles of bodies are after sorting: of all, and of the particle with this index.
void bodies_find_rows(const Granular& granular);
void bodies_note_row(const Granular& granular, uint32_t index);

// Sinks take the bodies of which they hold every particle. The drain notes each awake particle of body `index` that it
// finds inside.
void bodies_begin_drain(const Bodies& bodies);
void bodies_note_inside(const Bodies& bodies, uint32_t index);
bool bodies_all_inside(const Bodies& bodies, uint32_t index);

// ---- Sleep (sleep.cpp)
//
// Sleep of the particles. A particle that has stayed near one place for sleep_after seconds, and touches something where
// there is gravity, stops and falls asleep. Its neighbours then see a thing of infinite mass. Record groups (16 records)
// in which all sleep are left out of every pass, so resting sand costs almost nothing.
//
// What wakes a particle in a frame:
//   touch   a collider that moved, appeared or went away comes or was within reach
//   wake    after each sub-step: a fast neighbour that is away from where it last rested runs into it
//   sleep   every 20 ms of simulated time: a neighbour has moved on, by more than the distance that counts as rest
//   body    another particle of its rigid body wakes
//   carrier a collider that moves slowly, a belt or a lift, keeps awake what lies on it: else the upper sand would sleep
//           and stay behind, since no neighbour of it moves on within sleep_after
// So a pile wakes shell by shell from where it was disturbed, as fast as the disturbance travels, and no further. A
// particle that trembles around one place does sleep: what counts is where it is. Outside a frame everything wakes when
// material is removed, the boundary is set or the friction changes.
//
// Lists are kept for active groups only. A group that wakes gets its lists from the grid of the last build. They are
// the lists that it would have had if it had been awake then.

constexpr double k_sleep_period = 0.02;  // seconds of simulated time between looks at who falls asleep

// asleep: left out of the passes. waking: awake, but without neighbour lists yet.
enum class GroupState : uint8_t { asleep, active, waking };

// Where a particle last moved on, and for how long it has stayed near. Kept by the particle's number.
struct Anchor {
  float position[3];
  // Checks in a row that found it near, and two bits (sleep.cpp). k_asleep: it sleeps.
  uint16_t quiet;
  // How many contacts further a slow carrier still keeps particles awake.
  uint8_t carried;
  // How often it woke since it moved on, 8 at most.
  uint8_t woken;
  // Of a body's particle: its place in the arrays of Bodies.
  uint32_t body_slot;
};
constexpr uint16_t k_asleep = 0xffff;

struct Sleep {
  uint32_t* active_groups;   // numbers of the groups that the passes run over
  GroupState* group_states;  // one a group
  uint8_t* touched;          // one a group: 1 where the last sub-step saw a particle run into a sleeper
  Anchor* anchors;           // one a number
  uint32_t active_count;
  uint32_t awake_count;     // particles
  uint32_t waking_count;    // groups
  double next_check;        // simulated time of the next look
  Bounds resting;           // holds what sleeps; too wide where some has woken since lists were built
  Bounds resting_in_lists;  // while they are built
};

void sleep_layout(Sleep* sleep, const sandglass_granular_desc& desc, uint32_t rows, Layout* layout);
void sleep_reset(Sleep* sleep);
void sleep_restore(Sleep* sleep, const SavedScene& saved);
// `numbers`: how many there are.
void sleep_move(Sleep* sleep, uint32_t numbers, const SceneMove& move);
// Of sixteen particles those of the bits were carried: they rest where they rest in what holds them.
void sleep_carry(const Granular& granular, const Particle* records, uint32_t which, const RigidMotion& motion);
void sleep_include_resting(Sleep* sleep, const Bounds& carried);

// A particle that was added under this number is awake.
void sleep_add(Sleep* sleep, uint32_t number, const float position[3]);
// The particle with this number begins to rest here. It must be awake.
void sleep_begin_rest(Sleep* sleep, uint32_t number, const float position[3]);
// The particle with this number has this slot of Bodies.
void sleep_set_body_slot(Sleep* sleep, uint32_t number, uint32_t slot);
// A particle was taken out that was awake.
void sleep_removed(Sleep* sleep);
// What lies in the box wakes, bodies as a whole. The lists must be built anew then.
void sleep_wake_box(Sleep* sleep, const Granular& granular, const float low[3], const float high[3]);
// Everything wakes. Only outside a frame, and the lists must be built anew.
void sleep_wake_all(Sleep* sleep, const Granular& granular);
// Which groups wake is found out by the next build of lists.
void sleep_forget_waking(Sleep* sleep);
// Finds what rests, and who is awake.
void sleep_find_resting(Sleep* sleep, const Granular& granular);
void sleep_recount(Sleep* sleep, const Granular& granular);

// While the lists are built, who is awake is counted anew: unit by unit.
void sleep_begin_count(Sleep* sleep);
void sleep_count(Sleep* sleep, uint32_t awake, const Bounds& resting);
void sleep_end_count(Sleep* sleep, const Granular& granular);
// Whether all of a group sleep. If so, every array gets the group as it is. Adds its awake particles to *awake_count,
// and the others to *resting.
bool sleep_sort_group(const Granular& granular, uint32_t group, uint32_t* awake_count, Bounds* resting);
// The particles of the active groups, whole groups.
uint32_t sleep_active_items(const Granular& granular);

// Whether the next look at who falls asleep is due. If so, the one after it comes a period later.
bool sleep_check_due(Sleep* sleep, const Granular& granular);

// The phases. Each function runs a unit and is true once its phase is done. Those that fall asleep stop their bodies.
bool sleep_run_touch(Sleep* sleep, const Granular& granular, uint32_t* cursor);
bool sleep_run_wake(Sleep* sleep, const Granular& granular, uint32_t* cursor);
bool sleep_run_sleep(Sleep* sleep, const Granular& granular, uint32_t* cursor);
bool sleep_run_wake_lists(Sleep* sleep, const Granular& granular, uint32_t* cursor, FrameCounts* counts);
// A body whose particles have all kept still falls asleep. Whether this one does.
bool sleep_put_body(Sleep* sleep, const Granular& granular, const RigidBody& body);
// Who sleeps has changed: which groups the passes run over.
void sleep_collect_groups(Sleep* sleep, const Granular& granular);

// sqrt(g d) in m/s, for the diameter d. Weightless scenes take the Earth's gravity.
float granular_speed_scale(const Granular& granular);
// Metres per second; what is slower wakes nobody.
float sleep_wake_speed(const Granular& granular);

// ---- Departed (departed.cpp)
//
// What has departed: particles that can reach nothing before the interval ends. They fall and fly as all do, but the
// sub-steps are not chosen for their speed, lists are not built for their paths, and they wake nobody. So one fast
// particle does not drive all. Before each interval of simulated time the particles are looked through, where one is
// fast enough to matter. A particle has departed
//
//   below   where it falls, lower than all that is there, with nothing under it. What falls there together keeps the
//           contacts that its lists know.
//   beside  where it is fast, and its path clear of the box that holds all the others, of each collider, and of the
//           paths of the other fast ones. That is for few: from k_fast_max on they are a flow.
//
// What comes back counts again before it touches anything: lists are built then. What has fallen by `lowest`, or is
// beyond the coordinate limit, is gone: the drains take it out.

// Depths of the highest and the lowest of a body's particles; and whether the body has departed below.
struct BodySpan {
  float top, bottom;
  bool below;
};

constexpr uint32_t k_fast_max = 64;

struct Departed {
  uint32_t count;      // particles that have departed, as the last look found
  bool known;          // the look for the interval that begins is done
  bool gone;           // some particle has to be taken out
  bool grains_go;      // the grains' drain looks for grains to take out
  double next_grains;  // simulated time of the next such look
  // ---- the frame; depths are along gravity, metres from the origin
  bool falls;        // there is something to fall from, and no half-space under it
  bool open;         // no collider fills all space beyond it
  bool bounded;      // a collider has an end
  float bottom;      // depth of the lowest thing that is there
  float gone_depth;  // what is deeper is taken out
  // ---- the look under way
  BodySpan* spans;  // one a body
  float below;      // depth from which on sand has departed
  float horizon;    // seconds until the interval ends
  float reach;      // metres; a particle that goes further until then, besides its fall, is fast
  // The particles that have not departed: those that are not fast, and the fast ones. Boxes and squares of speeds.
  Bounds others, fast_ones;
  float others_speed2, fast_speed2;
  uint32_t found, fast_count;
  uint32_t fast[k_fast_max];
  bool narrow;    // bounds and speed of the others have changed
  bool returned;  // some particle that had departed counts again
};

void departed_layout(Departed* departed, const sandglass_granular_desc& desc, Layout* layout);
void departed_reset(Departed* departed);
// Takes a frame's colliders and gravity.
void departed_begin_frame(Departed* departed, const Granular& granular);
// An interval begins: the look was for it.
void departed_begin_interval(Departed* departed);

// The phase before an interval.
bool departed_due(const Granular& granular);
uint32_t departed_items(const Granular& granular);
bool departed_run(Departed* departed, const Granular& granular, uint32_t* cursor);
// What the look that is done says of the particles that have not departed. False: nothing new.
bool departed_narrows(const Departed& departed, const Granular& granular, Bounds* all, float* speed_max);

// After a sweep: whether grains are to be looked for that are gone.
bool departed_takes_grains(Departed* departed, const Granular& granular);
// Whether it has left what is there, so that a move may lose it. Rigid bodies and the boundary never have.
bool departed_has_left(const Granular& granular, const Particle& particle);
bool departed_has_left(const Granular& granular, const Grain& grain);
// Whether what is here has fallen too far, or flown.
bool departed_is_gone(const Granular& granular, const float position[3]);

}  // namespace sandglass

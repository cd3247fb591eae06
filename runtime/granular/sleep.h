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
#pragma once

#include "kernels/particle.h"
#include "runtime/core/layout.h"
#include "runtime/granular/particles.h"

namespace sandglass {

struct Granular;

constexpr double k_sleep_period = 0.02;  // seconds of simulated time between looks at who falls asleep

// asleep: left out of the passes. waking: awake, but without neighbour lists yet.
enum class GroupState : uint8_t { asleep, active, waking };

// Where a particle last moved on, and for how long it has stayed near. Kept by the particle's number.
struct Anchor {
  float position[3];
  uint16_t quiet;      // checks in a row that found it near; k_asleep: it sleeps
  uint16_t carried;    // contacts from it that a slow carrier still keeps awake
  uint32_t body_slot;  // of a body's particle: its place in the arrays of Bodies
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

// A particle that was added under this number is awake.
void sleep_add(Sleep* sleep, uint32_t number, const float position[3]);
// The particle with this number begins to rest here. It must be awake.
void sleep_begin_rest(Sleep* sleep, uint32_t number, const float position[3]);
// What lies in the box wakes, bodies as a whole. The lists must be built anew then.
void sleep_wake_box(Granular* granular, const float low[3], const float high[3]);
// Everything wakes. Only outside a frame.
void sleep_wake_all(Granular* granular);
// Whether the particle with this index touches a particle, not of its own body, the boundary or a collider. Without
// gravity all may rest.
bool sleep_may_rest(Granular* granular, uint32_t index);
// Puts the particle with this index to sleep. The rest of its body must follow.
void sleep_put_one(Granular* granular, uint32_t index);

// While the lists are built: whether all of a group sleep. If so, every array gets the group as it is. Adds its awake
// particles to *awake_count, and the others to *resting.
bool sleep_sort_group(Granular* granular, uint32_t group, uint32_t* awake_count, Bounds* resting);
// active_groups from group_states.
void sleep_collect_groups(Granular* granular);
// The particles of the active groups, whole groups.
uint32_t sleep_active_items(const Granular& granular);

// While all sleep, time passes without sub-steps.
void sleep_skip_time(Granular* granular);

// The phases. Each function runs a unit and is true once its phase is done.
bool sleep_run_touch(Granular* granular);
bool sleep_run_wake(Granular* granular);
bool sleep_run_sleep(Granular* granular);
bool sleep_run_wake_lists(Granular* granular);

// sqrt(g d) in m/s, for the diameter d. Weightless scenes take the Earth's gravity.
float granular_speed_scale(const Granular& granular);
// Metres per second; what is slower wakes nobody.
float sleep_wake_speed(const Granular& granular);

}  // namespace sandglass

// What a capability is to a frame: one table of functions, which creation leaves in the first word of the handle. A scene calls
// through it, so it links no capability that the app never creates.
//
// A stage of the frame is a group of capabilities, most often of one. Of one group one unit runs at a time, and they take turns
// (turns.cpp): what is under way is completed first; then the capability comes that was served longest ago, and of its handles
// the most urgent one.
#pragma once

#include <cstdint>

#include "runtime/frame/governor.h"

struct sandglass_skin;

namespace sandglass {

struct Granular;
struct Particle;
struct Grain;
struct SkinState;

// The sand as the app draws it: one of the four pointers is not null. A scene swaps its arrays from sub-step to sub-step, so the
// first two point to the scene's own pointer.
struct DrawnSand {
  const Particle* const* particles;
  const Grain* const* grains;
  const float* positions;  // x y z of each
  uint32_t count;
  float radius;  // metres
  const SkinState* skin;
  uint32_t version;  // of the skin
  bool moving;       // some sand is awake
};

// What a capability may look at as a frame begins.
struct FrameView {
  const sandglass_frame_input* input;
  const Granular* granular;
  DrawnSand drawn;
  const char** refused;  // what is wrong with the frame's image, where it cannot be used
};

struct Capability {
  // Returns how many of its units this frame must run.
  uint32_t (*begin_frame)(void* handle, const FrameView& view);
  // These three are as in Stage. Forecasts of several handles are added up kind by kind.
  bool (*next)(const void* handle, uint32_t level, WorkUnit* unit);
  void (*run)(void* handle, uint32_t level);
  uint32_t (*forecast)(const void* handle, uint32_t level, Forecast* entries);
  // Whether it has begun what it must complete before others of its group have a turn.
  bool (*under_way)(const void* handle);
  // Of its handles that have work, the one for which this is greatest comes first. NULL: the one under way, then the
  // one that was served longest ago.
  double (*urgency)(const void* handle) = nullptr;
  // Called for each of its handles once one of them, `by`, has run a unit. May be NULL.
  void (*served)(void* handle, const void* by) = nullptr;
  // Drops what belongs to the app, and fills in its part of the report. NULL: it has none.
  void (*end_frame)(void* handle, sandglass_frame_report* report) = nullptr;
  // Its part of what closes a frame (Closing, scene.h), with the same kinds. NULL: none.
  Stage (*closing)(void* handle) = nullptr;
};

// What every handle begins with.
struct Member {
  const Capability* capability;
  uint64_t served;  // when it last ran a unit, counted by the units of its group
};

// All handles of one capability in a frame: an array of pointers to them, as the app gives it.
struct Members {
  const void* handles;
  uint32_t count;
  uint32_t kinds;  // also of a capability that a frame leaves out: the predictor's memory is by place
};
inline Member* member_at(const Members& members, uint32_t i) {
  void* handle;
  __builtin_memcpy(&handle, static_cast<const char*>(members.handles) + i * sizeof handle, sizeof handle);
  return static_cast<Member*>(handle);
}
// One handle, which may be NULL.
template <class Handle>
Members member_of(Handle* const& handle, uint32_t kinds) {
  return {&handle, handle == nullptr ? 0u : 1u, kinds};
}

// A group as a stage of the frame; must outlive it.
constexpr uint32_t k_group_capacity = 3;
struct Group {
  Members members[k_group_capacity];
  uint32_t count;           // of these
  uint32_t handles, kinds;  // of all of them
  float share;              // see Stage
  uint32_t mandatory;       // units of each frame, beside those that its members must run
};
inline void clear_group(Group* group, float share, uint32_t mandatory) {
  group->count = group->handles = group->kinds = 0;
  group->share = share;
  group->mandatory = mandatory;
}
inline void add_members(Group* group, const Members& members) {
  group->members[group->count++] = members;
  group->handles += members.count;
  group->kinds += members.kinds;
}
Stage begin_group(Group* group, const FrameView& view);
void end_group(const Group& group, sandglass_frame_report* report);
// Runs up to so many units outside a frame. Returns how many there were.
uint32_t run_members(const Members& members, uint32_t units);

}  // namespace sandglass

// The shadow stage of a frame: the shadows of objects that were baked, the one that the sand casts, and casts of triangles, in
// turns (stage.cpp).
#pragma once

#include "runtime/shadow/baked/shadow.h"
#include "runtime/shadow/cast/cast.h"
#include "runtime/shadow/pile/pile.h"

namespace sandglass {

// Kinds of work unit: those of objects, of the sand, of casts.
constexpr uint32_t k_shadow_stage_kinds = uint32_t{k_shadow_kinds} + uint32_t{k_pile_kinds} + uint32_t{k_cast_kinds};

constexpr uint32_t k_shadow_parts = 3;

// What casts a shadow in this frame: the app's shadows of objects, none where the count is 0; that of the sand, which may
// be NULL; and casts, none where their count is 0. Must outlive the stage.
struct FrameShadows {
  ShadowSet objects;
  sandglass_pile_shadow* pile;
  CastSet casts;
  Stage parts[k_shadow_parts] = {};  // filled by shadow_stage
};

// The sand of this frame, and whether some of it is awake.
struct Sand {
  PileSource source;
  bool moving;
};

Stage shadow_stage(FrameShadows* shadows, const Sand& sand);

// Fills in the part of the report that is about shadows.
void shadow_end_frame(const FrameShadows& shadows, sandglass_frame_report* report);

}  // namespace sandglass

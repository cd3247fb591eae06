// The shadow stage of a frame: the shadows of objects and the one that the sand casts, in turns (stage.cpp).
#pragma once

#include "runtime/shadow/pile.h"
#include "runtime/shadow/shadow.h"

namespace sandglass {

// Kinds of work unit: those of objects, then those of the sand.
constexpr uint32_t k_shadow_stage_kinds = uint32_t{k_shadow_kinds} + uint32_t{k_pile_kinds};

// What casts a shadow in this frame: the app's shadows of objects, none where the count is 0, and that of the sand,
// which may be NULL. Must outlive the stage.
struct FrameShadows {
  ShadowSet objects;
  sandglass_pile_shadow* pile;
  Stage parts[2] = {};  // filled by shadow_stage
};

// The sand of this frame, and whether some of it is awake.
struct Sand {
  PileSource source;
  bool moving;
};

Stage shadow_stage(FrameShadows* shadows, const Sand& sand);

// Fills in the part of the report that is about objects' shadows.
void shadow_end_frame(const FrameShadows& shadows, sandglass_frame_report* report);

}  // namespace sandglass

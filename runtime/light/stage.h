// The lighting stage of a frame: what the room has seen, then the network of estimate.h (stage.cpp).
#pragma once

#include "runtime/light/network/estimator.h"
#include "runtime/light/room/room.h"

namespace sandglass {

// Kinds of work unit: those of the room, then those of the network.
constexpr uint32_t k_lighting_stage_kinds = uint32_t{k_room_kinds} + uint32_t{k_estimator_stage_kinds};

// Both may be NULL. Must outlive the stage.
struct FrameLighting {
  sandglass_room* room;
  sandglass_estimator* estimator;
  Stage parts[2] = {};  // filled by lighting_stage
};

// Each takes the frame's image where it is due. *refused says what is wrong with an image that cannot be used, and is
// left alone otherwise.
Stage lighting_stage(FrameLighting* lighting, const sandglass_camera_image* image, const char** refused);

// Drops an image that was not finished and fills in the estimator's part of the report.
void lighting_end_frame(const FrameLighting& lighting, sandglass_frame_report* report);

}  // namespace sandglass

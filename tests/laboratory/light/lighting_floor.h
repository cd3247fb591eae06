// Estimates of one light by what they do to a floor: an object's shadow in the estimated light, against rays, beside
// what an app could draw without an estimate. The object stands a quarter of the room's radius ahead of the camera.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/laboratory/light/verify_lighting.h"
#include "tests/laboratory/room/floor_rows.h"

namespace sandglass::host {

struct LightingFloor {
  RoomStudy study;
  std::vector<DrawnRow> rows;
};

// For each view of `verdicts`. Empty when it was interrupted.
LightingFloor lighting_floor(const LightingVerdicts& verdicts, std::shared_ptr<const std::vector<FloorObject>> objects,
                             uint32_t threads);

// What the rows must show of the estimate; none where there is no estimate.
std::vector<Verdict> floor_verdicts(const std::vector<DrawnRow>& rows);

}  // namespace sandglass::host

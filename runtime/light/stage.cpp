// The room goes first: an image's parts are few units, and the app asks for its light in this frame. Room and network
// are called only through the tables that creation left in their handles, so a scene links neither.
#include "runtime/light/stage.h"

namespace sandglass {
namespace {

enum : uint32_t { k_room, k_network };

FrameLighting& lighting_of(void* state) { return *static_cast<FrameLighting*>(state); }
const FrameLighting& lighting_of(const void* state) { return *static_cast<const FrameLighting*>(state); }

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const FrameLighting& lighting = lighting_of(state);
  return stage_next(lighting.parts[k_room], level, unit) || stage_next(lighting.parts[k_network], level, unit);
}

void run(void* state, uint32_t level) {
  FrameLighting& lighting = lighting_of(state);
  WorkUnit unit;
  for (Stage& part : lighting.parts)
    if (stage_next(part, level, &unit)) return part.run(part.state, level);
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const FrameLighting& lighting = lighting_of(state);
  const uint32_t count = stage_forecast(lighting.parts[k_room], level, entries);
  return count + stage_forecast(lighting.parts[k_network], level, entries + count);
}

}  // namespace

Stage lighting_stage(FrameLighting* lighting, const sandglass_camera_image* image, const char** refused) {
  sandglass_room* room = lighting->room;
  if (room == nullptr && lighting->estimator == nullptr) return stage_without_work(k_lighting_stage_kinds);
  lighting->parts[k_room] =
      room == nullptr ? stage_without_work(k_room_kinds) : room->functions->begin_frame(room, image, refused);
  lighting->parts[k_network] = estimator_stage(lighting->estimator, image, refused);
  assign_kinds(lighting->parts, 2);
  const Stage& network = lighting->parts[k_network];
  const uint32_t mandatory = lighting->parts[k_room].mandatory_units + network.mandatory_units;
  return {lighting, next, run, forecast, k_lighting_stage_kinds, mandatory, network.share};
}

void lighting_end_frame(const FrameLighting& lighting, sandglass_frame_report* report) {
  if (lighting.room != nullptr) {
    lighting.room->functions->end_frame(lighting.room);
    report->versions.room = lighting.room->version;
  }
  estimator_end_frame(lighting.estimator, report);
}

}  // namespace sandglass

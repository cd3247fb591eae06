// One estimate, unit by unit, and the light's part in a frame.
#include "runtime/light/light.h"

namespace sandglass {
namespace {

constexpr float k_light_share = 0.2f;  // of the optional time, while a later stage has work

bool due(const Light& light, uint64_t time_ns) {
  if (time_ns == 0 || light.estimates == 0 || time_ns < light.taken_ns) return true;  // no clock, or one that restarted
  return time_ns != light.taken_ns && time_ns - light.taken_ns >= light.interval_ns;
}

void drop_image(Light* light) {
  for (const uint8_t*& plane : light->image.planes) plane = nullptr;
}

void finish(Light* light) {
  LightOutputs out;
  finish_light_network(*light->network, &out);
  double camera[3];
  for (int i = 0; i < 3; ++i) {
    camera[i] = static_cast<double>(out.direction[i]);
    light->latest.levels[k_sample_light + i] = static_cast<double>(out.light[i]);
    light->latest.levels[k_sample_ambient + i] = static_cast<double>(out.ambient[i]);
  }
  light->latest.levels[k_sample_contrast] = static_cast<double>(out.contrast);
  camera_to_world(light->image, camera, light->latest.direction);
  light->latest_ns = light->image.timestamp_ns;
  light->estimate_frame = light->image_frame;
  ++light->estimates;
  if (light_filter_take(&light->filter, light->latest, light->latest_ns)) {
    light->changed_ns = light->latest_ns;
    light->changed = true;
  }
  light->phase = LightPhase::idle;
}

}  // namespace

bool light_take_image(Light* light, const sandglass_camera_image& image) {
  if (light->phase != LightPhase::idle || !due(*light, image.timestamp_ns)) return false;
  light->phase = LightPhase::image;
  light->cursor = 0;
  light->image = with_turn(image);
  light->blocks = camera_blocks(light->image);
  light->image_frame = light->frame;
  return true;
}

uint32_t light_image_units_left(const Light& light) { return light.blocks.count - light.cursor; }

void light_run_image(Light* light) {
  const CameraBlock block = camera_block(light->image, light->blocks, light->cursor);
  resample_camera_block(light->image, block, light->rgb, light->sums);
  if (++light->cursor < light->blocks.count) return;
  drop_image(light);
  light->taken_ns = light->image.timestamp_ns;
  light->phase = LightPhase::network;
  light->cursor = 0;
  begin_light_network(light->network, light->rgb);
}

bool light_next_unit(const sandglass_light* owner, WorkUnit* unit) {
  const Light& light = owner->light;
  if (light.phase == LightPhase::idle) return false;
  if (light.phase == LightPhase::image) {
    *unit = {k_light_stage_image, static_cast<uint32_t>(light.blocks.bytes / 256 + 1), "light.image"};
    return true;
  }
  *unit = light_unit(*light.network, light.cursor);
  unit->kind += k_light_stage_network;
  return true;
}

void light_run_unit(sandglass_light* owner) {
  Light* light = &owner->light;
  if (light->phase == LightPhase::image) return light_run_image(light);
  run_light_unit(light->network, light->cursor);
  if (++light->cursor == light->network->units) finish(light);
}

void light_reset(Light* light) {
  light_filter_reset(&light->filter);
  drop_image(light);
  light->phase = LightPhase::idle;
  light->cursor = 0;
  light->latest = light->filter.state;
  light->latest_ns = light->changed_ns = light->taken_ns = 0;
  light->estimates = 0;
  light->frame = light->image_frame = light->estimate_frame = 0;
  light->changed = false;
}

namespace {

bool next(const void* state, uint32_t, WorkUnit* unit) {
  return light_next_unit(static_cast<const sandglass_light*>(state), unit);
}

void run(void* state, uint32_t) { light_run_unit(static_cast<sandglass_light*>(state)); }

// The image counts whole: it must be resampled in this frame. The network may take several frames. Its units are all
// forecast as the next one, which is close enough: the stage's share bounds what they get.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const sandglass_light* owner = static_cast<const sandglass_light*>(state);
  const Light& light = owner->light;
  WorkUnit unit;
  if (!light_next_unit(owner, &unit)) return 0;
  uint32_t count = 0;
  if (light.phase == LightPhase::image) {
    entries[count++] = {unit.kind, uint64_t{unit.items} * light_image_units_left(light)};
    unit = light_unit(*light.network, 0);
    unit.kind += k_light_stage_network;
  }
  const uint32_t done = light.phase == LightPhase::image ? 0 : light.cursor;
  entries[count++] = {unit.kind, uint64_t{unit.items} * (light.network->units - done), true};
  return count;
}

Stage begin_frame(sandglass_light* owner, const sandglass_camera_image* image, const char** refused) {
  Light* light = &owner->light;
  ++light->frame;
  light->changed = false;
  bool taken = false;
  if (image != nullptr) {
    const char* reason = nullptr;
    if (check_camera_image(image, &reason) != SANDGLASS_OK) *refused = reason;
    else taken = light_take_image(light, *image);
  }
  const uint32_t mandatory = taken ? 1 + light_image_units_left(*light) : 1;
  return {owner, next, run, forecast, k_light_stage_kinds, mandatory, k_light_share};
}

void end_frame(sandglass_light* owner, sandglass_frame_report* report) {
  Light* light = &owner->light;
  if (light->phase == LightPhase::image) {
    drop_image(light);
    light->phase = LightPhase::idle;
  }
  report->estimate.valid = light->filter.accepted != 0 ? 1 : 0;
  report->estimate.changed = light->changed ? 1 : 0;
  report->estimate.frames_behind =
      light->estimates != 0 ? static_cast<uint32_t>(light->frame - light->estimate_frame) : 0;
  report->estimate.units_left = sandglass_light_units_left(owner);
}

}  // namespace

extern const LightFunctions k_light_functions = {begin_frame, end_frame};

}  // namespace sandglass

// One estimate, unit by unit, and the estimator's part in a frame.
#include "runtime/light/camera/transfer.h"
#include "runtime/light/network/estimator.h"

namespace sandglass {
namespace {

bool due(const Estimator& estimator, uint64_t time_ns) {
  if (time_ns == 0 || estimator.estimates == 0 || time_ns < estimator.taken_ns)
    return true;  // no clock, or one that restarted
  return time_ns != estimator.taken_ns && time_ns - estimator.taken_ns >= estimator.interval_ns;
}

void drop_image(Estimator* estimator) {
  for (const uint8_t*& plane : estimator->image.planes) plane = nullptr;
}

void finish(Estimator* estimator) {
  LightOutputs out;
  finish_light_network(*estimator->network, &out);
  double camera[3];
  for (int i = 0; i < 3; ++i) {
    camera[i] = static_cast<double>(out.direction[i]);
    estimator->latest.levels[k_sample_light + i] = static_cast<double>(out.light[i]);
    estimator->latest.levels[k_sample_ambient + i] = static_cast<double>(out.ambient[i]);
  }
  estimator->latest.levels[k_sample_contrast] = static_cast<double>(out.contrast);
  camera_to_world(estimator->image, camera, estimator->latest.direction);
  estimator->latest_ns = estimator->image.timestamp_ns;
  estimator->estimate_frame = estimator->image_frame;
  ++estimator->estimates;
  const LightSample before = estimator->filter.state;
  if (light_filter_take(&estimator->filter, estimator->latest, estimator->latest_ns)) {
    estimator->changed_ns = estimator->latest_ns;
    estimator->changed = true;
    const LightSample& now = estimator->filter.state;
    bool same = true;
    for (uint32_t i = 0; i < 3; ++i) same = same && now.direction[i] == before.direction[i];
    for (uint32_t i = 0; i < k_sample_levels; ++i) same = same && now.levels[i] == before.levels[i];
    if (!same) ++estimator->version;
  }
  estimator->phase = EstimatorPhase::idle;
}

}  // namespace

bool estimator_take_image(Estimator* estimator, const sandglass_camera_image& image) {
  if (estimator->phase != EstimatorPhase::idle || !due(*estimator, image.timestamp_ns)) return false;
  estimator->phase = EstimatorPhase::image;
  estimator->cursor = 0;
  estimator->image = with_turn(image, estimator->turn_deg);
  estimator->turn_deg = estimator->image.turn_deg;
  estimator->blocks = camera_blocks(estimator->image);
  estimator->image_frame = estimator->frame;
  return true;
}

uint32_t estimator_image_units_left(const Estimator& estimator) { return estimator.blocks.count - estimator.cursor; }

void estimator_run_image(Estimator* estimator) {
  const CameraBlock block = camera_block(estimator->image, estimator->blocks, estimator->cursor);
  resample_camera_block(estimator->image, block, estimator->rgb, estimator->sums);
  if (++estimator->cursor < estimator->blocks.count) return;
  camera_to_srgb(estimator->image, estimator->rgb, 3 * k_light_width * k_light_height);
  drop_image(estimator);
  estimator->taken_ns = estimator->image.timestamp_ns;
  estimator->phase = EstimatorPhase::network;
  estimator->cursor = 0;
  begin_light_network(estimator->network, estimator->rgb);
}

void estimator_reset(Estimator* estimator) {
  light_filter_reset(&estimator->filter);
  drop_image(estimator);
  estimator->phase = EstimatorPhase::idle;
  estimator->cursor = 0;
  estimator->turn_deg = SANDGLASS_TURN_FROM_POSE;
  estimator->latest = estimator->filter.state;
  estimator->latest_ns = estimator->changed_ns = estimator->taken_ns = 0;
  estimator->estimates = 0;
  estimator->frame = estimator->image_frame = estimator->estimate_frame = 0;
  estimator->changed = false;
  ++estimator->version;
}

namespace {

bool next(const void* handle, uint32_t, WorkUnit* unit) {
  const Estimator& estimator = static_cast<const sandglass_estimator*>(handle)->estimator;
  if (estimator.phase == EstimatorPhase::idle) return false;
  if (estimator.phase == EstimatorPhase::image) {
    *unit = {k_estimator_stage_image, static_cast<uint32_t>(estimator.blocks.bytes / 256 + 1), "light.image"};
    return true;
  }
  *unit = light_unit(*estimator.network, estimator.cursor);
  unit->kind += k_estimator_stage_network;
  return true;
}

void run(void* handle, uint32_t) {
  Estimator* estimator = &static_cast<sandglass_estimator*>(handle)->estimator;
  if (estimator->phase == EstimatorPhase::image) return estimator_run_image(estimator);
  run_light_unit(estimator->network, estimator->cursor);
  if (++estimator->cursor == estimator->network->units) finish(estimator);
}

// The image counts whole: it must be resampled in this frame. The network may take several frames. Its units are all
// forecast as the next one, which is close enough: the stage's share bounds what they get.
uint32_t forecast(const void* handle, uint32_t level, Forecast* entries) {
  const Estimator& estimator = static_cast<const sandglass_estimator*>(handle)->estimator;
  WorkUnit unit;
  if (!next(handle, level, &unit)) return 0;
  uint32_t count = 0;
  if (estimator.phase == EstimatorPhase::image) {
    entries[count++] = {unit.kind, uint64_t{unit.items} * estimator_image_units_left(estimator)};
    unit = light_unit(*estimator.network, 0);
    unit.kind += k_estimator_stage_network;
  }
  const uint32_t done = estimator.phase == EstimatorPhase::image ? 0 : estimator.cursor;
  entries[count++] = {unit.kind, uint64_t{unit.items} * (estimator.network->units - done), true};
  return count;
}

bool under_way(const void* handle) {
  return static_cast<const sandglass_estimator*>(handle)->estimator.phase != EstimatorPhase::idle;
}

// The units of an image that is taken must run: its planes belong to the app.
uint32_t begin_frame(void* handle, const FrameView& view) {
  Estimator* estimator = &static_cast<sandglass_estimator*>(handle)->estimator;
  const sandglass_camera_image* image = view.input->camera;
  ++estimator->frame;
  estimator->changed = false;
  if (image == nullptr) return 1;
  const char* reason = nullptr;
  if (sandglass_camera_check(image, &reason) != SANDGLASS_OK) *view.refused = reason;
  else if (estimator_take_image(estimator, *image)) return 1 + estimator_image_units_left(*estimator);
  return 1;
}

void end_frame(void* handle, sandglass_frame_report* report) {
  Estimator* estimator = &static_cast<sandglass_estimator*>(handle)->estimator;
  if (estimator->phase == EstimatorPhase::image) {
    drop_image(estimator);
    estimator->phase = EstimatorPhase::idle;
  }
  report->versions.estimator = estimator->version;
  report->estimator.valid = estimator->filter.accepted != 0 ? 1 : 0;
  report->estimator.changed = estimator->changed ? 1 : 0;
  report->estimator.frames_behind =
      estimator->estimates != 0 ? static_cast<uint32_t>(estimator->frame - estimator->estimate_frame) : 0;
  report->estimator.units_left = sandglass_estimator_units_left(static_cast<sandglass_estimator*>(handle));
}

}  // namespace

extern const Capability k_estimator_capability = {.begin_frame = begin_frame,
                                                  .next = next,
                                                  .run = run,
                                                  .forecast = forecast,
                                                  .under_way = under_way,
                                                  .end_frame = end_frame};

}  // namespace sandglass

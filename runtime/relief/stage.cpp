// A relief's part in a frame: which image it takes, and the units of one, or of meshes.
#include "runtime/frame/capability.h"
#include "runtime/math/finite.h"
#include "runtime/math/turn.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr float k_limit = SANDGLASS_COORDINATE_LIMIT;

bool is_short(int32_t stride, uint64_t row) {
  const int64_t bytes = static_cast<int64_t>(row);
  return stride < bytes && stride > -bytes;
}

}  // namespace

const char* relief_fault(const sandglass_depth_image& image) {
  if (image.struct_size != sizeof image)
    return "depth.struct_size is not that of this library: start from sandglass_depth_image_default.";
  if (image.format != SANDGLASS_DEPTH_U16 && image.format != SANDGLASS_DEPTH_F32)
    return "depth.format is unknown: give one of sandglass_depth_format.";
  if (image.width < 2 || image.height < 2 || image.width > SANDGLASS_CAMERA_SIDE_LIMIT ||
      image.height > SANDGLASS_CAMERA_SIDE_LIMIT)
    return "depth.width or height is not in 2..16384 pixels.";
  if (image.depth == nullptr) return "depth.depth is NULL: pass the pixels.";
  const uint64_t pixel = image.format == SANDGLASS_DEPTH_U16 ? 2 : 4;
  if (is_short(image.stride, image.width * pixel) ||
      (image.confidence != nullptr && is_short(image.confidence_stride, image.width)) ||
      (image.mask != nullptr && is_short(image.mask_stride, image.width)))
    return "depth.stride, confidence_stride or mask_stride is shorter than a row: it is bytes from row to row.";
  if (!within(image.to_metres, 1e-6f, 1e3f)) return "depth.to_metres is not in 1e-6..1e3.";
  if (!within(image.focal_x, 1.0f, 1e6f) || !within(image.focal_y, 1.0f, 1e6f) ||
      !within(image.centre_x, 0.0f, static_cast<float>(image.width - 1)) ||
      !within(image.centre_y, 0.0f, static_cast<float>(image.height - 1)))
    return "depth.focal_x, focal_y, centre_x or centre_y is out of range: pass the depth image's own, in pixels.";
  Rotation turn = {};
  if (!all_within(image.position, 3, -k_limit, k_limit) || !rotation_of(image.orientation, &turn))
    return "depth.position or orientation is no pose: pass that of the depth camera.";
  return nullptr;
}

bool relief_take(ReliefState* relief, const sandglass_depth_image& image) {
  if (!relief_idle(*relief) || (image.timestamp_ns != 0 && image.timestamp_ns == relief->last_ns)) return false;
  ReliefView* view = &relief->view;
  *view = {};
  view->image = image;
  relief->last_ns = image.timestamp_ns;
  do {
    ++view->step;
    view->width = image.width / view->step;
    view->height = image.height / view->step;
  } while (relief_samples(*view) > k_relief_samples);
  Rotation plane = {}, camera = {};
  rotation_of(relief->rotation, &plane);
  rotation_of(image.orientation, &camera);
  for (int k = 0; k < 3; ++k) {
    double place = 0, ahead = 0, right = 0, down = 0;
    for (int j = 0; j < 3; ++j) {
      place += plane.m[j][k] * (static_cast<double>(image.position[j]) - static_cast<double>(relief->position[j]));
      right += plane.m[j][k] * camera.m[j][0];
      down -= plane.m[j][k] * camera.m[j][1];
      ahead -= plane.m[j][k] * camera.m[j][2];
    }
    view->position[k] = static_cast<float>(place);
    view->ahead[k] = static_cast<float>(ahead);
    view->right[k] = static_cast<float>(right / static_cast<double>(image.focal_x));
    view->down[k] = static_cast<float>(down / static_cast<double>(image.focal_y));
  }
  relief->phase = ReliefPhase::read;
  relief->cursor = 0;
  return true;
}

namespace {

uint32_t begin_frame(void* handle, const FrameView& view) {
  ReliefState* relief = &static_cast<sandglass_relief*>(handle)->relief;
  if (view.input->depth == nullptr) return 0;
  if (const char* fault = relief_fault(*view.input->depth)) {
    *view.refused = fault;
    return 0;
  }
  if (!relief_take(relief, *view.input->depth)) return 0;
  return (relief_samples(relief->view) + k_relief_unit_samples - 1) / k_relief_unit_samples;
}

void end_frame(void* handle, sandglass_frame_report*) {
  ReliefState* relief = &static_cast<sandglass_relief*>(handle)->relief;
  // A frame that ends early, by a broken clock or a plan, leaves an image half read. It is dropped, because its pixels
  // belong to the app.
  if (relief->phase == ReliefPhase::read) relief->phase = ReliefPhase::idle;
}

// What the next unit is of: where nothing is under way, of meshes that are due.
ReliefPhase phase_next(const ReliefState& relief) {
  return relief.phase == ReliefPhase::idle && relief.raised.due ? ReliefPhase::raise : relief.phase;
}

// A phase's items, and how many of them a unit takes.
uint32_t phase_items(const ReliefState& relief, ReliefPhase phase) {
  if (phase == ReliefPhase::raise) return relief_raise_items(relief);
  return phase <= ReliefPhase::gather ? relief_samples(relief.view) : relief_cells(relief);
}
uint32_t phase_unit(ReliefPhase phase) {
  if (phase == ReliefPhase::raise) return k_relief_unit_triangles;
  return phase <= ReliefPhase::gather ? k_relief_unit_samples : k_relief_unit_cells;
}

constexpr const char* k_units[] = {"relief.read",   "relief.gather", "relief.look",
                                   "relief.commit", "relief.raise",  "relief.settle"};

bool next(const void* handle, uint32_t, WorkUnit* unit) {
  const ReliefState& relief = static_cast<const sandglass_relief*>(handle)->relief;
  const ReliefPhase phase = phase_next(relief);
  if (phase == ReliefPhase::idle) return false;
  const uint32_t kind = static_cast<uint32_t>(phase) - 1;
  *unit = {kind, phase_unit(phase), k_units[kind]};
  return true;
}

void run(void* handle, uint32_t) { relief_run_unit(&static_cast<sandglass_relief*>(handle)->relief); }

uint32_t forecast(const void* handle, uint32_t, Forecast* entries) {
  const ReliefState& relief = static_cast<const sandglass_relief*>(handle)->relief;
  const ReliefPhase first = phase_next(relief);
  if (first == ReliefPhase::idle) return 0;
  const auto last = first <= ReliefPhase::commit ? ReliefPhase::commit : ReliefPhase::settle;
  uint32_t count = 0;
  for (auto phase = static_cast<uint32_t>(first); phase <= static_cast<uint32_t>(last); ++phase) {
    const uint32_t items = phase_items(relief, static_cast<ReliefPhase>(phase)),
                   done = phase == static_cast<uint32_t>(first) ? relief.cursor : 0;
    entries[count++] = {phase - 1, items - done, true};
  }
  return count;
}

bool under_way(const void* handle) {
  return static_cast<const sandglass_relief*>(handle)->relief.phase != ReliefPhase::idle;
}

void begin_version(ReliefState* relief, ReliefPhase phase) {
  relief->phase = phase;
  relief->changing = k_relief_no_cells;
}

void end_version(ReliefState* relief) {
  relief->phase = ReliefPhase::idle;
  relief_end_version(relief);
}

}  // namespace

void relief_run_unit(ReliefState* relief) {
  if (relief->phase == ReliefPhase::idle && relief->raised.due) relief_begin_raise(relief);
  if (relief->phase == ReliefPhase::raise) {
    if (relief_raise(relief)) begin_version(relief, ReliefPhase::settle);
    return;
  }
  const uint32_t items = phase_items(*relief, relief->phase), each = phase_unit(relief->phase), first = relief->cursor;
  const uint32_t end = items - first > each ? first + each : items;
  relief->cursor = end < items ? end : 0;
  const bool last = end == items;
  switch (relief->phase) {
    case ReliefPhase::idle:
    case ReliefPhase::raise:
      return;
    case ReliefPhase::read:
      relief_read(&relief->view, *relief, first, end);
      if (!last) return;
      relief_find_scale(relief);
      relief->view.image.depth = relief->view.image.confidence = relief->view.image.mask = nullptr;
      relief->phase = ReliefPhase::gather;
      return;
    case ReliefPhase::gather:
      relief_gather(*relief, first, end);
      if (last) relief->phase = ReliefPhase::look;
      return;
    case ReliefPhase::look:
      relief_look(*relief, first, end);
      if (last) begin_version(relief, ReliefPhase::commit);
      return;
    case ReliefPhase::commit:
      relief_commit(relief, first, end);
      relief_end_change(relief);
      if (last) end_version(relief);
      return;
    case ReliefPhase::settle:
      relief_settle(relief, first, end);
      relief_end_change(relief);
      if (last) end_version(relief);
      return;
  }
}

extern const Capability k_relief_capability = {.begin_frame = begin_frame,
                                               .next = next,
                                               .run = run,
                                               .forecast = forecast,
                                               .under_way = under_way,
                                               .end_frame = end_frame};

}  // namespace sandglass

// The state behind the C API of sandglass/light.h, and its work in units that a frame can hand out (core/governor.h).
//
// One estimate at a time. The image is resampled whole, in the frame that brought it, because its planes belong to the
// app. Then the network runs, unit by unit, over as many frames as it takes. Its answer is turned into the world by the
// pose of that image and goes through the filter.
#pragma once

#include <cstdint>

#include "runtime/light/camera_image.h"
#include "runtime/light/filter.h"
#include "runtime/light/network.h"

namespace sandglass {

// Kinds of work unit: the image, then the network's.
enum : uint32_t {
  k_light_stage_image,
  k_light_stage_network,
  k_light_stage_kinds = k_light_stage_network + k_light_kinds
};

enum class LightPhase : uint32_t { idle, image, network };

struct Light {
  LightNetwork* network;
  LightFilter filter;
  uint64_t interval_ns;
  LightPhase phase;
  uint32_t cursor;      // next block of the image, or unit of the network
  CameraImage image;    // the one under way; its planes are NULL once it is resampled
  CameraBlocks blocks;  // the units of that image
  uint8_t* rgb;         // the image as the network sees it
  uint32_t* sums;       // scratch of the resampling
  // Estimates.
  LightSample latest;  // before the filter, in the world
  uint64_t latest_ns, changed_ns, taken_ns;
  uint32_t estimates;
  uint64_t frame;           // number of this frame
  uint64_t image_frame;     // of the frame that brought the image under way
  uint64_t estimate_frame;  // of the frame that brought the image of the last estimate
  bool changed;             // the filtered light changed in this frame
};

// Forgets every estimate and the image under way.
void light_reset(Light* light);

// Takes an image that has passed sandglass_camera_check, if one is due. Returns whether it did.
bool light_take_image(Light* light, const sandglass_camera_image& image);

// The image under way: its next unit, and how many are left.
void light_run_image(Light* light);
uint32_t light_image_units_left(const Light& light);

// The next unit of the estimate under way, if there is one, and what runs it.
bool light_next_unit(const sandglass_light* light, WorkUnit* unit);
void light_run_unit(sandglass_light* light);

// Creation leaves this table in every light, and the scene calls through it. So the linker drops the light from an app
// that never creates one.
struct LightFunctions {
  // See light_stage and light_end_frame.
  Stage (*begin_frame)(sandglass_light* light, const sandglass_camera_image* image, const char** refused);
  void (*end_frame)(sandglass_light* light, sandglass_frame_report* report);
};
extern const LightFunctions k_light_functions;

}  // namespace sandglass

struct sandglass_light {
  const sandglass::LightFunctions* functions;
  sandglass::Light light;
};

namespace sandglass {

// The light's stage of this frame. Takes the frame's image where it is due; the units of that image are then
// mandatory, because its planes belong to the app. *refused says what is wrong with an image that cannot be used, and
// is left alone otherwise. `light` may be NULL.
inline Stage light_stage(sandglass_light* light, const sandglass_camera_image* image, const char** refused) {
  return light == nullptr ? stage_without_work(k_light_stage_kinds)
                          : light->functions->begin_frame(light, image, refused);
}

// Drops an image that was not finished and fills in the light's part of the report.
inline void light_end_frame(sandglass_light* light, sandglass_frame_report* report) {
  if (light != nullptr) light->functions->end_frame(light, report);
}

}  // namespace sandglass

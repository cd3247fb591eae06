// The state behind the C API of sandglass/estimator.h, and its work in units that a frame can hand out (frame/governor.h).
//
// One estimate at a time. The image is resampled whole, in the frame that brought it, because its planes belong to the
// app. Then the network runs, unit by unit, over as many frames as it takes. Its answer is turned into the world by the
// pose of that image and goes through the filter.
#pragma once

#include <cstdint>

#include "runtime/frame/capability.h"
#include "runtime/light/network/filter.h"
#include "runtime/light/network/network.h"
#include "runtime/light/network/resample.h"

namespace sandglass {

// Kinds of work unit: the image, then the network's.
enum : uint32_t { k_estimator_stage_image, k_estimator_stage_network };
static_assert(uint32_t{k_estimator_stage_network} + k_light_kinds == k_estimator_kinds);

enum class EstimatorPhase : uint32_t { idle, image, network };

struct Estimator {
  LightNetwork* network;
  LightFilter filter;
  uint64_t interval_ns;
  EstimatorPhase phase;
  uint32_t cursor;      // next block of the image, or unit of the network
  CameraImage image;    // the one under way; its planes are NULL once it is resampled
  uint32_t turn_deg;    // of the last image
  CameraBlocks blocks;  // the units of that image
  uint8_t* rgb;         // the image as the network sees it
  uint32_t* sums;       // scratch of the resampling
  // Estimates.
  uint64_t version;
  LightSample latest;  // before the filter, in the world
  uint64_t latest_ns, changed_ns, taken_ns;
  uint32_t estimates;
  // Numbers of frames: this one; the one that brought the image under way; the one that brought the last estimate's
  // image.
  uint64_t frame;
  uint64_t image_frame;
  uint64_t estimate_frame;
  bool changed;  // the filtered light changed in this frame
};

// Forgets every estimate and the image under way.
void estimator_reset(Estimator* estimator);

// Takes an image that has passed sandglass_camera_check, if one is due. Returns whether it did.
bool estimator_take_image(Estimator* estimator, const sandglass_camera_image& image);

// The image under way: its next unit, and how many are left.
void estimator_run_image(Estimator* estimator);
uint32_t estimator_image_units_left(const Estimator& estimator);

extern const Capability k_estimator_capability;

}  // namespace sandglass

struct sandglass_estimator {
  sandglass::Member member;
  sandglass::Estimator estimator;
};

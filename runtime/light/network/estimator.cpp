// The C API around an Estimator: checks, layout, and what an estimate looks like from outside. Its units are in estimator_stage.cpp.
#include "runtime/light/network/estimator.h"

#include <cstring>

#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/light/network/backends.h"
#include "runtime/light/network/radiometry.h"
#include "runtime/math/hash.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {
namespace {

constexpr uint64_t k_rgb_bytes = 3 * k_light_width * k_light_height;

// What a description and its asset say, and where the network and an image go.
struct Maker {
  using Desc = sandglass_estimator_desc;
  using Handle = sandglass_estimator;
  LightAsset asset;
  const Int8Kernels* kernels;
  const LightBackend* backend;
  LightMemory network;
  uint8_t* rgb;
  uint32_t* sums;
  sandglass_status check(const sandglass_estimator_desc& desc, const char** reason);
  sandglass_estimator* lay_out(const sandglass_estimator_desc& desc, Layout* layout);
  sandglass_status build(const sandglass_estimator_desc& desc, sandglass_estimator* handle, const char** reason) const;
};

sandglass_status Maker::check(const sandglass_estimator_desc& desc, const char** reason) {
  if (!(desc.interval >= 0 && desc.interval <= 60)) return refuse(reason, "desc.interval is not in 0..60 seconds.");
  if (!(desc.smoothing >= 0 && desc.smoothing <= 60)) return refuse(reason, "desc.smoothing is not in 0..60 seconds.");
  if (!(desc.turn_limit > 0 && desc.turn_limit <= 1e6f))
    return refuse(reason, "desc.turn_limit is not above 0 and at most 1e6 radians a second.");
  if (!(desc.outlier_angle >= 0 && desc.outlier_angle <= 3.1416f))
    return refuse(reason, "desc.outlier_angle is not in 0..pi.");
  if (!(desc.outlier_level >= 0 && desc.outlier_level <= 2))
    return refuse(reason, "desc.outlier_level is not in 0..2.");
  if (!find_light_backend(desc.backend, &backend, reason)) return SANDGLASS_ERROR_UNSUPPORTED;
  kernels = select_light_kernels(desc.isa);
  if (kernels == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not in this build or on this CPU: use SANDGLASS_ISA_AUTOMATIC.");
  return open_light_asset(desc.asset, desc.asset_bytes, &asset, reason);
}

// The one walk: counts the bytes, or hands out the regions.
sandglass_estimator* Maker::lay_out(const sandglass_estimator_desc&, Layout* layout) {
  auto* handle = layout_region<sandglass_estimator>(layout, "estimator", 1);
  network = layout_light_network(k_light_width, k_light_height, layout, backend);
  rgb = layout_region<uint8_t>(layout, "estimator.image", k_rgb_bytes);
  sums = layout_region<uint32_t>(layout, "estimator.sums", k_camera_sums);
  return handle;
}

sandglass_status Maker::build(const sandglass_estimator_desc& desc, sandglass_estimator* handle,
                              const char** reason) const {
  *handle = {};
  handle->member.capability = &k_estimator_capability;
  Estimator* l = &handle->estimator;
  l->network = create_light_network(asset, kernels, backend, k_light_width, k_light_height, network, reason);
  if (l->network == nullptr) return SANDGLASS_ERROR_UNSUPPORTED;  // the back end cannot be had
  l->rgb = rgb;
  l->sums = sums;
  const double interval = static_cast<double>(desc.interval);
  l->interval_ns = to_whole<uint64_t>(interval * 1e9);
  l->filter.law = {static_cast<double>(desc.smoothing), interval, static_cast<double>(desc.turn_limit),
                   static_cast<double>(desc.outlier_angle), static_cast<double>(desc.outlier_level)};
  estimator_reset(l);
  return accept(reason);
}

void describe(const Estimator& estimator, const LightSample& sample, uint64_t timestamp_ns,
              sandglass_estimator_light* out) {
  sandglass_estimator_light estimate = {};
  estimate.valid = estimator.filter.accepted != 0 ? 1 : 0;
  estimate.timestamp_ns = timestamp_ns;
  estimate.image_ns = estimator.latest_ns;
  for (int i = 0; i < 3; ++i) {
    estimate.direction[i] = static_cast<float>(sample.direction[i]);
    estimate.light[i] = static_cast<float>(sample.levels[k_sample_light + i]);
    estimate.ambient[i] = static_cast<float>(sample.levels[k_sample_ambient + i]);
  }
  estimate.contrast = static_cast<float>(sample.levels[k_sample_contrast]);
  if (estimate.valid == 0)
    for (int i = 0; i < 3; ++i) estimate.ambient[i] = 0.5f;
  estimate.strength =
      static_cast<float>(light_strength(sample.direction, sample.levels + k_sample_light,
                                        sample.levels + k_sample_ambient, sample.levels[k_sample_contrast]));
  estimate.confidence = static_cast<float>(light_filter_confidence(estimator.filter));
  estimate.estimates = estimator.estimates;
  estimate.deviation = static_cast<float>(angle_between(estimator.latest.direction, sample.direction));
  estimate.rejected = estimator.filter.rejected;
  double sh[3 * k_harmonics];
  estimate_harmonics(estimate, sh);
  for (uint32_t i = 0; i < 3 * k_harmonics; ++i) estimate.sh[i] = static_cast<float>(sh[i]);
  fill_struct(&estimate, sizeof estimate, out);
}

__attribute__((noinline)) void resample_now(Estimator* estimator) {
  while (estimator->phase == EstimatorPhase::image) estimator_run_image(estimator);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_estimator_desc_default(sandglass_estimator_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->interval = 0.25f;
  desc->smoothing = 0.4f;
  desc->turn_limit = 2.0943951f;
  desc->outlier_angle = 0.6981317f;
  desc->outlier_level = 0.35f;
}

sandglass_status sandglass_estimator_inspect(const void* asset, uint64_t asset_bytes, sandglass_estimator_info* info,
                                             const char** reason) {
  if (info == nullptr || !can_fill(info))
    return refuse(reason, "info is NULL or its struct_size is not set: set it to sizeof(sandglass_estimator_info).");
  LightAsset file;
  if (const sandglass_status status = open_light_asset(asset, asset_bytes, &file, reason)) return status;
  sandglass_estimator_info filled = {};
  filled.training_images = file.training_images;
  filled.calibration_images = file.calibration_images;
  filled.angle_deg = file.angle_deg;
  filled.difference = file.difference;
  filled.data_hash = file.data_hash;
  filled.seed = file.seed;
  fill_struct(&filled, sizeof filled, info);
  return SANDGLASS_OK;
}

sandglass_status sandglass_estimator_bytes(const sandglass_estimator_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_estimator_create(const sandglass_estimator_desc* desc, void* block, uint64_t bytes,
                                            sandglass_estimator** estimator, const char** reason) {
  return create_in<Maker>(desc, block, bytes, estimator, "estimator is NULL: pass where to store it.", reason);
}

void sandglass_estimator_release(sandglass_estimator* estimator) {
  if (estimator != nullptr) release_light_network(estimator->estimator.network);
}

void sandglass_estimator_reset(sandglass_estimator* estimator) {
  if (estimator != nullptr) estimator_reset(&estimator->estimator);
}

sandglass_status sandglass_estimator_turn(sandglass_estimator* estimator, const float rotation[4],
                                          const char** reason) {
  if (estimator == nullptr || rotation == nullptr)
    return refuse(reason, "estimator or rotation is NULL: pass the estimator and a quaternion (x, y, z, w).");
  Rotation turn = {};
  if (!rotation_of(rotation, &turn))
    return refuse(reason, "rotation is not finite or has no length: pass a quaternion (x, y, z, w).");
  const ExactFloatingPoint exact;
  light_filter_turn(&estimator->estimator.filter, turn.m);
  double turned[3];
  rotate(turn, estimator->estimator.latest.direction, turned);
  for (int i = 0; i < 3; ++i) estimator->estimator.latest.direction[i] = turned[i];
  // The image under way was taken in the world as it was: its pose turns too.
  turn_further(rotation, estimator->estimator.image.orientation);
  return accept(reason);
}

sandglass_status sandglass_estimator_set_image(sandglass_estimator* estimator, const sandglass_camera_image* image,
                                               int32_t* taken, const char** reason) {
  if (estimator == nullptr)
    return refuse(reason, "estimator is NULL: pass the estimator that sandglass_estimator_create made.");
  if (const sandglass_status status = sandglass_camera_check(image, reason)) return status;
  const ExactFloatingPoint exact;
  const bool took = estimator_take_image(&estimator->estimator, *image);
  if (took) resample_now(&estimator->estimator);
  if (taken != nullptr) *taken = took ? 1 : 0;
  return accept(reason);
}

uint32_t sandglass_estimator_run(sandglass_estimator* estimator, uint32_t units) {
  if (estimator == nullptr) return 0;
  const ExactFloatingPoint exact;
  return run_members(member_of(estimator, k_estimator_kinds), units);
}

uint32_t sandglass_estimator_units_left(const sandglass_estimator* estimator) {
  if (estimator == nullptr) return 0;
  const Estimator& l = estimator->estimator;
  if (l.phase == EstimatorPhase::idle) return 0;
  return l.phase == EstimatorPhase::network ? l.network->units - l.cursor
                                            : estimator_image_units_left(l) + l.network->units;
}

void sandglass_estimator_get(const sandglass_estimator* estimator, sandglass_estimator_light* estimate) {
  if (estimator == nullptr || estimate == nullptr) return;
  const ExactFloatingPoint exact;
  describe(estimator->estimator, estimator->estimator.filter.state, estimator->estimator.changed_ns, estimate);
}

void sandglass_estimator_get_latest(const sandglass_estimator* estimator, sandglass_estimator_light* estimate) {
  if (estimator == nullptr || estimate == nullptr) return;
  const ExactFloatingPoint exact;
  describe(estimator->estimator, estimator->estimator.latest, estimator->estimator.latest_ns, estimate);
}

uint64_t sandglass_estimator_hash(const sandglass_estimator* estimator) {
  if (estimator == nullptr) return 0;
  const Estimator& l = estimator->estimator;
  const LightFilter& f = l.filter;
  uint64_t hash = hash_bytes(l.rgb, k_rgb_bytes);
  const LightSample* const samples[3] = {&f.state, &f.outlier, &l.latest};
  for (const LightSample* sample : samples) hash = hash_with(hash, hash_bytes(sample, sizeof *sample));
  hash = hash_with(hash, hash_bytes(&f.agreement, sizeof f.agreement));
  const uint64_t counts[4] = {l.estimates, f.rejected, static_cast<uint64_t>(l.phase), l.cursor};
  return hash_with(hash, hash_bytes(counts, sizeof counts));
}

sandglass_isa sandglass_estimator_isa(const sandglass_estimator* estimator) {
  return estimator == nullptr ? SANDGLASS_ISA_AUTOMATIC : estimator->estimator.network->kernels->isa;
}

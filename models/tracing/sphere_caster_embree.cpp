// The caster over Embree 3's sphere point geometry.
#include <embree3/rtcore.h>

#include <cmath>
#include <vector>

#include "models/tracing/sphere_caster.h"
#include "models/work/failure.h"

namespace sandglass::host {

struct SphereCaster::State {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<uint32_t> source;  // index of each kept sphere
};

const char* SphereCaster::engine() { return "embree"; }

SphereCaster::SphereCaster(std::span<const float> centres, float radius) : state_(std::make_unique<State>()) {
  for (uint32_t i = 0; i < centres.size() / 3; ++i)
    if (std::isfinite(centres[3 * i]) && std::isfinite(centres[3 * i + 1]) && std::isfinite(centres[3 * i + 2]))
      state_->source.push_back(i);
  state_->device = rtcNewDevice(nullptr);
  if (state_->device == nullptr) throw Failure("cannot draw: Embree does not start on this machine. Build without it.");
  state_->scene = rtcNewScene(state_->device);
  if (!state_->source.empty()) {
    RTCGeometry geometry = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    float* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), state_->source.size()));
    for (const uint32_t i : state_->source) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = centres[3 * i + static_cast<uint32_t>(axis)];
      *vertices++ = radius;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(state_->scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(state_->scene);
}

SphereCaster::~SphereCaster() {
  rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}

static RTCRay make_ray(Vec3 origin, Vec3 direction, double limit) {
  RTCRay ray = {};
  ray.org_x = static_cast<float>(origin.x), ray.org_y = static_cast<float>(origin.y),
  ray.org_z = static_cast<float>(origin.z);
  ray.dir_x = static_cast<float>(direction.x), ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.tfar = static_cast<float>(limit);
  ray.mask = ~0u;
  return ray;
}

bool SphereCaster::closest(Vec3 origin, Vec3 direction, SphereHit* hit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query = {};
  query.ray = make_ray(origin, direction, hit->distance);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(state_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->distance = query.ray.tfar;
  hit->index = state_->source[query.hit.primID];
  return true;
}

bool SphereCaster::occluded(Vec3 origin, Vec3 direction, double limit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = make_ray(origin, direction, limit);
  rtcOccluded1(state_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace sandglass::host

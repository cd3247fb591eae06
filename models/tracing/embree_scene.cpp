// See embree_scene.h.
#include "models/tracing/embree_scene.h"

#include <cmath>
#include <cstring>
#include <utility>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

constexpr const char* k_too_large =
    "Embree cannot hold this mesh: it is too large for this machine's memory. Simplify it.";

void* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t stride, size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, stride, count);
  if (buffer != nullptr) return buffer;
  rtcReleaseGeometry(geometry);
  throw Failure(k_too_large);
}

RTCRay embree_ray(Vec3 origin, Vec3 direction, double limit) {
  RTCRay ray = {};
  ray.org_x = static_cast<float>(origin.x);
  ray.org_y = static_cast<float>(origin.y);
  ray.org_z = static_cast<float>(origin.z);
  ray.dir_x = static_cast<float>(direction.x);
  ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.tfar = static_cast<float>(limit);
  ray.mask = ~0u;
  return ray;
}

void attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

EmbreeScene::EmbreeScene(const char* device) : device_(rtcNewDevice(device)) {
  if (device_ == nullptr) throw Failure("Embree does not start on this machine. Build without it to draw pictures.");
  scene_ = rtcNewScene(device_);
}

EmbreeScene::EmbreeScene(EmbreeScene&& other) noexcept
    : device_(std::exchange(other.device_, nullptr)), scene_(std::exchange(other.scene_, nullptr)) {}

EmbreeScene::~EmbreeScene() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

EmbreeScene EmbreeScene::triangles(std::span<const float> vertices, std::span<const uint32_t> indices,
                                   RTCBuildQuality quality) {
  EmbreeScene made("threads=1");
  RTCGeometry geometry = rtcNewGeometry(made.device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::memcpy(new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, vertices.size() / 3), vertices.data(),
              vertices.size_bytes());
  std::memcpy(new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, indices.size() / 3), indices.data(),
              indices.size_bytes());
  rtcSetSceneFlags(made.scene_, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(made.scene_, quality);
  attach(made.scene_, geometry);
  rtcCommitScene(made.scene_);
  return made;
}

EmbreeScene EmbreeScene::spheres(std::span<const float> spheres) {
  EmbreeScene made(nullptr);  // the tree of a pile is built once per picture, on all cores
  if (!spheres.empty()) {
    RTCGeometry geometry = rtcNewGeometry(made.device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    std::memcpy(new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 16, spheres.size() / 4), spheres.data(),
                spheres.size_bytes());
    attach(made.scene_, geometry);
  }
  rtcCommitScene(made.scene_);
  return made;
}

Vec3 EmbreeHit::unit_normal() const {
  const float length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  return length > 0 ? Vec3{normal[0] / length, normal[1] / length, normal[2] / length} : Vec3{};
}

uint32_t EmbreeScene::hidden(double x, double z, const float* direction_x, const float* direction_y,
                             const float* direction_z) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) int valid[k_packet];
  RTCRay16 rays = {};
  for (uint32_t i = 0; i < k_packet; ++i) {
    valid[i] = direction_y[i] > 0 ? -1 : 0;
    rays.org_x[i] = static_cast<float>(x);
    rays.org_z[i] = static_cast<float>(z);
    rays.dir_x[i] = direction_x[i];
    rays.dir_y[i] = direction_y[i];
    rays.dir_z[i] = direction_z[i];
    rays.tnear[i] = 1e-5f;
    rays.tfar[i] = INFINITY;
    rays.mask[i] = ~0u;
  }
  rtcOccluded16(valid, scene_, &context, &rays);
  uint32_t hidden = 0;
  for (uint32_t i = 0; i < k_packet; ++i) hidden |= (rays.tfar[i] < 0 ? 1u : 0u) << i;
  return hidden;
}

EmbreeHit EmbreeScene::closest(Vec3 origin, Vec3 direction, double limit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query = {};
  query.ray = embree_ray(origin, direction, limit);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {true, query.ray.tfar, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, query.hit.primID};
}

bool EmbreeScene::occluded(Vec3 origin, Vec3 direction, double limit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = embree_ray(origin, direction, limit);
  rtcOccluded1(scene_, &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace sandglass::host

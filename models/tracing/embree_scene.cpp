// See embree_scene.h.
#include "models/tracing/embree_scene.h"

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
                                   RTCBuildQuality quality, int flags) {
  EmbreeScene made("threads=1");
  RTCGeometry geometry = rtcNewGeometry(made.device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::memcpy(new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, vertices.size() / 3), vertices.data(),
              vertices.size_bytes());
  std::memcpy(new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, indices.size() / 3), indices.data(),
              indices.size_bytes());
  rtcSetSceneFlags(made.scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));
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

RTCRay embree_ray(const float origin[3], const float direction[3], float nearest, float farthest) {
  RTCRay ray = {};
  ray.org_x = origin[0], ray.org_y = origin[1], ray.org_z = origin[2];
  ray.dir_x = direction[0], ray.dir_y = direction[1], ray.dir_z = direction[2];
  ray.tnear = nearest, ray.tfar = farthest;
  ray.mask = ~0u;
  return ray;
}

EmbreeHit EmbreeScene::closest(const float origin[3], const float direction[3], float nearest, float farthest) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query = {};
  query.ray = embree_ray(origin, direction, nearest, farthest);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {true, query.ray.tfar, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, query.hit.primID};
}

bool EmbreeScene::occluded(const float origin[3], const float direction[3], float nearest, float farthest) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = embree_ray(origin, direction, nearest, farthest);
  rtcOccluded1(scene_, &context, &ray);
  return ray.tfar < 0.0f;
}

EmbreeHit EmbreeScene::closest(Vec3 origin, Vec3 direction, double limit) const {
  float o[3], d[3];
  to_floats(origin, o), to_floats(direction, d);
  return closest(o, d, 0.0f, static_cast<float>(limit));
}

bool EmbreeScene::occluded(Vec3 origin, Vec3 direction, double limit) const {
  float o[3], d[3];
  to_floats(origin, o), to_floats(direction, d);
  return occluded(o, d, 0.0f, static_cast<float>(limit));
}

}  // namespace sandglass::host

// See ray_caster.h.
#include "models/tracing/ray_caster.h"
#include "models/files/failure.h"

#ifdef SANDGLASS_HAVE_EMBREE

#include <cmath>

namespace sandglass::host {
namespace {

constexpr float k_edge_margin = 1e-4f;  // a hit is doubtful with a barycentric coordinate below this
constexpr float k_grazing = 1e-3f;      // a hit is doubtful when the sine of ray and face is below this
constexpr int k_directions = 9;

// Directions that meshes do not favour and that do not lie in one plane. They turn by the golden angle and step in
// height.
void test_direction(int index, float direction[3]) {
  const double y = 1 - (2 * index + 1.37) / k_directions, ring = std::sqrt(1 - y * y),
               azimuth = 0.7 + 2.399963229728653 * index;
  direction[0] = static_cast<float>(ring * std::cos(azimuth));
  direction[1] = static_cast<float>(y);
  direction[2] = static_cast<float>(ring * std::sin(azimuth));
}

struct CountContext {
  RTCIntersectContext context;  // the first member, because Embree hands back a pointer to it
  int crossings;
  bool doubtful;
};

// Counts a hit and rejects it, so that the ray goes on to the end.
void count_crossing(const RTCFilterFunctionNArguments* arguments) {
  auto* count = reinterpret_cast<CountContext*>(arguments->context);
  if (arguments->valid[0] == 0) return;
  arguments->valid[0] = 0;
  const float u = RTCHitN_u(arguments->hit, arguments->N, 0), v = RTCHitN_v(arguments->hit, arguments->N, 0);
  float dot = 0, normal_squared = 0;
  const float normal[3] = {RTCHitN_Ng_x(arguments->hit, arguments->N, 0), RTCHitN_Ng_y(arguments->hit, arguments->N, 0),
                           RTCHitN_Ng_z(arguments->hit, arguments->N, 0)};
  const float direction[3] = {RTCRayN_dir_x(arguments->ray, arguments->N, 0),
                              RTCRayN_dir_y(arguments->ray, arguments->N, 0),
                              RTCRayN_dir_z(arguments->ray, arguments->N, 0)};
  for (int k = 0; k < 3; ++k) {
    dot += normal[k] * direction[k];
    normal_squared += normal[k] * normal[k];
  }
  ++count->crossings;
  const bool at_edge = !(u > k_edge_margin && v > k_edge_margin && 1 - u - v > k_edge_margin);
  count->doubtful = count->doubtful || at_edge || !(std::fabs(dot) > k_grazing * std::sqrt(normal_squared));
}

}  // namespace

// A scene of medium quality splits no triangle, so the filter sees each triangle once.
RayCaster::RayCaster(const Mesh& mesh)
    : scene_(EmbreeScene::triangles(mesh.vertices, mesh.indices, RTC_BUILD_QUALITY_MEDIUM,
                                    RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION)) {}

namespace {

RayHit with_unit_normal(const EmbreeHit& hit, float farthest) {
  RayHit result = {hit.found, hit.found ? hit.distance : farthest, {0, 0, 0}, hit.primitive};
  const float* n = hit.normal;
  const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int k = 0; k < 3; ++k) result.normal[k] = length > 0 ? n[k] / length : 0;
  return result;
}

}  // namespace

RayHit RayCaster::closest(const float origin[3], const float direction[3], float nearest, float farthest) const {
  return with_unit_normal(scene_.closest(origin, direction, nearest, farthest), farthest);
}

RayHit RayCaster::closest(Vec3 origin, Vec3 direction, double limit) const {
  return with_unit_normal(scene_.closest(origin, direction, limit), static_cast<float>(limit));
}

bool RayCaster::inside(const float point[3]) const {
  int votes[2] = {0, 0}, doubtful_votes[2] = {0, 0};
  for (int index = 0; index < k_directions && votes[0] < 2 && votes[1] < 2; ++index) {
    float direction[3];
    test_direction(index, direction);
    CountContext count = {};
    rtcInitIntersectContext(&count.context);
    count.context.filter = count_crossing;
    RTCRay ray = embree_ray(point, direction, 0, INFINITY);
    rtcOccluded1(scene_.handle(), &count.context, &ray);
    int* tally = count.doubtful ? doubtful_votes : votes;
    ++tally[count.crossings & 1];
  }
  if (votes[0] != votes[1]) return votes[1] > votes[0];
  return doubtful_votes[1] > doubtful_votes[0];
}

int RayCaster::inside_test(void* user, const float point[3]) {
  return static_cast<const RayCaster*>(user)->inside(point) ? 1 : 0;
}

}  // namespace sandglass::host

#endif

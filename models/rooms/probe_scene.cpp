#include "models/rooms/probe_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/files/failure.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_plane_side = 200.0, k_far = 1e4, k_lift = 1e-3;                          // object heights
constexpr double k_camera_distance = 3.4, k_camera_elevation_deg = 32.0, k_fov_deg = 40.0;  // vertical field of view
constexpr int k_bounces = 3;
constexpr uint64_t k_probe_stream = 31;

}  // namespace

ProbeLight ProbeLight::environment(const RadianceMap& map, const ViewRotation& rotation) {
  ProbeLight light;
  light.kind_ = Kind::environment, light.map_ = &map, light.rotation_ = rotation;
  light.cumulative_.reserve(map.rgb.size() / 3);
  double sum = 0.0;
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u)
      light.cumulative_.push_back(sum += luminance(map.colour(u, v)) * pixel_solid_angle(v, map.width, map.height));
  return light;
}

ProbeLight ProbeLight::directional(Vec3 towards) {
  ProbeLight light;
  light.kind_ = Kind::directional, light.towards_ = towards;
  return light;
}

ProbeLight ProbeLight::ambient() { return {}; }

ProbeLight::Sample ProbeLight::sample(Vec3 normal, double a, double b) const {
  if (kind_ == Kind::ambient) {
    const Vec3 d = cosine_direction(normal, a, b);
    const double weight = k_pi / std::max(dot(d, normal), 1e-6);
    return {d, {weight, weight, weight}};
  }
  if (kind_ == Kind::directional) {
    const double sine = std::sin(k_light_half_angle_deg * k_pi / 180.0), least = std::sqrt(1.0 - sine * sine);
    const Vec3 d = cap_direction(towards_, least, a, b);
    // A cap of radiance pi / (pi sine^2) gives a surface that faces it the irradiance pi. The density is uniform over
    // the cap.
    const double weight = 2.0 * k_pi * (1.0 - least) / (sine * sine);
    return {d, {weight, weight, weight}};
  }
  const double total = cumulative_.back(), at = a * total;
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), at);
  const auto index = std::min<size_t>(static_cast<size_t>(found - cumulative_.begin()), cumulative_.size() - 1);
  const double before = index > 0 ? cumulative_[index - 1] : 0.0, share = cumulative_[index] - before;
  const int u = static_cast<int>(index) % map_->width, v = static_cast<int>(index) / map_->width;
  const double within = share > 0.0 ? (at - before) / share : 0.5;
  const Vec3 d = panorama_direction(u + within - 0.5, v + b - 0.5, map_->width, map_->height);
  const Vec3 radiance = map_->colour(u, v);
  const double bright = luminance(radiance);
  return {rotation_.to_panorama(d), bright > 0.0 ? radiance * (total / bright) : Vec3{}};
}

#ifdef SANDGLASS_HAVE_EMBREE

struct ProbeScene::State {
  EmbreeScene scene;
};

ProbeScene::ProbeScene(const Mesh& object) {
  Vec3 low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  for (size_t i = 0; i < object.vertices.size(); i += 3) {
    const float* p = object.vertices.data() + i;
    low = {std::min<double>(low.x, p[0]), std::min<double>(low.y, p[1]), std::min<double>(low.z, p[2])};
    high = {std::max<double>(high.x, p[0]), std::max<double>(high.y, p[1]), std::max<double>(high.z, p[2])};
  }
  if (!(high.y > low.y)) throw Failure("cannot light the object: it has no height. Name a solid mesh with --object.");
  const double scale = 1.0 / (high.y - low.y);
  Mesh scene = object;
  for (size_t i = 0; i < scene.vertices.size(); i += 3) {
    scene.vertices[i] = static_cast<float>((object.vertices[i] - 0.5 * (low.x + high.x)) * scale);
    scene.vertices[i + 1] = static_cast<float>((object.vertices[i + 1] - low.y) * scale);
    scene.vertices[i + 2] = static_cast<float>((object.vertices[i + 2] - 0.5 * (low.z + high.z)) * scale);
  }
  const auto first = static_cast<uint32_t>(scene.vertices.size() / 3);
  const float side = static_cast<float>(k_plane_side);
  for (const float x : {-side, side})
    for (const float z : {-side, side}) scene.vertices.insert(scene.vertices.end(), {x, 0.0f, z});
  for (const uint32_t corner : {0u, 1u, 3u, 0u, 3u, 2u}) scene.indices.push_back(first + corner);
  state_ = std::make_unique<State>(State{EmbreeScene::triangles(scene.vertices, scene.indices)});
}

RadianceMap ProbeScene::render(const ProbeLight& light, View view, int samples) const {
  const double elevation = k_camera_elevation_deg * k_pi / 180.0;
  const Vec3 ahead = direction_of_angles(0.5 * k_pi + elevation, view.phi);
  const Vec3 target = {0.0, 0.42, 0.0}, eye = target - ahead * k_camera_distance;
  const Vec3 right = normalised(cross(ahead, Vec3{0, 1, 0})), up = cross(right, ahead);
  const double focal = 0.5 * k_height / std::tan(k_fov_deg * k_pi / 360.0);
  RadianceMap image(k_width, k_height);
  for (int y = 0; y < k_height; ++y)
    for (int x = 0; x < k_width; ++x) {
      Random random = random_stream(static_cast<uint64_t>(y * k_width + x), k_probe_stream);
      const double shift[4] = {random.uniform(), random.uniform(), random.uniform(), random.uniform()};
      Vec3 sum;
      for (int i = 0; i < samples; ++i) {
        const auto even = [&](int k) { return lattice_point(shift[k], i, k_plane_steps[k % 2]); };
        Vec3 origin = eye;
        const double pixel_y = y + random.uniform(), pixel_x = x + random.uniform();
        Vec3 direction =
            normalised(ahead * focal + right * (pixel_x - 0.5 * k_width) + up * (0.5 * k_height - pixel_y));
        Vec3 throughput = {1, 1, 1};
        for (int bounce = 0; bounce < k_bounces; ++bounce) {
          const EmbreeHit hit = state_->scene.closest(origin, direction, k_far);
          if (!hit.found) break;
          Vec3 normal = hit.unit_normal();
          if (dot(normal, direction) > 0.0) normal = normal * -1.0;
          const Vec3 point = origin + direction * hit.distance + normal * k_lift;
          const bool first = bounce == 0;
          const auto number = [&](int k) { return first ? even(k) : random.uniform(); };
          const double b = number(1), a = number(0);
          const ProbeLight::Sample s = light.sample(normal, a, b);
          const double cosine = dot(s.direction, normal);
          throughput = throughput * k_reflectance;
          if (cosine > 0.0) {
            if (!state_->scene.occluded(point, s.direction, k_far))
              sum = sum + product(throughput, s.weight) * (cosine / k_pi);
          }
          const double d = number(3), c = number(2);
          direction = cosine_direction(normal, c, d);
          origin = point;
        }
      }
      image.set(x, y, sum * (1.0 / samples));
    }
  return image;
}

#else

struct ProbeScene::State {};
ProbeScene::ProbeScene(const Mesh&) {
  throw Failure("cannot light the object: this build lacks Embree. Install it, configure and build again.");
}
RadianceMap ProbeScene::render(const ProbeLight&, View, int) const { return {}; }

#endif

ProbeScene::~ProbeScene() = default;

}  // namespace sandglass::host

#include "tests/laboratory/shadow/placed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/compositing/shot.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/rooms/probe_light.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/random.h"
#include "runtime/light/harmonics.h"
#include "tests/laboratory/shadow/app_cast.h"

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi, k_degree = k_pi / 180, k_reported = std::numeric_limits<double>::infinity();
constexpr double k_height = 0.4, k_top = 0.15, k_far = 100, k_lift = 1e-5;  // metres
constexpr double k_half = 4 * k_degree, k_polar = 40 * k_degree, k_azimuth = 34 * k_degree;
constexpr double k_lamp_share = 0.75;  // of the light of the table
constexpr double k_white = 0.8;        // what white on the table is shown as
constexpr int k_bounces = 4;
constexpr Vec3 k_wood = {0.60, 0.44, 0.30}, k_table = {0.55, 0.52, 0.47};

Vec3 towards_lamp() {
  return {std::sin(k_polar) * std::cos(k_azimuth), std::cos(k_polar), std::sin(k_polar) * std::sin(k_azimuth)};
}

// A lamp and an even sky, of which the table gets 1 together; nothing comes from below.
RadianceMap made_light() {
  const double lamp = k_lamp_share / (k_pi * std::sin(k_half) * std::sin(k_half) * std::cos(k_polar));
  constexpr int k_parts = 8;  // the lamp's rim, within a pixel
  RadianceMap map(512, 256);
  for (int v = 0; v < map.height / 2; ++v)
    for (int u = 0; u < map.width; ++u) {
      int in = 0;
      for (int i = 0; i < k_parts * k_parts; ++i)
        in += dot(panorama_direction(u + (i % k_parts + 0.5) / k_parts - 0.5, v + (i / k_parts + 0.5) / k_parts - 0.5,
                                     map.width, map.height),
                  towards_lamp()) > std::cos(k_half)
                  ? 1
                  : 0;
      const double all = (1 - k_lamp_share) / k_pi + lamp * in / (k_parts * k_parts);
      map.set(u, v, {all, all, all});
    }
  return map;
}

// The things of a table, in the shadow's way.
struct Table {
  Mesh mesh;
  std::vector<Vec3> colours;  // of the triangles
  explicit Table(const std::vector<Mesh>& things) {
    struct {
      double away, aside, turn;
      Vec3 colour;
    } constexpr k_stand[] = {{0.24, -0.08, 0.2, {0.50, 0.16, 0.13}}, {0.22, 0.13, 1.1, {0.16, 0.30, 0.42}},
                             {0.09, 0.24, 0.0, {0.70, 0.68, 0.62}},  {0.10, -0.27, 0.0, {0.62, 0.64, 0.60}},
                             {0.42, 0.04, 2.2, {0.58, 0.50, 0.20}},  {0.40, -0.20, 0.9, {0.24, 0.40, 0.22}}};
    const Vec3 lamp = towards_lamp(), away = normalised(Vec3{-lamp.x, 0, -lamp.z}), aside = {-away.z, 0, away.x};
    for (size_t i = 0; i < things.size(); ++i) {
      const auto& stand = k_stand[i % std::size(k_stand)];
      const Vec3 at = away * stand.away + aside * stand.aside;
      const Quaternion turn = rotation_by({0, stand.turn, 0});
      const uint32_t first = mesh.vertex_count();
      for (size_t k = 0; k < things[i].vertices.size(); k += 3) {
        const Vec3 p = rotate(turn, from_floats(&things[i].vertices[k])) + at;
        for (const double x : {p.x, p.y, p.z}) mesh.vertices.push_back(static_cast<float>(x));
      }
      for (const uint32_t index : things[i].indices) mesh.indices.push_back(first + index);
      colours.resize(mesh.indices.size() / 3, stand.colour);
    }
  }
};

LitObject made_object() {
  SceneFile scene = load_scene("chair");
  for (ColliderTrack& track : scene.colliders) {
    track.position = {};
    track.rotation = k_no_rotation;
    track.size = {k_height, k_height, k_height};
  }
  return standing_object(scene);
}

struct Hit {
  enum { nothing, place, object } what = nothing;
  Vec3 point, normal, reflectance;
  uint32_t triangle = 0;
};

struct Scene {
  Table table;
  LitObject object = made_object();
  EmbreeScene place_rays, object_rays;
  RadianceMap map = made_light();
  ViewRotation level{{k_pi / 2, k_pi / 2}};
  ProbeLight probe{map, level};

  explicit Scene(const std::vector<Mesh>& things)
      : table(things),
        place_rays(EmbreeScene::triangles(table.mesh.vertices, table.mesh.indices)),
        object_rays(EmbreeScene::triangles(object.mesh.vertices, object.mesh.indices)) {}

  Hit closest(Vec3 origin, Vec3 direction, bool with_object) const {
    Hit hit;
    double distance = k_far;
    if (direction.y < 0) {
      distance = -origin.y / direction.y;
      hit = {Hit::place, {}, {0, 1, 0}, k_table};
    }
    const auto take = [&](const EmbreeHit& h, decltype(hit.what) what) {
      if (!h.found) return;
      distance = static_cast<double>(h.distance);
      Vec3 n = h.unit_normal();
      if (dot(n, direction) > 0) n = n * -1.0;
      hit = {what, {}, n, what == Hit::place ? table.colours[h.primitive] : k_wood, h.primitive};
    };
    take(place_rays.closest(origin, direction, distance), Hit::place);
    if (with_object) take(object_rays.closest(origin, direction, distance), Hit::object);
    hit.point = origin + direction * distance;
    return hit;
  }

  // What a place sends towards the eye.
  Vec3 radiance(Hit hit, bool with_object, Random random) const {
    Vec3 sum, throughput = {1, 1, 1};
    for (int bounce = 0; bounce < k_bounces && hit.what != Hit::nothing; ++bounce) {
      throughput = product(throughput, hit.reflectance);
      const double a = random.uniform(), b = random.uniform(), c = random.uniform(), d = random.uniform();
      const ProbeLight::Sample light = probe.sample(a, b);
      const double cosine = dot(light.direction, hit.normal);
      const Vec3 from = hit.point + hit.normal * k_lift;
      const bool dark = cosine <= 0 || place_rays.occluded(from, light.direction, k_far) ||
                        (with_object && object_rays.occluded(from, light.direction, k_far));
      if (!dark) sum = sum + product(throughput, light.weight) * (cosine / k_pi);
      hit = closest(from, cosine_direction(hit.normal, c, d), with_object);
    }
    return sum;
  }
};

// What is drawn upon the place: a share of what the camera shows of it.
enum Drawn { k_layers, k_floor, k_nothing, k_drawn };
constexpr const char* k_names[k_drawn] = {"4 layers", "the floor's texture", "no shadow"};

struct Casts {
  Cast layered, flat;
  explicit Casts(const Mesh& mesh) {
    const sandglass_cast_mesh caster = cast_mesh_of(mesh, false, false);
    std::array<float, 3> towards;
    to_floats(towards_lamp(), towards.data());
    for (Cast* cast : {&layered, &flat}) {
      sandglass_cast_desc desc = cast_desc();
      desc.triangle_capacity = mesh.triangle_count();
      desc.layers = cast == &layered ? 4 : 1;
      sandglass_cast_plane plane = cast_plane();
      plane.height = static_cast<float>(k_top);
      if (const Status status = cast->create(desc); !status) throw Failure(status.reason);
      for (const Status& status : {cast->set_plane(plane), cast->set_meshes(&caster, 1),
                                   cast->set_light(towards, static_cast<float>(2 * k_half))})
        if (!status) throw Failure(status.reason);
      cast->run();
    }
  }
  double left(Drawn drawn, Vec3 p) const {
    if (drawn == k_nothing) return 1;
    const double hidden = drawn == k_layers ? slid(layered.texture(), p, 0) : sampled(flat.texture(), p, 0);
    const double open = drawn == k_layers ? slid(layered.ambient(), p, 1) : sampled(flat.ambient(), p, 1);
    return (1 - k_lamp_share) * open + k_lamp_share * (1 - hidden);
  }
};

// What the object shows, by its nine numbers at the place, in the light of lamp, sky and table.
Vec3 object_shown(const LitObject& object, const ShotLight& light, const Hit& hit) {
  Vec3 corners[3];
  for (size_t k = 0; k < 3; ++k)
    corners[k] = from_floats(&object.mesh.vertices[3 * size_t{object.mesh.indices[3 * size_t{hit.triangle} + k]}]);
  const Vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0], ap = hit.point - corners[0];
  const Vec3 across = cross(ab, ac);
  const double v = dot(cross(ap, ac), across) / dot(across, across),
               w = dot(cross(ab, ap), across) / dot(across, across);
  const double weights[3] = {1 - v - w, v, w};
  Vec3 sum;
  for (size_t j = 0; j < k_harmonics; ++j) {
    double transfer = 0;
    for (size_t k = 0; k < 3; ++k)
      transfer += weights[k] * static_cast<double>(object.transfer[(3 * size_t{hit.triangle} + k) * k_harmonics + j]);
    sum = sum + from_floats(light.sh + 3 * j) * transfer;
  }
  return product(hit.reflectance, {std::max(sum.x, 0.0), std::max(sum.y, 0.0), std::max(sum.z, 0.0)});
}

struct Pictures {
  RadianceMap truth, drawn[k_drawn];
};

Pictures pictures_of(const Scene& scene, const Casts& casts, const ShotLight& light, const CameraFrame& camera,
                     int height, int paths, uint64_t seed, ThreadPool& pool) {
  const int width = height / 3 * 4;
  Pictures made;
  made.truth = RadianceMap(width, height);
  for (RadianceMap& map : made.drawn) map = made.truth;
  pool.run(static_cast<uint32_t>(height), [&](uint32_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      Random random = random_stream(seed, row * 65536u + static_cast<uint32_t>(x));
      Vec3 truth, drawn[k_drawn];
      for (int i = 0; i < paths; ++i) {
        const double right = x + random.uniform(), down = y + random.uniform();
        const Vec3 direction = normalised(camera.ray(right, down, width, height));
        const Hit hit = scene.closest(camera.eye, direction, true);
        const Random same = random_stream(random.next(), row);
        truth = truth + scene.radiance(hit, true, same);
        const Vec3 behind =
            hit.what == Hit::object ? object_shown(scene.object, light, hit) : scene.radiance(hit, false, same);
        for (size_t k = 0; k < k_drawn; ++k)
          drawn[k] = drawn[k] + behind * (hit.what == Hit::place ? casts.left(static_cast<Drawn>(k), hit.point) : 1);
      }
      const double exposure = k_white * k_pi / paths;
      made.truth.set(x, y, limited(truth * exposure));
      for (size_t k = 0; k < k_drawn; ++k) made.drawn[k].set(x, y, limited(drawn[k] * exposure));
    }
  });
  return made;
}

CameraFrame pose_of(size_t pose) {
  constexpr double k_turns[k_placed_poses] = {0, 55, 110, -60, 170}, k_rise[k_placed_poses] = {35, 28, 45, 50, 32};
  const double turn = k_azimuth + (k_turns[pose] - 100) * k_degree, rise = k_rise[pose] * k_degree;
  const Vec3 target = towards_lamp() * -0.25;
  const Vec3 middle = {target.x, 0.1, target.z};
  const Vec3 out = {std::cos(rise) * std::cos(turn), std::sin(rise), std::cos(rise) * std::sin(turn)};
  return frame_of({middle + out * 1.15, middle, 34});
}

}  // namespace

std::vector<Verdict> verify_placed(const PlacedOptions& options, ThreadPool& pool, const std::function<bool()>& go_on) {
  const Scene scene(options.table);
  const Casts casts(scene.object.mesh);
  const ShotLight light = light_above_floor(scene.map, {k_pi / 2, k_pi / 2}, k_table * (1 / k_pi));
  double flip[k_drawn] = {}, rmse[k_drawn] = {}, worse = 0;
  for (size_t pose = 0; pose < k_placed_poses; ++pose) {
    const Pictures made = pictures_of(scene, casts, light, pose_of(pose), options.quick ? 90 : 180,
                                      options.quick ? 48 : 192, options.seed + pose, pool);
    double of_pose[k_drawn];
    for (size_t k = 0; k < k_drawn; ++k) {
      const ShotErrors errors = shot_errors(made.truth, made.drawn[k]);
      of_pose[k] = errors.flip;
      flip[k] += errors.flip / k_placed_poses;
      rmse[k] += errors.rmse / k_placed_poses;
    }
    worse += of_pose[k_layers] < of_pose[k_floor] ? 0 : 1;
    if (!go_on()) return {};
  }
  if (!options.picture.empty()) {
    const Pictures large = pictures_of(scene, casts, light, pose_of(3), 360, 256, options.seed, pool);
    const Picture parts[] = {picture_of(large.drawn[k_layers]), picture_of(large.truth),
                             picture_of(large.drawn[k_floor])};
    write_file(options.picture, jpeg_file(picture_grid(parts, 3, 6), 85));
  }
  std::vector<Verdict> rows;
  const auto add = [&](const std::string& name, double value, double limit, bool control = false) {
    rows.push_back(
        {"placed", "a chair in a scanned place, " + name, "", 0, value, limit, (value <= limit) != control, control});
  };
  constexpr double k_limit = 0.06;
  add("4 layers, FLIP", flip[k_layers], k_limit);
  add("poses where 4 layers are no better", worse, 0);
  add("the floor's texture, FLIP", flip[k_floor], k_reported);
  add("no shadow, FLIP", flip[k_nothing], k_limit, true);
  for (size_t k = 0; k < k_drawn; ++k) add(std::string(k_names[k]) + ", RMSE", rmse[k], k_reported);
  return rows;
}

}  // namespace sandglass::host

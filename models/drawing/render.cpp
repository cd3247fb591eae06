// Each sub-sample has one primary ray. From its hit go one ray to a point of the sun's disk and one cosine-weighted ray
// to the sky. Random numbers start from a hash of the pixel, so pictures repeat. Colours are linear until the last line
// of a pixel.
#include "models/drawing/render.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "models/drawing/sand_layer.h"
#include "models/tracing/directions.h"
#include "models/tracing/sphere_caster.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

namespace {

constexpr double k_azimuth_deg = 28.0, k_elevation_deg = 20.0;  // where the automatic camera stands
constexpr double k_margin = 1.18;                               // room around what the camera frames
constexpr double k_sun_radius = 0.03;  // radians; about six times the real sun's, so that penumbrae show
constexpr Vec3 k_ball = {0.56, 0.36, 0.17};
constexpr double k_occlusion_reach = 0.35;  // of the box's diagonal
constexpr double k_fade_from = 4.0;         // the floor begins to fade this many box diagonals from the target
// Lifts secondary rays off their surface: a share of 100 sphere radii on a sphere, of the box's diagonal elsewhere.
constexpr double k_offset = 1e-4;
constexpr double k_far = 1e4;  // metres
constexpr double k_even_steps[4] = {0.8566748838545029, 0.7338918566271260, 0.6287067210378087, 0.5385972572236101};

constexpr Vec3 k_sun_light = {3.0, 2.75, 2.35}, k_sky_light = {0.46, 0.50, 0.56};  // irradiance; radiance
constexpr Vec3 k_floor = {0.52, 0.50, 0.46}, k_solid = {0.09, 0.24, 0.33};
constexpr Vec3 k_horizon = {0.86, 0.82, 0.75}, k_zenith = {0.62, 0.66, 0.70};
constexpr double k_reflected = 0.12;  // of the sky's light, where something near hides it
constexpr double k_exposure = 1.15;

// A coin of one euro: metres, and its two metals.
constexpr double k_coin = 0.01163, k_coin_middle = 0.0083, k_coin_height = 0.00233;
constexpr Vec3 k_gold = {0.55, 0.42, 0.20}, k_silver = {0.52, 0.52, 0.50};

uint32_t hash(uint32_t value) {
  value ^= value >> 16;
  value *= 0x7feb352du;
  value ^= value >> 15;
  value *= 0x846ca68bu;
  return value ^ (value >> 16);
}
double unit_random(uint32_t* state) {
  *state = hash(*state + 0x9e3779b9u);
  return (*state >> 8) * (1.0 / 16777216.0);
}

Vec3 scaled(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
Vec3 mixed(Vec3 a, Vec3 b, double t) { return a * (1.0 - t) + b * t; }

// A collider, with the turn from the world to its local frame.
struct Solid {
  sandglass_shape shape;
  Vec3 position, size;
  Quaternion rotation;
  const sandglass_field* field;
  bool container;
  Vec3 to_local(Vec3 v) const { return rotate(conjugate(rotation), v); }
};

struct SurfaceHit {
  double distance = k_far;
  Vec3 normal;
};

// The hit_ functions find where a ray from outside meets a solid, in the solid's local frame. They change *hit only for
// a nearer hit, and then return true.
bool hit_sphere(Vec3 centre, double radius, Vec3 o, Vec3 d, SurfaceHit* hit) {
  const Vec3 to = centre - o;
  const double along = dot(to, d), gap = radius * radius - (dot(to, to) - along * along);
  if (gap < 0.0) return false;
  const double distance = along - std::sqrt(gap);
  if (distance <= 0.0 || distance >= hit->distance) return false;
  *hit = {distance, (o + d * distance - centre) * (1.0 / radius)};
  return true;
}

bool hit_box(Vec3 half, Vec3 o, Vec3 d, SurfaceHit* hit) {
  const double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z}, extent[3] = {half.x, half.y, half.z};
  double enter = 0.0, leave = hit->distance;
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (std::fabs(origin[axis]) > extent[axis]) return false;
      continue;
    }
    const double sign = direction[axis] > 0.0 ? 1.0 : -1.0;
    const double in = (-sign * extent[axis] - origin[axis]) / direction[axis];
    const double out = (sign * extent[axis] - origin[axis]) / direction[axis];
    if (in > enter) {
      enter = in;
      face = axis;
    }
    leave = std::min(leave, out);
  }
  if (face < 0 || enter > leave) return false;
  const double side = direction[face] > 0.0 ? -1.0 : 1.0;
  *hit = {enter, {face == 0 ? side : 0.0, face == 1 ? side : 0.0, face == 2 ? side : 0.0}};
  return true;
}

bool hit_capsule(double radius, double half, Vec3 o, Vec3 d, SurfaceHit* hit) {
  const bool upper = hit_sphere({0, half, 0}, radius, o, d, hit), lower = hit_sphere({0, -half, 0}, radius, o, d, hit);
  const bool found = upper || lower;
  const double a = d.x * d.x + d.z * d.z, b = o.x * d.x + o.z * d.z, c = o.x * o.x + o.z * o.z - radius * radius;
  const double gap = b * b - a * c;
  if (a == 0.0 || gap < 0.0) return found;
  const double distance = (-b - std::sqrt(gap)) / a;
  const Vec3 at = o + d * distance;
  if (distance <= 0.0 || distance >= hit->distance || std::fabs(at.y) > half) return found;
  *hit = {distance, Vec3{at.x, 0, at.z} * (1.0 / radius)};
  return true;
}

// Marches along the ray by the field's distances. A container is seen from outside through its front: the ray hits the
// wall behind the free space.
bool hit_field(const sandglass_field* field, Vec3 o, Vec3 d, SurfaceHit* hit) {
  constexpr int k_steps = 96;
  constexpr double k_distance_min = 5e-4;  // in diagonals of the box
  float low[3], high[3];
  const bool container = sandglass_field_bounds(field, low, high) == SANDGLASS_SOLID_OUTSIDE;
  const Vec3 middle = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
  const Vec3 half = {0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2])};
  const double distance_min = k_distance_min * 2.0 * length(half);
  SurfaceHit entry = *hit;
  double t = 0.0;
  const Vec3 from = o - middle;
  const bool within = std::fabs(from.x) < half.x && std::fabs(from.y) < half.y && std::fabs(from.z) < half.z;
  if (!within) {
    if (!hit_box(half, from, d, &entry)) return false;
    t = entry.distance + distance_min;
  }
  bool free = !container;
  for (int step = 0; step < k_steps && t < hit->distance; ++step) {
    const Vec3 p = o + d * t, local = p - middle;
    if (std::fabs(local.x) > half.x || std::fabs(local.y) > half.y || std::fabs(local.z) > half.z) return false;
    float point[3], normal[3];
    to_floats(p, point);
    const double distance = static_cast<double>(sandglass_field_distance(field, point, normal));
    if (!free && distance > 2.0 * distance_min) free = true;
    if (free && distance < distance_min) {
      // A hit counts only against the normal. So a ray that begins on the surface leaves it and goes on to the far
      // side.
      if (dot(from_floats(normal), d) < 0.0) {
        *hit = {t, from_floats(normal)};
        return true;
      }
    }
    t += std::max(0.95 * std::fabs(distance), 2.0 * distance_min);
  }
  return false;
}

bool hit_solid(const Solid& solid, Vec3 origin, Vec3 direction, SurfaceHit* hit) {
  const Vec3 o = solid.to_local(origin - solid.position), d = solid.to_local(direction);
  bool found = false;
  switch (solid.shape) {
    case SANDGLASS_SHAPE_HALF_SPACE: {
      const double distance = d.y < 0.0 ? -o.y / d.y : -1.0;
      found = distance > 0.0 && distance < hit->distance;
      if (found) *hit = {distance, {0, 1, 0}};
      break;
    }
    case SANDGLASS_SHAPE_SPHERE:
      found = hit_sphere({}, solid.size.x, o, d, hit);
      break;
    case SANDGLASS_SHAPE_CAPSULE:
      found = hit_capsule(solid.size.x, solid.size.y, o, d, hit);
      break;
    case SANDGLASS_SHAPE_BOX:
      found = hit_box(solid.size, o, d, hit);
      break;
    case SANDGLASS_SHAPE_FIELD:
      found = solid.field != nullptr && hit_field(solid.field, o, d, hit);
      break;
    default:
      break;
  }
  if (found) hit->normal = rotate(solid.rotation, hit->normal);
  return found;
}

// What casts shadows: the spheres; of sand a ball below each vertex of its surface, and a small one where sand flies.
struct Casters {
  std::vector<float> middles, sizes;
  float radius;
};
Casters casters_of(const SceneView& view) {
  constexpr float k_flying = 0.2f;
  if (view.sand == nullptr) return {{view.spheres.begin(), view.spheres.end()}, {}, view.radius};
  const SandShape& sand = *view.sand;
  Casters casters = {{}, {}, sand.particle_radius};
  for (const sandglass_skin_vertex& v : sand.vertices)
    for (int k = 0; k < 3; ++k)
      casters.middles.push_back(v.position[k] - sand.particle_radius * static_cast<float>(v.normal[k]) / 127.0f);
  casters.sizes.assign(sand.vertices.size(), 1.0f);
  for (uint32_t i = 0; i < sand.flying; ++i)
    casters.middles.insert(casters.middles.end(), sand.loose[i].position, sand.loose[i].position + 3);
  casters.sizes.resize(casters.middles.size() / 3, k_flying);
  return casters;
}

struct Tracer {
  const SceneView& view;
  Casters casters;
  SphereCaster caster;
  std::vector<Solid> solids;
  CameraFrame frame;
  double diagonal;
  Vec3 sun;
  double sun_spread = k_sun_radius;
  std::optional<Vec3> coin;  // the middle of its lower face
  std::optional<SandLayer> sand;

  Tracer(const SceneView& v, const RenderOptions& options)
      : view(v),
        casters(casters_of(v)),
        caster(casters.middles, casters.radius, casters.sizes),
        frame(frame_of(v.camera)),
        diagonal(std::max(1e-6, length(v.bounds.high - v.bounds.low))),
        sun(normalised(v.to_light)) {
    if (!v.shadows.empty()) sun_spread = std::tan(v.shadows[0].half_angle);
    for (const sandglass_collider& c : v.colliders) {
      const Quaternion q = {c.rotation[0], c.rotation[1], c.rotation[2], c.rotation[3]};
      const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
      solids.push_back({c.shape, from_floats(c.position), from_floats(c.size),
                        norm > 0.0 ? normalised(q) : k_no_rotation, c.field, behind_glass({&c, 1})});
    }
    if (options.coin) place_coin();
    if (v.sand == nullptr) return;
    const SandLight light = sand_light();
    sand.emplace(*v.sand, light, frame, SandLayer::Size{options.width, options.height, options.samples},
                 options.threads);
  }

  // Before the sand and to its right, where a level floor is.
  void place_coin() {
    const Bounds& b = view.bounds;
    const Vec3 middle = {0.5 * (b.low.x + b.high.x), 0.0, 0.5 * (b.low.z + b.high.z)};
    const double reach = 0.5 * std::max(b.high.x - b.low.x, b.high.z - b.low.z) + 3.0 * k_coin;
    const Vec3 forward = normalised(Vec3{frame.forward.x, 0.0, frame.forward.z});
    for (const Solid& solid : solids) {
      if (solid.shape != SANDGLASS_SHAPE_HALF_SPACE || rotate(solid.rotation, {0, 1, 0}).y < 0.9999) continue;
      const Vec3 at = middle + (frame.right * 0.5 - forward) * (reach / std::sqrt(1.25));
      coin = Vec3{at.x, solid.position.y, at.z};
      return;
    }
  }

  // Its albedo; none beside it.
  std::optional<Vec3> hit_coin(Vec3 origin, Vec3 direction, SurfaceHit* hit) const {
    if (!coin) return std::nullopt;
    const Vec3 o = origin - *coin;
    const double top = (k_coin_height - o.y) / direction.y;
    if (direction.y < 0.0 && top > 0.0 && top < hit->distance) {
      const double r = std::hypot(o.x + top * direction.x, o.z + top * direction.z);
      if (r < k_coin) {
        *hit = {top, {0, 1, 0}};
        return r < k_coin_middle ? k_silver : k_gold;
      }
    }
    const double a = direction.x * direction.x + direction.z * direction.z, b = o.x * direction.x + o.z * direction.z;
    const double gap = b * b - a * (o.x * o.x + o.z * o.z - k_coin * k_coin);
    if (a == 0.0 || gap < 0.0) return std::nullopt;
    const double side = (-b - std::sqrt(gap)) / a, height = o.y + side * direction.y;
    if (side <= 0.0 || side >= hit->distance || height < 0.0 || height > k_coin_height) return std::nullopt;
    *hit = {side, Vec3{o.x + side * direction.x, 0.0, o.z + side * direction.z} * (1.0 / k_coin)};
    return k_gold;
  }

  SandLight sand_light() const {
    SandLight light;
    light.to_light = sun;
    light.sun = k_sun_light * (k_exposure / std::numbers::pi);
    const Vec3 sky = k_sky_light * k_exposure, below = scaled(k_floor, light.sun * std::max(sun.y, 0.0) + sky);
    light.around_below = [below](Vec3 n) { return below * (0.5 - 0.5 * n.y); };
    light.around = [below, sky](Vec3 n) { return sky * (0.5 + 0.5 * n.y) + below * (0.5 - 0.5 * n.y); };
    const auto left = [this](const std::vector<FloorShadow> SceneShadows::*which) {
      return [this, which](Vec3 p) {
        double share = 1.0;
        if (view.on_sand != nullptr)
          for (const FloorShadow& shadow : view.on_sand->*which) share *= floor_transparency(shadow, p.x, p.z);
        return share;
      };
    };
    light.pile_passed = left(&SceneShadows::pile_on_sand);
    light.under_sky = left(&SceneShadows::sky_on_sand);
    light.object_passed = [this](Vec3 p) { return hidden_by_solid(p, sun, k_far, false) ? 0.0 : 1.0; };
    return light;
  }

  static Vec3 background(Vec3 direction) { return mixed(k_horizon, k_zenith, std::clamp(direction.y * 1.6, 0.0, 1.0)); }

  // With `catcher` the point lies on a floor. There the shadows of some solids are textures, so these solids do not
  // count.
  bool blocked(Vec3 origin, Vec3 direction, double limit, bool catcher) const {
    // Where sand is thin, its balls reach through it: what they hide of places within them is not looked at.
    const double within = view.sand != nullptr ? static_cast<double>(casters.radius) : 0.0;
    return caster.occluded(origin + direction * within, direction, limit - within) ||
           hidden_by_solid(origin, direction, limit, catcher);
  }
  bool hidden_by_solid(Vec3 origin, Vec3 direction, double limit, bool catcher) const {
    SurfaceHit hit;
    hit.distance = limit;
    for (const Solid& solid : solids) {
      if (solid.shape == SANDGLASS_SHAPE_FIELD && solid.container) continue;  // glass
      const auto is_it = [&](const FloorShadow& shadow) { return &solid == &solids[shadow.collider]; };
      if (catcher && std::any_of(view.shadows.begin(), view.shadows.end(), is_it)) continue;
      if (hit_solid(solid, origin, direction, &hit)) return true;
    }
    return false;
  }

  // The share of the direct light that the textures leave at a point of the floor.
  double transparency(Vec3 at) const {
    constexpr double k_same_floor = 1e-3;
    double share = 1.0;
    for (const FloorShadow& shadow : view.shadows)
      if (std::fabs(at.y - shadow.position.y) <= k_same_floor) share *= floor_transparency(shadow, at.x, at.z);
    return share;
  }

  // What is seen along a ray, in front of `limit`, which is where sand is; none: the sand.
  // `even`: four numbers that fill 0..1 evenly from sample to sample of a pixel.
  std::optional<Vec3> trace(Vec3 origin, Vec3 direction, double limit, const double (&even)[4]) const {
    SphereHit sphere;
    sphere.distance = k_far;
    const bool on_sphere = view.sand == nullptr && caster.closest(origin, direction, &sphere);
    SurfaceHit surface;
    surface.distance = on_sphere ? sphere.distance : k_far;
    const Solid* solid = nullptr;
    for (const Solid& candidate : solids)
      if (hit_solid(candidate, origin, direction, &surface)) solid = &candidate;
    const std::optional<Vec3> metal = hit_coin(origin, direction, &surface);
    if (limit < surface.distance) return std::nullopt;
    if (!on_sphere && solid == nullptr) return background(direction);

    const Vec3 at = origin + direction * surface.distance;
    Vec3 normal = surface.normal, albedo = metal ? *metal : solid != nullptr ? k_solid : k_ball;
    double fade = 0.0;
    const bool floor = !metal && solid != nullptr && solid->shape == SANDGLASS_SHAPE_HALF_SPACE;
    const bool ball = !metal && solid == nullptr;
    if (ball) normal = normalised(at - from_floats(view.spheres.data() + 3 * static_cast<size_t>(sphere.index)));
    if (floor) {
      albedo = k_floor;
      fade = std::clamp(length(at - view.camera.target) / (k_fade_from * diagonal) - 1.0, 0.0, 1.0);
    }
    const Vec3 start = at + normal * (k_offset * (ball ? 100.0 * static_cast<double>(view.radius) : diagonal));

    const double turn = 2.0 * std::numbers::pi * even[0], spread = sun_spread * std::sqrt(even[1]);
    const Vec3 to_sun = normalised(Frame(sun).world(spread * std::cos(turn), spread * std::sin(turn), 1.0));
    const double facing = dot(normal, to_sun);
    Vec3 light = {};
    if (facing > 0.0 && !blocked(start, to_sun, k_far, floor)) light = k_sun_light * (facing / std::numbers::pi);
    if (floor) light = light * transparency(at);

    const double sky_turn = 2.0 * std::numbers::pi * even[2], sine = std::sqrt(even[3]);
    const Vec3 to_sky =
        Frame(normal).world(sine * std::cos(sky_turn), sine * std::sin(sky_turn), std::sqrt(1.0 - sine * sine));
    const bool open = !blocked(start, to_sky, k_occlusion_reach * diagonal, false);
    light = light + k_sky_light * (open ? 1.0 : k_reflected);
    return mixed(scaled(albedo, light) * k_exposure, background({direction.x, 0.0, direction.z}), fade);
  }

  void draw_row(int y, const RenderOptions& options, Picture* picture) const {
    for (int x = 0; x < options.width; ++x) {
      Vec3 sum = {};
      uint32_t random = hash(static_cast<uint32_t>(y) * 65521u + static_cast<uint32_t>(x));
      double shift[4];
      for (double& number : shift) number = unit_random(&random);
      for (int s = 0; s < options.samples * options.samples; ++s) {
        const double sx = x + (s % options.samples + unit_random(&random)) / options.samples;
        const double sy = y + (s / options.samples + unit_random(&random)) / options.samples;
        const Vec3 direction = normalised(frame.ray(sx, sy, options.width, options.height));
        const SandLayer::Sample none, &of_sand = sand ? sand->at(x, y, s) : none;
        const double limit = static_cast<double>(of_sand.depth) / dot(direction, frame.forward);
        double even[4];
        for (size_t k = 0; k < 4; ++k) even[k] = lattice_point(shift[k], s, k_even_steps[k]);
        const Vec3 colour = trace(view.camera.eye, direction, limit, even).value_or(from_floats(of_sand.radiance));
        sum = sum + Vec3{std::min(colour.x, 1.0), std::min(colour.y, 1.0), std::min(colour.z, 1.0)};
      }
      sum = sum * (1.0 / (options.samples * options.samples));
      uint8_t* pixel = picture->at(x, y);
      pixel[0] = srgb_byte(sum.x);
      pixel[1] = srgb_byte(sum.y);
      pixel[2] = srgb_byte(sum.z);
    }
  }
};

}  // namespace

void Bounds::add(Vec3 p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

void Bounds::add_inner(std::span<const float> xyz) {
  constexpr double k_outermost = 0.01;
  std::vector<float> along;
  double ends[3][2] = {};
  for (size_t axis = 0; axis < 3; ++axis) {
    along.clear();
    for (size_t i = axis; i < xyz.size(); i += 3)
      if (std::isfinite(xyz[i])) along.push_back(xyz[i]);
    if (along.empty()) return;
    const ptrdiff_t last = static_cast<ptrdiff_t>(along.size()) - 1;
    const ptrdiff_t from = static_cast<ptrdiff_t>(k_outermost * static_cast<double>(last));
    std::nth_element(along.begin(), along.begin() + from, along.end());
    ends[axis][0] = along[static_cast<size_t>(from)];
    std::nth_element(along.begin(), along.begin() + (last - from), along.end());
    ends[axis][1] = along[static_cast<size_t>(last - from)];
  }
  add({ends[0][0], ends[1][0], ends[2][0]});
  add({ends[0][1], ends[1][1], ends[2][1]});
}

Camera automatic_camera(std::span<const Bounds> boxes, double aspect) {
  constexpr double k_degree = std::numbers::pi / 180.0;
  // Each round moves the eye to the distance that fits, then the target to the middle of what is seen.
  constexpr int k_rounds = 8;
  Camera camera;
  std::vector<Vec3> corners;
  Bounds all;
  for (const Bounds& box : boxes)
    for (int corner = 0; corner < 8 && !box.empty(); ++corner) {
      corners.push_back({corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                         corner & 4 ? box.high.z : box.low.z});
      all.add(corners.back());
    }
  if (corners.empty()) {
    camera.eye = {0.5, 0.5, 1.0};
    return camera;
  }
  const double azimuth = k_azimuth_deg * k_degree, elevation = k_elevation_deg * k_degree;
  const Vec3 towards_eye = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                            std::cos(azimuth) * std::cos(elevation)};
  camera.target = (all.low + all.high) * 0.5;
  camera.eye = camera.target + towards_eye;
  const CameraFrame frame = frame_of(camera);
  const double half_height = 0.5 / frame.focal;
  double distance = 0.0;
  for (int round = 0; round < k_rounds; ++round) {
    distance = 1e-3;
    for (const Vec3& corner : corners) {
      const Vec3 at = corner - camera.target;
      distance = std::max({distance, dot(at, towards_eye) + std::fabs(dot(at, frame.up)) / half_height * k_margin,
                           dot(at, towards_eye) + std::fabs(dot(at, frame.right)) / (half_height * aspect) * k_margin});
    }
    double left = 1e30, right = -1e30, bottom = 1e30, top = -1e30;  // slopes seen from the eye
    for (const Vec3& corner : corners) {
      const Vec3 at = corner - camera.target;
      const double depth = distance - dot(at, towards_eye);
      left = std::min(left, dot(at, frame.right) / depth);
      right = std::max(right, dot(at, frame.right) / depth);
      bottom = std::min(bottom, dot(at, frame.up) / depth);
      top = std::max(top, dot(at, frame.up) / depth);
    }
    camera.target =
        camera.target + frame.right * (0.5 * (left + right) * distance) + frame.up * (0.5 * (bottom + top) * distance);
  }
  camera.eye = camera.target + towards_eye * distance;
  return camera;
}

PixelPlace project(const Camera& camera, int width, int height, Vec3 point) {
  const CameraFrame frame = frame_of(camera);
  const Vec3 to = point - camera.eye;
  const double depth = dot(to, frame.forward), scale = frame.focal * height / std::max(depth, 1e-9);
  return {0.5 * width + dot(to, frame.right) * scale, 0.5 * height - dot(to, frame.up) * scale, depth};
}

Picture render(const SceneView& view, const RenderOptions& options) {
  const Tracer tracer(view, options);
  Picture picture(options.width, options.height, {0, 0, 0});
  ThreadPool(options.threads).run(static_cast<uint32_t>(options.height), [&](uint32_t row) {
    tracer.draw_row(static_cast<int>(row), options, &picture);
  });
  return picture;
}

}  // namespace sandglass::host

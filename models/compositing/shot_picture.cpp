#include "models/compositing/shot_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/compositing/grains.h"
#include "models/drawing/sand_layer.h"
#include "models/files/failure.h"
#include "models/rooms/probe_light.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/thread_pool.h"
#include "runtime/light/harmonics.h"
#include "runtime/math/random.h"
#include "sandglass/renderers.h"

namespace sandglass::host {

#ifdef SANDGLASS_HAVE_EMBREE

namespace {

std::vector<float> places_of(const SandShape& shape) {
  std::vector<float> places;
  for (const sandglass_skin_vertex& vertex : shape.vertices)
    places.insert(places.end(), vertex.position, vertex.position + 3);
  return places;
}

constexpr double k_pi = std::numbers::pi;
constexpr double k_far = 1e3;                             // metres
constexpr double k_lift = 2e-4, k_lift_of_grains = 5e-6;  // of rays off what they start at
constexpr Vec3 k_object = {0.60, 0.44, 0.30};             // reflectance: varnished wood
constexpr double k_catcher_reach = 6.0;                   // metres from the object's foot; no shadow falls beyond
constexpr Vec3 k_metal = {0.86, 0.86, 0.84};              // of zinc, straight on
constexpr double k_metal_alpha = 0.06;                    // roughness, as GGX has it
constexpr int k_bounces = 6;
constexpr uint64_t k_composite_stream = 41, k_truth_stream = 42;

enum class Surface { none, floor, object, sand, metal };  // as ShotPicture::Seen

struct Hit {
  Surface surface = Surface::none;
  double distance = k_far;
  Vec3 point, normal, reflectance;
  uint32_t triangle = 0;  // of the object
};

Vec3 lifted(const Hit& hit) {
  return hit.point + hit.normal * (hit.surface == Surface::sand ? k_lift_of_grains : k_lift);
}

}  // namespace

struct ShotPicture::State {
  EmbreeScene object;
  LitObject standing;
  SandShape sand;
  EmbreeScene surface;                   // of the sand
  std::unique_ptr<PackedGrains> grains;  // of the truth, where one is asked for

  State(const LitObject& of, const SandShape& shape)
      : object(EmbreeScene::triangles(of.mesh.vertices, of.mesh.indices)),
        standing(of),
        sand(shape),
        surface(shape.indices.empty() ? EmbreeScene::spheres({})
                                      : EmbreeScene::triangles(places_of(shape), shape.indices)) {}

  Vec3 corner(uint32_t triangle, uint32_t k) const {
    const uint32_t vertex = standing.mesh.indices[3 * static_cast<size_t>(triangle) + k];
    return from_floats(standing.mesh.vertices.data() + 3 * static_cast<size_t>(vertex));
  }

  // How near a point of a triangle is to each of its corners.
  std::array<double, 3> weights_at(uint32_t triangle, Vec3 point) const {
    const Vec3 a = corner(triangle, 0), ab = corner(triangle, 1) - a, ac = corner(triangle, 2) - a, ap = point - a;
    const Vec3 normal = cross(ab, ac);
    const double all = dot(normal, normal);
    const double v = dot(cross(ap, ac), normal) / all, w = dot(cross(ab, ap), normal) / all;
    return {1.0 - v - w, v, w};
  }

  Vec3 metal_normal(uint32_t triangle, Vec3 point) const {
    const std::array<double, 3> weights = weights_at(triangle, point);
    const float* corners = standing.metal_normals.data() + 9 * size_t{triangle - standing.metal_from};
    Vec3 sum;
    for (size_t k = 0; k < 3; ++k) sum = sum + from_floats(corners + 3 * k) * weights[k];
    return normalised(sum);
  }

  // The nine numbers at a point of a triangle, between those of its corners.
  std::array<double, k_harmonics> transfer_at(uint32_t triangle, Vec3 point) const {
    const std::array<double, 3> weights = weights_at(triangle, point);
    std::array<double, k_harmonics> values = {};
    for (size_t k = 0; k < 3; ++k)
      for (size_t j = 0; j < k_harmonics; ++j)
        values[j] += weights[k] *
                     static_cast<double>(standing.transfer[(3 * static_cast<size_t>(triangle) + k) * k_harmonics + j]);
    return values;
  }

  Hit closest_but_sand(Vec3 origin, Vec3 direction) const {
    Hit hit;
    if (direction.y < 0.0 && origin.y > 0.0) {
      const double distance = -origin.y / direction.y;
      if (distance < k_far) hit = {Surface::floor, distance, {}, {0, 1, 0}, {}};
    }
    const EmbreeHit on_object = object.closest(origin, direction, hit.distance);
    if (on_object.found) {
      hit.surface = Surface::object;
      hit.distance = static_cast<double>(on_object.distance);
      hit.normal = on_object.unit_normal();
      if (dot(hit.normal, direction) > 0.0) hit.normal = hit.normal * -1.0;
      hit.reflectance = k_object;
      hit.triangle = on_object.primitive;
      if (hit.triangle >= standing.metal_from) {
        hit.surface = Surface::metal;
        hit.reflectance = k_metal;
        const Vec3 smooth = metal_normal(hit.triangle, origin + direction * hit.distance);
        if (dot(smooth, direction) < 0.0 && dot(smooth, hit.normal) > 0.0) hit.normal = smooth;
      }
    }
    hit.point = origin + direction * hit.distance;
    return hit;
  }

  // With the grains of the truth where there are any, else with the surface of the sand.
  Hit closest(Vec3 origin, Vec3 direction) const {
    Hit hit = closest_but_sand(origin, direction);
    if (grains) {
      if (const std::optional<PackedGrains::Hit> grain = grains->closest(origin, direction, hit.distance))
        hit = {Surface::sand, grain->distance, {}, grain->normal, grain->albedo};
    } else if (const EmbreeHit on_sand = surface.closest(origin, direction, hit.distance); on_sand.found) {
      hit = {Surface::sand, static_cast<double>(on_sand.distance), {}, on_sand.unit_normal(), {}};
    }
    hit.point = origin + direction * hit.distance;
    return hit;
  }

  bool blocked(Vec3 origin, Vec3 direction, double limit) const {
    return object.occluded(origin, direction, limit) || (grains && grains->occluded(origin, direction, limit));
  }
};

namespace {

double left_by(const std::vector<FloorShadow>& shadows, double x, double z) {
  double share = 1.0;
  for (const FloorShadow& shadow : shadows) share *= floor_transparency(shadow, x, z);
  return share;
}

// What the shadows leave at a place of the floor: of the light that is not the main light's, and of the main light.
struct Left {
  double ambient = 1.0, main = 1.0;
};

// Each ambient shadow leaves s and a part of the other 1 - s; the parts multiply.
double ambient_left(const std::vector<FloorShadow>& shadows, double s, double x, double z) {
  double share = 1.0;
  for (const FloorShadow& shadow : shadows)
    share *= s < 1.0 ? std::max(0.0, floor_transparency(shadow, x, z) - s) / (1.0 - s) : 1.0;
  return share;
}

Vec3 not_below_0(Vec3 v) { return {std::max(v.x, 0.0), std::max(v.y, 0.0), std::max(v.z, 0.0)}; }

// The share of the main light.
double main_of(const ShotLight& light) { return static_cast<double>(light.main_share); }

Left left_on_floor(const SceneShadows& shadows, const PlacedLight& light, double x, double z) {
  return {
      ambient_left(shadows.ambient, main_of(light.object), x, z) * ambient_left(shadows.sky, main_of(light.sand), x, z),
      left_by(shadows.object, x, z) * left_by(shadows.pile, x, z)};
}

// What the kit asks for. The main light is what faces it gets, beyond what the harmonics hold of it.
SandLight light_of_sand(const PlacedLight& light, const SceneShadows& shadows, bool textured) {
  const ShotLight& sand = light.sand;
  const Vec3 towards = main_direction_of(light.object);  // the object's shadow is made for it
  SandLight kit;
  kit.to_light = main_direction_of(sand);
  kit.sun = main_by_cosine(sand, kit.to_light);
  kit.around = [&sand](Vec3 n) { return not_below_0(shown_by(sand, n) - main_in_harmonics(sand, n)); };
  kit.around_below = [&sand](Vec3 n) { return from_floor(sand, n); };
  kit.pile_passed = [&shadows, textured](Vec3 p) { return textured ? left_by(shadows.pile_on_sand, p.x, p.z) : 1.0; };
  kit.object_passed = [&shadows, textured, towards](Vec3 p) {
    if (!textured || towards.y <= 0.0) return 1.0;
    const Vec3 foot = p - towards * (p.y / towards.y);  // where the main light through the place would meet the floor
    return left_by(shadows.object, foot.x, foot.z);
  };
  kit.under_sky = [&shadows, &light, textured](Vec3 p) {
    if (!textured) return 1.0;
    return ambient_left(shadows.ambient, main_of(light.object), p.x, p.z) *
           ambient_left(shadows.sky_on_sand, main_of(light.sand), p.x, p.z);
  };
  return kit;
}

// A direction that metal reflects light from, drawn as often as its facets lie that way, and the share that it reflects
// (Schlick).
Vec3 reflected_from(Vec3 direction, Vec3 normal, double a, double b) {
  const double cosine = std::sqrt((1.0 - a) / (1.0 + (k_metal_alpha * k_metal_alpha - 1.0) * a));
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)), turn = 2.0 * k_pi * b;
  const Vec3 facet = Frame(normal).world(sine * std::cos(turn), sine * std::sin(turn), cosine);
  const Vec3 out = direction - facet * (2.0 * dot(facet, direction));
  return dot(out, normal) > 0.0 ? out : direction - normal * (2.0 * dot(normal, direction));
}
Vec3 metal_share(Vec3 direction, Vec3 normal) {
  const double grazing = std::pow(1.0 - std::min(1.0, std::fabs(dot(direction, normal))), 5.0);
  return k_metal + (Vec3{1, 1, 1} - k_metal) * grazing;
}

// What is not seen of the room is a surface of the same colour, as bright: so light is reflected among equals.
Vec3 among_equals(double open, Vec3 reflectance) {
  const auto gain = [open](double rho) { return 1.0 / (1.0 - rho * (1.0 - open)); };
  return {gain(reflectance.x), gain(reflectance.y), gain(reflectance.z)};
}

}  // namespace

ShotPicture::ShotPicture(const LitObject& object, const SandShape& sand)
    : state_(std::make_unique<State>(object, sand)) {}

RadianceMap ShotPicture::composite(const Surroundings& room, const ShotCamera& camera, const PlacedLight& light,
                                   const SceneShadows& shadows, CastShadow cast,
                                   const ShotPictureOptions& options) const {
  const bool textured = cast == CastShadow::textures;
  const double s = main_of(light.object);
  float sh[3 * k_harmonics], turn[4];
  for (size_t k = 0; k < 4; ++k) turn[k] = static_cast<float>(state_->standing.rotation[k]);
  if (sandglass_harmonics_turn(light.object.sh, turn, sh, nullptr) != SANDGLASS_OK)
    throw cannot("turn", "light", "its harmonics are not finite");
  const auto floor_left = [&](const Hit& hit) {
    if (!textured) return 1.0;
    const Left left = left_on_floor(shadows, light, hit.point.x, hit.point.z);
    return (1.0 - s) * left.ambient + s * left.main;
  };
  const auto object_shown = [&](const Hit& hit) {
    if (state_->standing.transfer.empty()) return shown_by(light.object, hit.normal);
    const std::array<double, k_harmonics> transfer = state_->transfer_at(hit.triangle, hit.point);
    Vec3 sum;
    for (size_t j = 0; j < k_harmonics; ++j) sum = sum + from_floats(sh + 3 * j) * transfer[j];
    const double open = options.lit_by_itself ? std::clamp(transfer[0] / k_harmonic_factors[0], 0.0, 1.0) : 1.0;
    return product(not_below_0(sum), among_equals(open, hit.reflectance));
  };
  const auto metal_shown = [&](const Hit& hit, Vec3 direction, Random* random) {
    const double a = random->uniform(), b = random->uniform();
    const Vec3 from = reflected_from(direction, hit.normal, a, b);
    return product(metal_share(direction, hit.normal),
                   light.reflected ? light.reflected(from) : shown_by(light.object, from));
  };
  const SandLight light_there = light_of_sand(light, shadows, textured);
  const SandLayer sand(state_->sand, light_there, camera, {options.width, options.height, options.samples},
                       options.threads, options.kit);
  RadianceMap picture(options.width, options.height);
  const auto colour_of = [&](Vec3 direction, const SandLayer::Sample& of_sand, Random* random) {
    const Hit hit = state_->closest_but_sand(camera.eye, direction);
    if (static_cast<double>(of_sand.depth) < dot(hit.point - camera.eye, camera.forward))
      return limited(from_floats(of_sand.radiance));
    if (hit.surface == Surface::metal) return limited(metal_shown(hit, direction, random));
    if (hit.surface == Surface::none) return room.seen(camera, direction);
    if (hit.surface == Surface::floor) return room.seen(camera, direction) * floor_left(hit);
    return limited(product(hit.reflectance, object_shown(hit)));
  };
  ThreadPool(options.threads).run(static_cast<uint32_t>(options.height), [&](uint32_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < options.width; ++x) {
      Random random = random_stream(static_cast<uint64_t>(y) * 65536u + static_cast<uint64_t>(x), k_composite_stream);
      Vec3 sum;
      const int n = options.samples;
      for (int i = 0; i < n * n; ++i) {
        const double sx = x + (i % n + random.uniform()) / n, sy = y + (i / n + random.uniform()) / n;
        sum = sum + colour_of(normalised(camera.ray(sx, sy, options.width, options.height)), sand.at(x, y, i), &random);
      }
      picture.set(x, y, sum * (1.0 / (n * n)));
    }
  });
  return picture;
}

std::vector<ShotPicture::Seen> ShotPicture::seen(const ShotCamera& camera, int width, int height) const {
  constexpr double k_corners[4][2] = {{0.05, 0.05}, {0.95, 0.05}, {0.05, 0.95}, {0.95, 0.95}};
  std::vector<Seen> all;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto hit_at = [&](double u, double v) {
        return state_->closest(camera.eye, normalised(camera.ray(x + u, y + v, width, height)));
      };
      const Hit middle = hit_at(0.5, 0.5);
      bool same = true;
      for (const auto& corner : k_corners) same = same && hit_at(corner[0], corner[1]).surface == middle.surface;
      const auto what = static_cast<Seen::What>(same ? static_cast<int>(middle.surface) : 0);
      all.push_back({what, middle.normal});
    }
  return all;
}

// The rays of the truth.
class ShotPicture::Paths {
 public:
  Paths(const State& state, const Surroundings& room, const ShotCamera& camera)
      : state_(state),
        room_(room),
        camera_(camera),
        rotation_(room.view),
        above_(above_horizon(room.warped, room.view)),
        on_floor_(by_cosine(above_, rotation_)),
        environment_(above_, rotation_),
        floor_light_(on_floor_, rotation_) {
    const Vec3 irradiance = irradiance_of(light_of(above_, room.view));
    const auto reflects = [](double radiance, double e) { return e > 0.0 ? k_pi * radiance / e : 0.0; };
    reflectance_ = {reflects(room.floor.x, irradiance.x), reflects(room.floor.y, irradiance.y),
                    reflects(room.floor.z, irradiance.z)};
  }

  Vec3 pixel(int x, int y, const ShotPictureOptions& options) const {
    Random random = random_stream(static_cast<uint64_t>(y) * 65536u + static_cast<uint64_t>(x),
                                  k_truth_stream + (options.seed << 8));
    const double shift[2] = {random.uniform(), random.uniform()};
    Vec3 solid, background, with, without;
    int caught = 0, behind = 0;
    for (int i = 0; i < options.paths; ++i) {
      const auto even = [&](int k) { return lattice_point(shift[k], i, k_plane_steps[k]); };
      const double down = random.uniform(), across = random.uniform();
      const Vec3 direction = normalised(camera_.ray(x + across, y + down, options.width, options.height));
      const Hit hit = state_.closest(camera_.eye, direction);
      if (hit.surface == Surface::none || (hit.surface == Surface::floor && length(hit.point) > k_catcher_reach)) {
        background = background + look_up(room_.panorama, direction);
        ++behind;
        continue;
      }
      const Vec3 start = lifted(hit);
      if (hit.surface == Surface::metal) {
        const double a = random.uniform(), b = random.uniform();
        const Vec3 from = reflected_from(direction, hit.normal, a, b);
        const Vec3 radiance = arriving(start, from, k_bounces, true, &random);
        solid = solid +
                limited(product(metal_share(direction, hit.normal), radiance) * room_.exposure) * (1 / room_.exposure);
        continue;
      }
      Vec3 open;
      const Vec3 seen = direct(start, hit.normal, hit.surface, even(0), even(1), &open);
      const double second = random.uniform(), first = random.uniform();
      const Vec3 indirect =
          arriving(start, cosine_direction(hit.normal, first, second), k_bounces - 1, false, &random) * k_pi;
      if (hit.surface == Surface::floor) {
        // Without what stands on it, a level floor gets no indirect light: it sends none to itself.
        with = with + seen + indirect;
        without = without + open;
        background = background + look_up(room_.panorama, direction);
        ++caught;
        ++behind;
      } else {
        solid = solid + product(hit.reflectance, seen + indirect) * (1.0 / k_pi);
      }
    }
    const int n = options.paths;
    Vec3 radiance = solid * (1.0 / n);
    if (behind > 0) {
      const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 1.0; };
      const Vec3 kept = {ratio(with.x, without.x), ratio(with.y, without.y), ratio(with.z, without.z)};
      const double share = static_cast<double>(caught) / behind;
      radiance = radiance + product(background * (1.0 / n), kept * share + Vec3{1, 1, 1} * (1.0 - share));
    }
    return limited(radiance * room_.exposure);
  }

 private:
  // Light on the floor is sampled by its cosine too.
  static RadianceMap by_cosine(const RadianceMap& above, const ViewRotation& rotation) {
    RadianceMap on_floor = above;
    for (int v = 0; v < above.height; ++v)
      for (int u = 0; u < above.width; ++u) {
        const double up = rotation.to_panorama(panorama_direction(u, v, above.width, above.height)).y;
        on_floor.set(u, v, on_floor.colour(u, v) * std::max(up, 0.0));
      }
    return on_floor;
  }

  // The irradiance that one ray of the room's light brings. *open gets what it would bring with nothing in its way.
  Vec3 direct(Vec3 start, Vec3 normal, Surface surface, double a, double b, Vec3* open) const {
    const bool floor = surface == Surface::floor;
    const ProbeLight::Sample s = (floor ? floor_light_ : environment_).sample(a, b);
    const double cosine = floor ? 1.0 : dot(s.direction, normal);
    if (cosine <= 0.0) return Vec3{};
    if (open != nullptr) *open = s.weight * cosine;
    return state_.blocked(start, s.direction, k_far) ? Vec3{} : s.weight * cosine;
  }

  // The radiance that arrives along a ray after it met the floor, the object or the grains. Light that comes straight
  // from the room counts only where nothing but metal lies between it and the eye. To what is painted, metal is paint
  // of its colour: so no light is lost, and none is focused.
  Vec3 arriving(Vec3 origin, Vec3 direction, int bounces, bool mirrored, Random* random) const {
    Vec3 sum, throughput = {1, 1, 1};
    for (int bounce = 0; bounce < bounces; ++bounce) {
      const Hit hit = state_.closest(origin, direction);
      if (hit.surface == Surface::none) {
        if (mirrored) sum = sum + product(throughput, look_up(above_, rotation_.to_rotated(direction)));
        break;
      }
      origin = lifted(hit);
      if (mirrored && hit.surface == Surface::metal) {
        throughput = product(throughput, metal_share(direction, hit.normal));
        const double a = random->uniform(), b = random->uniform();
        direction = reflected_from(direction, hit.normal, a, b);
        continue;
      }
      if (mirrored && hit.surface == Surface::floor) {
        // What the camera shows there, times the share of its light that is left: of that the ray is one part of equals.
        const double a = random->uniform(), b = random->uniform();
        const bool dark = state_.blocked(origin, floor_light_.sample(a, b).direction, k_far);
        if (!dark) sum = sum + product(throughput, look_up(room_.panorama, hit.point - camera_.eye));
        break;
      }
      mirrored = false;
      throughput = product(throughput, hit.surface == Surface::floor ? reflectance_ : hit.reflectance);
      const double a = random->uniform(), b = random->uniform();
      sum = sum + product(throughput, direct(origin, hit.normal, hit.surface, a, b, nullptr)) * (1.0 / k_pi);
      direction = cosine_direction(hit.normal, random->uniform(), random->uniform());
    }
    return sum;
  }

  const State& state_;
  const Surroundings& room_;
  const ShotCamera& camera_;
  const ViewRotation rotation_;
  // The floor hides what lies below the horizon, and is itself what one sees there.
  const RadianceMap above_, on_floor_;
  const ProbeLight environment_, floor_light_;
  Vec3 reflectance_;  // of the floor
};

RadianceMap ShotPicture::truth(const Surroundings& room, const ShotCamera& camera,
                               const ShotPictureOptions& options) const {
  if (!state_->grains && !state_->sand.indices.empty()) state_->grains = std::make_unique<PackedGrains>(state_->sand);
  const Paths paths(*state_, room, camera);
  RadianceMap picture(options.width, options.height);
  ThreadPool(options.threads).run(static_cast<uint32_t>(options.height), [&](uint32_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < options.width; ++x) picture.set(x, y, paths.pixel(x, y, options));
  });
  return picture;
}

#else

struct ShotPicture::State {};
ShotPicture::ShotPicture(const LitObject&, const SandShape&) {
  throw Failure("cannot draw a shot: this build lacks Embree. Install it, configure and build again.");
}
RadianceMap ShotPicture::composite(const Surroundings&, const ShotCamera&, const PlacedLight&, const SceneShadows&,
                                   CastShadow, const ShotPictureOptions&) const {
  return {};
}
RadianceMap ShotPicture::truth(const Surroundings&, const ShotCamera&, const ShotPictureOptions&) const { return {}; }
std::vector<ShotPicture::Seen> ShotPicture::seen(const ShotCamera&, int, int) const { return {}; }

#endif

ShotPicture::~ShotPicture() = default;

}  // namespace sandglass::host

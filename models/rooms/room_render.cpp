#include "models/rooms/room_render.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/files/failure.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

// The highest value in an exposed panorama. Captured panoramas are limited in the same way.
constexpr double k_brightest = 5e4;
// Added before a logarithm is taken, as a share of the mean. Without it one black pixel would decide the result.
constexpr double k_darkest = 1e-4;
// The share of the colour cast that is removed, in the logarithm. Cameras leave some of the cast.
constexpr double k_balanced_out = 0.5;

}  // namespace

void expose(RadianceMap* map, double key) {
  Vec3 mean;
  double area = 0.0;
  const auto for_each = [&](auto&& visit) {
    for (int v = 0; v < map->height; ++v)
      for (int u = 0; u < map->width; ++u) visit(map->colour(u, v), pixel_solid_angle(v, map->width, map->height));
  };
  // The colour cast is measured on pixels below twice the mean. They show neither a lamp nor its reflection.
  double all = 0.0;
  for_each([&](Vec3 c, double omega) {
    all += luminance(c) * omega;
    area += omega;
  });
  const double limit = 2.0 * all / area, floor = k_darkest * all / area;
  for_each([&](Vec3 c, double omega) {
    if (luminance(c) < limit) mean = mean + c * omega;
  });
  const double grey = luminance(mean);
  const auto balance = [&](double channel) { return channel > 0.0 ? std::pow(grey / channel, k_balanced_out) : 1.0; };
  const Vec3 gains = {balance(mean.x), balance(mean.y), balance(mean.z)};
  double logarithm = 0.0;
  for_each([&](Vec3 c, double omega) { logarithm += std::log(luminance(product(c, gains)) + floor) * omega / area; });
  const double gain = key / std::exp(logarithm);
  for (int v = 0; v < map->height; ++v)
    for (int u = 0; u < map->width; ++u) {
      const Vec3 c = product(map->colour(u, v), gains) * gain;
      map->set(u, v, {std::min(c.x, k_brightest), std::min(c.y, k_brightest), std::min(c.z, k_brightest)});
    }
}

#ifndef SANDGLASS_HAVE_EMBREE

RoomPanorama trace_room(const Room&, const RoomRenderOptions&) {
  throw Failure("cannot trace a room: this build lacks Embree. Install it, configure and build again.");
}

#else

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_lift = 1e-4;    // metres; keeps rays off the surface that they leave
constexpr double k_far = 1e5;      // metres
constexpr int k_bounces = 7;       // diffuse bounces; in a white room each carries 80 % of the one before
constexpr int k_sure_bounces = 1;  // after these, a path may end by chance
constexpr int k_pilot_paths = 4096;
// The most light that one bounce after the first may add to a path. It is a multiple of the mean that all later bounces
// add together. The walls right beside a lamp are as bright as a small lamp, and paths find them only by chance.
// Without the limit, they would make sparks all over the picture.
constexpr double k_spark_limit = 25.0;
// The least cosine that is used when a lamp's chance is computed. Its middle may face away while one of its corners
// does not.
constexpr double k_facing_floor = 0.15;

EmbreeScene scene_of(const Room& room) {
  std::vector<uint32_t> indices;
  for (const RoomTriangle& t : room.triangles) indices.insert(indices.end(), t.corners, t.corners + 3);
  return EmbreeScene::triangles(room.vertices, indices);
}

struct Hit {
  bool found;
  double distance;
  Vec3 normal;  // geometric, on the side that the ray came from
  bool front;   // whether the ray hit the front side of the triangle
  uint32_t triangle;
};

// Evenly spread numbers for the first bounce of a pixel's samples. They are lattices with irrational steps, and each
// pixel has its own shift.
struct Samples {
  Random random;
  double shift[7];
  Samples(uint64_t seed, uint64_t pixel) : random(random_stream(seed, pixel)) {
    for (double& s : shift) s = random.uniform();
  }
  double even(int index, int dimension) const {
    // Two dimensions for the pixel, three for the light, two for the bounce.
    constexpr double k_steps[7] = {k_plane_steps[0], k_plane_steps[1], k_space_steps[0], k_space_steps[1],
                                   k_space_steps[2], k_plane_steps[0], k_plane_steps[1]};
    return lattice_point(shift[dimension], index, k_steps[dimension]);
  }
};

struct Tracer {
  const Room& room;
  EmbreeScene scene;
  bool sun;
  uint64_t seed;

  explicit Tracer(const Room& r)
      : room(r), scene(scene_of(r)), sun(luminance(r.sky.sun_radiance) > 0.0), seed(r.sky.skyline_seed) {}

  Hit closest(Vec3 origin, Vec3 direction) const {
    const EmbreeHit hit = scene.closest(origin, direction, k_far);
    if (!hit.found) return {false, 0.0, {}, false, 0};
    const Vec3 normal = normalised(Vec3{hit.normal[0], hit.normal[1], hit.normal[2]});
    const bool front = dot(normal, direction) < 0.0;
    return {true, static_cast<double>(hit.distance), front ? normal : normal * -1.0, front, hit.primitive};
  }
  bool occluded(Vec3 origin, Vec3 direction, double limit) const { return scene.occluded(origin, direction, limit); }

  // The window through which a ray leaves the room. -1: none, because the ray slips out between two triangles.
  int window_of(Vec3 origin, Vec3 direction) const {
    for (size_t i = 0; i < room.emitters.size(); ++i) {
      const Emitter& e = room.emitters[i];
      if (e.kind != Emitter::Kind::window) continue;
      const Vec3 normal = cross(e.edge_a, e.edge_b);
      const double facing = dot(normal, direction);
      if (facing >= 0.0) continue;
      const double t = dot(normal, e.corner - origin) / facing;
      const Vec3 in = origin + direction * t - e.corner;
      const double a = dot(in, e.edge_a) / dot(e.edge_a, e.edge_a), b = dot(in, e.edge_b) / dot(e.edge_b, e.edge_b);
      if (t >= -k_lift && a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0) return static_cast<int>(i);
    }
    return -1;
  }

  // Estimates how much light each emitter could add at a surface. The weight is 0 only where it can add nothing.
  double weigh(Vec3 p, Vec3 n, std::vector<double>* weights) const {
    double total = 0.0;
    weights->resize(room.emitters.size());
    for (size_t i = 0; i < room.emitters.size(); ++i) {
      const Emitter& e = room.emitters[i];
      double weight = 0.0;
      if (e.kind == Emitter::Kind::sphere) {
        const Vec3 to = e.centre - p;
        const double d2 = dot(to, to), above = dot(to, n) + e.radius;
        if (above > 0.0 && d2 > e.radius * e.radius)
          weight = luminance(e.radiance) * k_pi * e.radius * e.radius / d2 *
                   std::max(dot(to, n) / std::sqrt(d2), k_facing_floor);
      } else {
        const Vec3 facing = cross(e.edge_a, e.edge_b), middle = e.corner + (e.edge_a + e.edge_b) * 0.5, to = middle - p;
        const double area = length(facing), behind = dot(facing, e.corner - p);
        const double reach = 0.5 * (std::fabs(dot(e.edge_a, n)) + std::fabs(dot(e.edge_b, n)));
        if (behind < 0.0 && dot(to, n) + reach > 0.0) {
          const double d2 = dot(to, to), d = std::sqrt(d2);
          const double bright = luminance(e.kind == Emitter::Kind::window ? room.sky.horizon : e.radiance);
          weight = bright * area / (d2 + 0.25 * area) * std::max(-dot(facing, to) / (area * d), k_facing_floor) *
                   std::max(dot(to, n) / d, k_facing_floor);
        }
      }
      (*weights)[i] = weight;
      total += weight;
    }
    return total;
  }

  // The density, per solid angle, with which aim() chooses `direction` from p, given emitter e.
  static double density(const Emitter& e, Vec3 p, Vec3 direction) {
    if (e.kind == Emitter::Kind::sphere) {
      const Vec3 to = e.centre - p;
      const double sine2 = e.radius * e.radius / dot(to, to);
      return sine2 < 1.0 ? 1.0 / (2.0 * k_pi * (1.0 - std::sqrt(1.0 - sine2))) : 0.0;
    }
    const Vec3 facing = cross(e.edge_a, e.edge_b);
    const double area = length(facing), cosine = -dot(facing, direction) / area;
    if (cosine <= 1e-6) return 0.0;
    const double t = dot(facing, e.corner - p) / dot(facing, direction);
    return t * t / (area * cosine);
  }

  struct Aim {
    Vec3 direction;
    double distance;
  };
  static Aim aim(const Emitter& e, Vec3 p, double a, double b) {
    if (e.kind == Emitter::Kind::sphere) {
      const Vec3 to = e.centre - p;
      const double d2 = dot(to, to), d = std::sqrt(d2),
                   cosine_min = std::sqrt(std::max(0.0, 1.0 - e.radius * e.radius / d2));
      const double cosine = 1.0 - a * (1.0 - cosine_min), sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
      const double angle = 2.0 * k_pi * b;
      const Vec3 direction = Frame(to * (1.0 / d)).world(sine * std::cos(angle), sine * std::sin(angle), cosine);
      const double inside = std::max(0.0, e.radius * e.radius - d2 * sine * sine);
      return {direction, d * cosine - std::sqrt(inside)};
    }
    const Vec3 to = e.corner + e.edge_a * a + e.edge_b * b - p;
    const double d = length(to);
    return {to * (1.0 / d), e.kind == Emitter::Kind::window ? k_far : d * (1.0 - 1e-4)};
  }

  // An estimate of the light that reaches p straight from the emitters and the sun: the integral of radiance times the
  // cosine to the normal n. It samples one emitter.
  Vec3 direct(Vec3 p, Vec3 n, const std::vector<double>& weights, double total, double choice, double a, double b,
              Random* random) const {
    Vec3 sum;
    if (total > 0.0) {
      double rest = choice * total;
      size_t i = 0;
      while (i + 1 < weights.size() && rest >= weights[i]) rest -= weights[i++];
      const Emitter& e = room.emitters[i];
      if (weights[i] > 0.0) {
        const Aim to = aim(e, p, a, b);
        const double cosine = dot(to.direction, n), chosen = weights[i] / total * density(e, p, to.direction);
        const Vec3 radiance = e.kind == Emitter::Kind::window ? sky_radiance(room.sky, to.direction) : e.radiance;
        if (cosine > 0.0 && chosen > 0.0 && !occluded(p, to.direction, to.distance))
          sum = radiance * (cosine / (chosen + cosine / k_pi));  // balance heuristic against a cosine-weighted bounce
      }
    }
    if (sun) {
      const Vec3 s = room.sky.sun_direction;
      const double c = random->uniform(), d = random->uniform();
      const Vec3 to = cap_direction(s, k_sun_cosine, c, d);
      const double facing = dot(to, n);
      if (facing > 0.0 && window_of(p, to) >= 0 && !occluded(p, to, k_far))
        sum = sum + room.sky.sun_radiance * (facing * 2.0 * k_pi * (1.0 - k_sun_cosine));
    }
    return sum;
  }

  Vec3 outside(Vec3 direction) const {
    const bool at_sun = sun && dot(direction, room.sky.sun_direction) >= k_sun_cosine;
    return at_sun ? room.sky.sun_radiance : sky_radiance(room.sky, direction);
  }

  // The light, scaled down so that its luminance is at most the limit.
  static Vec3 limited(Vec3 light, double limit) {
    const double bright = luminance(light);
    return bright > limit ? light * (limit / bright) : light;
  }

  struct PathLight {
    // `first` is what the ray sees and what the first bounce adds. Later bounces add to `later`.
    Vec3 first, later;
    Vec3 sum() const { return first + later; }
  };

  PathLight path(Vec3 origin, Vec3 direction, Samples* samples, int index, double limit,
                 std::vector<double>* weights) const {
    PathLight sum;
    const auto add = [&](int bounce, Vec3 light) {
      if (bounce == 0) sum.first = sum.first + light;
      else sum.later = sum.later + limited(light, limit);
    };
    Vec3 throughput = {1, 1, 1};
    bool seen_directly = true;  // through the lens or a mirror, so no surface aimed at this light before
    double bounce_density = 0.0, total = 0.0;
    Vec3 from = origin;
    for (int bounce = 0, mirrors = 0; bounce <= k_bounces;) {
      const Hit hit = closest(origin, direction);
      int emitter = -1;
      Vec3 radiance;
      if (!hit.found) {
        emitter = window_of(origin, direction);
        radiance = seen_directly ? outside(direction) : sky_radiance(room.sky, direction);
        if (emitter < 0 && !seen_directly) radiance = {};
      } else if (room.triangles[hit.triangle].emitter >= 0 && hit.front) {
        emitter = room.triangles[hit.triangle].emitter;
        radiance = room.emitters[static_cast<size_t>(emitter)].radiance;
      }
      if (emitter >= 0 || !hit.found) {
        double share = 1.0;
        if (!seen_directly && emitter >= 0) {
          const auto e = static_cast<size_t>(emitter);
          const double aimed = total > 0.0 ? (*weights)[e] / total * density(room.emitters[e], from, direction) : 0.0;
          share = bounce_density / (bounce_density + aimed);
        }
        // Direct light at the first surface has two parts: rays that hit a lamp, here, and rays aimed at one.
        add(bounce <= 1 ? 0 : bounce, product(throughput, radiance) * share);
        if (!hit.found || luminance(radiance) > 0.0) return sum;
      }
      const Vec3 point = origin + direction * hit.distance, p = point + hit.normal * k_lift;
      const RoomMaterial& material = room.materials[room.triangles[hit.triangle].material];
      const Vec3 colour = reflectance(material, point, hit.normal);
      if (material.coat > 0.0 && seen_directly && mirrors < 3) {
        const double facing = -dot(direction, hit.normal);
        const double fresnel = material.coat + (1.0 - material.coat) * std::pow(1.0 - facing, 5.0);
        if (samples->random.uniform() < fresnel) {
          const double r = material.coat_blur * std::sqrt(samples->random.uniform());
          const double angle = 2.0 * k_pi * samples->random.uniform();
          const Vec3 mirrored = direction + hit.normal * (2.0 * facing);
          direction = normalised(Frame(mirrored).world(r * std::cos(angle), r * std::sin(angle), 1.0));
          if (dot(direction, hit.normal) <= 0.0) return sum;
          origin = p;
          ++mirrors;
          continue;
        }
      }
      const bool first = bounce == 0 && mirrors == 0;
      const auto number = [&](int dimension) {
        return first ? samples->even(index, dimension) : samples->random.uniform();
      };
      total = weigh(p, hit.normal, weights);
      throughput = product(throughput, colour);
      const double choice = number(2), a = number(3), b = number(4);
      const Vec3 arriving = direct(p, hit.normal, *weights, total, choice, a, b, &samples->random);
      add(bounce, product(throughput, arriving) * (1.0 / k_pi));
      if (++bounce > k_sure_bounces) {
        const double go_on = std::min(0.95, std::max({throughput.x, throughput.y, throughput.z}));
        if (samples->random.uniform() >= go_on) return sum;
        throughput = throughput * (1.0 / go_on);
      }
      const double c = bounce == 1 && mirrors == 0 ? samples->even(index, 5) : samples->random.uniform();
      const double d = bounce == 1 && mirrors == 0 ? samples->even(index, 6) : samples->random.uniform();
      direction = cosine_direction(hit.normal, c, d);
      bounce_density = std::max(1e-9, dot(direction, hit.normal) / k_pi);
      origin = from = p;
      seen_directly = false;
    }
    return sum;
  }

  double mean_of_later_light() const {
    std::vector<double> weights;
    double sum = 0.0;
    for (int i = 0; i < k_pilot_paths; ++i) {
      Samples samples(~seed, static_cast<uint64_t>(i));
      const double y = 1.0 - 2.0 * samples.even(i, 0), turn = 2.0 * k_pi * samples.even(i, 1);
      const Vec3 direction = direction_of_angles(std::acos(std::clamp(y, -1.0, 1.0)), turn);
      sum += luminance(path(room.eye, direction, &samples, i, 1e30, &weights).later);
    }
    return sum / k_pilot_paths;
  }

  double depth(Vec3 direction) const {
    const Hit hit = closest(room.eye, direction);
    double distance = hit.found ? hit.distance : k_far;
    if (const int window = window_of(room.eye, direction); window >= 0) {
      const Emitter& e = room.emitters[static_cast<size_t>(window)];
      const Vec3 normal = cross(e.edge_a, e.edge_b);
      distance = std::min(distance, dot(normal, e.corner - room.eye) / dot(normal, direction));
    }
    return distance;
  }
};

}  // namespace

RoomPanorama trace_room(const Room& room, const RoomRenderOptions& options) {
  const int width = options.width, height = options.width / 2;
  const Tracer tracer(room);
  RoomPanorama result = {RadianceMap(width, height),
                         std::vector<float>(static_cast<size_t>(width) * static_cast<size_t>(height))};
  const double limit = k_spark_limit * tracer.mean_of_later_light();
  Progress progress("tracing rows", static_cast<uint64_t>(height));
  ThreadPool(options.threads).run(static_cast<uint32_t>(height), [&](uint32_t row) {
    if (interrupted()) return;
    const int v = static_cast<int>(row);
    std::vector<double> weights;
    for (int u = 0; u < width; ++u) {
      const uint64_t pixel = uint64_t{row} * static_cast<uint64_t>(width) + static_cast<uint64_t>(u);
      Samples samples(tracer.seed, pixel);
      Vec3 sum;
      for (int i = 0; i < options.samples; ++i) {
        const double du = samples.even(i, 0) - 0.5, dv = samples.even(i, 1) - 0.5;
        const Vec3 direction = panorama_direction(u + du, v + dv, width, height);
        sum = sum + tracer.path(room.eye, direction, &samples, i, limit, &weights).sum();
      }
      result.radiance.set(u, v, sum * (1.0 / options.samples));
      result.depth[pixel] = static_cast<float>(tracer.depth(panorama_direction(u, v, width, height)));
    }
  });
  if (!interrupted()) progress.done(static_cast<uint64_t>(height));
  return result;
}

#endif

}  // namespace sandglass::host

// Balls are thrown at random into the layer, three times as many as fit; one that would come too near another is not taken.
#include "models/compositing/grains.h"

#ifdef SANDGLASS_HAVE_EMBREE

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "models/kit/grain_block.h"
#include "models/tracing/embree_scene.h"
#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

constexpr double k_diameter = 0.6e-3;                  // metres, of a mean grain
constexpr double k_smallest = 0.78, k_largest = 1.22;  // of it
constexpr double k_deep = 2.2, k_below = 0.4;          // diameters: the layer, and the ground under it
constexpr double k_tries = 3.0;                        // for each cube of a diameter
constexpr double k_nearest = 0.84;                     // of the sum of two radii
constexpr Vec3 k_ground = {0.62, 0.48, 0.32};
constexpr uint64_t k_stream = 43;

// Places of balls by cells of a diameter, hashed.
class Cells {
 public:
  Cells() : first_(size_t{1} << k_bits, -1) {}
  // Whether a ball of radius r there is away from all others.
  bool free(const std::vector<float>& balls, Vec3 p, double r) const {
    for (int i = 0; i < 27; ++i)
      for (int32_t k = first_[slot(p, i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)]; k >= 0;
           k = next_[static_cast<size_t>(k)]) {
        const float* ball = &balls[4 * static_cast<size_t>(k)];
        const Vec3 off = from_floats(ball) - p;
        const double distance_min = k_nearest * (r + static_cast<double>(ball[3]));
        if (dot(off, off) < distance_min * distance_min) return false;
      }
    return true;
  }
  void add(Vec3 p) {
    const size_t at = slot(p, 0, 0, 0);
    next_.push_back(first_[at]);
    first_[at] = static_cast<int32_t>(next_.size() - 1);
  }

 private:
  static constexpr int k_bits = 22;
  static size_t slot(Vec3 p, int dx, int dy, int dz) {
    const auto cell = [](double v, int d) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / k_diameter)) + d);
    };
    return mix_bits(cell(p.x, dx) * 73856093u ^ cell(p.y, dy) * 19349663u ^ cell(p.z, dz) * 83492791u) >> (64 - k_bits);
  }
  std::vector<int32_t> first_, next_;
};

struct Made {
  std::vector<float> balls;  // middle and radius
  std::vector<Vec3> albedos;
  std::vector<float> ground;
};

Vec3 albedo(Random* random) {
  double kind = random->uniform();
  size_t m = 0;
  while (m < 3 && kind > static_cast<double>(kit::k_beach[m].share))
    kind -= static_cast<double>(kit::k_beach[m++].share);
  const Vec3 colour = from_floats(kit::k_beach[m].albedo) * (0.8 + 0.4 * random->uniform());
  constexpr double k_albedo_max = 0.97;
  return {std::min(colour.x, k_albedo_max), std::min(colour.y, k_albedo_max), std::min(colour.z, k_albedo_max)};
}

Made packed(const SandShape& shape) {
  Made made;
  Cells cells;
  Random random = random_stream(1, k_stream);
  const auto normal = [&](uint32_t v) {
    const int8_t* n = shape.vertices[v].normal;
    return Vec3{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])} * (1.0 / 127.0);
  };
  for (uint32_t v = 0; v < shape.vertices.size(); ++v) {
    float place[3];
    to_floats(shape.position(v) - normal(v) * ((k_deep + k_below) * k_diameter), place);
    made.ground.insert(made.ground.end(), place, place + 3);
  }
  for (size_t t = 0; t + 2 < shape.indices.size(); t += 3) {
    const uint32_t* i = &shape.indices[t];
    const Vec3 a = shape.position(i[0]), b = shape.position(i[1]), c = shape.position(i[2]);
    if (std::max({a.y, b.y, c.y}) < -0.5 * k_diameter) continue;
    const double area = 0.5 * length(cross(b - a, c - a));
    const double wanted = area * k_deep / (k_diameter * k_diameter) * k_tries;
    const int tries = static_cast<int>(wanted + random.uniform());
    for (int k = 0; k < tries; ++k) {
      const double u = std::sqrt(random.uniform()), v = random.uniform();
      const double share[3] = {1 - u, u * (1 - v), u * v};
      const Vec3 up = normalised(normal(i[0]) * share[0] + normal(i[1]) * share[1] + normal(i[2]) * share[2]);
      const double r = 0.5 * k_diameter * (k_smallest + (k_largest - k_smallest) * random.uniform());
      Vec3 p = a * share[0] + b * share[1] + c * share[2] - up * (0.6 * r + k_deep * k_diameter * random.uniform());
      p.y = std::max(p.y, 0.7 * r);
      if (!cells.free(made.balls, p, r)) continue;
      cells.add(p);
      float ball[4] = {0, 0, 0, static_cast<float>(r)};
      to_floats(p, ball);
      made.balls.insert(made.balls.end(), ball, ball + 4);
      made.albedos.push_back(albedo(&random));
    }
  }
  return made;
}

}  // namespace

struct PackedGrains::State {
  Made made;
  EmbreeScene balls, ground;
  State(Made&& of, const SandShape& shape)
      : made(std::move(of)),
        balls(EmbreeScene::spheres(made.balls)),
        ground(EmbreeScene::triangles(made.ground, shape.indices)) {}
};

PackedGrains::PackedGrains(const SandShape& shape) : state_(std::make_unique<State>(packed(shape), shape)) {}
PackedGrains::~PackedGrains() = default;

std::optional<PackedGrains::Hit> PackedGrains::closest(Vec3 origin, Vec3 direction, double limit) const {
  const EmbreeHit grain = state_->balls.closest(origin, direction, limit);
  const double nearest = grain.found ? static_cast<double>(grain.distance) : limit;
  if (const EmbreeHit ground = state_->ground.closest(origin, direction, nearest); ground.found) {
    const Vec3 normal = ground.unit_normal();
    return Hit{static_cast<double>(ground.distance), normal * (dot(normal, direction) > 0.0 ? -1.0 : 1.0), k_ground};
  }
  if (!grain.found) return std::nullopt;
  const Vec3 middle = from_floats(&state_->made.balls[4 * size_t{grain.primitive}]);
  return Hit{nearest, normalised(origin + direction * nearest - middle), state_->made.albedos[grain.primitive]};
}

bool PackedGrains::occluded(Vec3 origin, Vec3 direction, double limit) const {
  return state_->balls.occluded(origin, direction, limit) || state_->ground.occluded(origin, direction, limit);
}

}  // namespace sandglass::host

#endif

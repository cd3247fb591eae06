// A packet holds sixteen rays. They share their origin and go to 4 x 4 neighbouring blocks of the light, so they visit
// the same nodes. Directions come from prepared sets in the light's own frame. A texel picks its set by a hash of its
// number, so results depend on neither thread nor order.
//
// All samples of a texel are stratified together. The light is cut into points^2 * light^2 strata. Each block of
// points^2 neighbouring strata gives one stratum to every point, in random order. Strata are squares, mapped onto the
// disk so that areas keep their ratio (Shirley and Chiu 1997), so they are compact. Strata in rings and sectors, for
// each point alone, gave the armadillo's textures a noise of 0.0081 (RMSE). These give 0.0056 for the same rays.
#include "models/baking/truth.h"

#include <algorithm>
#include <cmath>

#include "models/files/failure.h"
#include "models/tracing/embree_scene.h"
#include "models/work/random.h"
#include "sandglass/sampling.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_packet = EmbreeScene::k_packet;
constexpr uint32_t k_sets = 64;      // sets of light samples, each with its own jitter and order
constexpr double k_thinnest = 1e-6;  // in units of the object's size; floats resolve 1e-7
// Sizes lie between 1 / limit and the limit. Beyond, squares leave the range of a float.
constexpr double k_size_limit = 1e18;

double unit(uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace

StandingObject stand_on_plane(const Mesh& mesh, const std::string& name) {
  double low[3], high[3];
  for (size_t axis = 0; axis < 3; ++axis) {
    low[axis] = INFINITY;
    high[axis] = -INFINITY;
  }
  for (const uint32_t index : mesh.indices)
    for (size_t axis = 0; axis < 3; ++axis) {
      const double x = static_cast<double>(mesh.vertices.at(3 * size_t{index} + axis));
      if (!std::isfinite(x))
        throw cannot("bake", name, "it has a vertex that is not finite",
                     "Repair it in a mesh editor and export it again");
      low[axis] = std::min(low[axis], x);
      high[axis] = std::max(high[axis], x);
    }
  if (mesh.indices.empty()) throw cannot("bake", name, "it has no triangles", "Export it as a surface of polygons");

  StandingObject object;
  const double extent[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  object.scale = std::max({extent[0], extent[1], extent[2]});
  const double distance = std::max({std::fabs(low[0]), std::fabs(low[1]), std::fabs(low[2]), std::fabs(high[0]),
                                    std::fabs(high[1]), std::fabs(high[2])});
  if (!(object.scale > 1 / k_size_limit && object.scale < k_size_limit))
    throw cannot("bake", name, "its size is out of range", "Scale it to metres");
  if (object.scale < 1e-4 * distance)
    throw cannot("bake", name, "it lies so far from its origin that rounding spoils its shape", "Move it there");
  if (extent[1] < k_thinnest * object.scale)
    throw cannot("bake", name, "it is flat and lies in the ground, where it casts no shadow", "Turn it: y is up");
  if (extent[0] < k_thinnest * object.scale && extent[2] < k_thinnest * object.scale)
    throw cannot("bake", name, "it is a line without width, which casts no shadow", "Name another mesh");

  object.origin[0] = 0.5 * (low[0] + high[0]);
  object.origin[1] = low[1];
  object.origin[2] = 0.5 * (low[2] + high[2]);
  object.box = {0.5 * extent[0] / object.scale, 0.5 * extent[2] / object.scale, extent[1] / object.scale};
  object.mesh = mesh;
  for (size_t i = 0; i < mesh.vertices.size(); ++i)
    object.mesh.vertices[i] =
        static_cast<float>((static_cast<double>(mesh.vertices[i]) - object.origin[i % 3]) / object.scale);
  return object;
}

struct ShadowCaster::Scene {
  explicit Scene(const Mesh& mesh)
      : object(EmbreeScene::triangles(mesh.vertices, mesh.indices, RTC_BUILD_QUALITY_HIGH)) {}

  EmbreeScene object;
  uint64_t seed = 0;
  SampleCounts counts;
  uint32_t light_count = 0;  // samples of one point, a multiple of k_packet
  uint32_t set_count = 0;    // samples of all points of a texel
  // k_sets * set_count directions, point by point: components along two axes across the light and along the light.
  std::vector<float> across, beside, along;
};

ShadowCaster::ShadowCaster(const Mesh& mesh, double half_angle, SampleCounts counts, uint64_t seed)
    : scene_(std::make_unique<Scene>(mesh)) {
  Scene& s = *scene_;
  s.seed = seed;
  s.counts = counts;
  s.light_count = counts.light * counts.light;
  s.set_count = s.light_count * counts.points * counts.points;
  if (counts.light % 4 != 0 || counts.points == 0)
    throw Failure(
        "cannot trace: strata of the light come in multiples of 4 per axis, and one point a texel. Report this.");

  // Samples are uniform in solid angle, so the cosine is uniform between that of the rim and 1. The form
  // 1 - cos = 2 sin^2(half the angle) keeps the digits of small lights.
  const double sine = std::sin(0.5 * half_angle), depth = 2 * sine * sine;
  const uint32_t side = counts.light, parts = counts.points * counts.points, fine = side * counts.points;
  s.across.resize(size_t{k_sets} * s.set_count);
  s.beside.resize(s.across.size());
  s.along.resize(s.across.size());
  std::vector<uint32_t> order(parts);
  for (uint32_t set = 0; set < k_sets; ++set)
    for (uint32_t block = 0; block < s.light_count; ++block) {
      const uint32_t patch = block / k_packet, cell = block % k_packet;
      const uint32_t a = 4 * (patch / (side / 4)) + cell / 4, b = 4 * (patch % (side / 4)) + cell % 4;
      uint64_t random = random_mix(random_mix(seed ^ 0xA5A5ull) + (uint64_t{set} * side + a) * side + b);
      for (uint32_t i = 0; i < parts; ++i) {
        random = random_mix(random);
        const uint32_t other = static_cast<uint32_t>(random % (i + 1));
        order[i] = order[other];
        order[other] = i;
      }
      for (uint32_t point = 0; point < parts; ++point) {
        random = random_mix(random);
        const double x = 2 * (a * counts.points + order[point] / counts.points + unit(random)) / fine - 1;
        random = random_mix(random);
        const double y = 2 * (b * counts.points + order[point] % counts.points + unit(random)) / fine - 1;
        const bool wide = std::fabs(x) > std::fabs(y);
        const double radius = wide ? x : y, turn = radius == 0 ? 0 : 0.25 * k_pi * (wide ? y : x) / radius;
        const double azimuth = wide ? turn : 0.5 * k_pi - turn;
        const double drop = depth * radius * radius;  // 1 - cos
        const double ring = std::copysign(std::sqrt(drop * (2 - drop)), radius);
        const size_t at = (size_t{set} * parts + point) * s.light_count + block;
        s.across[at] = static_cast<float>(ring * std::cos(azimuth));
        s.beside[at] = static_cast<float>(ring * std::sin(azimuth));
        s.along[at] = static_cast<float>(1 - drop);
      }
    }
}

ShadowCaster::~ShadowCaster() = default;

void ShadowCaster::texels(const ShadowRectangle& rectangle, const Direction& light, uint64_t stream, uint32_t size_x,
                          uint32_t size_y, const uint32_t* uv, uint32_t count, float* values) const {
  const Scene& s = *scene_;
  // Two axes perpendicular to the light; the first is horizontal.
  const double flat = std::hypot(light[0], light[2]);
  const double across[3] = {flat > 0 ? light[2] / flat : 1, 0, flat > 0 ? -light[0] / flat : 0};
  const double beside[3] = {light[1] * across[2], light[2] * across[0] - light[0] * across[2], -light[1] * across[0]};
  const size_t samples = s.along.size();
  std::vector<float> direction(3 * samples);
  for (size_t i = 0; i < samples; ++i)
    for (size_t axis = 0; axis < 3; ++axis)
      direction[axis * samples + i] = static_cast<float>(static_cast<double>(s.across[i]) * across[axis] +
                                                         static_cast<double>(s.beside[i]) * beside[axis] +
                                                         static_cast<double>(s.along[i]) * light[axis]);
  const float *dx = direction.data(), *dy = dx + samples, *dz = dy + samples;

  const uint32_t side = s.counts.points;
  const double step_x = (rectangle.high_x - rectangle.low_x) / size_x;
  const double step_z = (rectangle.high_z - rectangle.low_z) / size_y;
  for (uint32_t texel = 0; texel < count; ++texel) {
    const uint32_t u = uv[2 * texel], v = uv[2 * texel + 1];
    uint64_t random = random_mix(random_mix(s.seed + 0x51ull) + (stream * size_y + v) * size_x + u);
    const size_t set = (random >> 56) % k_sets * s.set_count;
    float visible = 0, all = 0;
    for (uint32_t point = 0; point < side * side; ++point) {
      random = random_mix(random);
      const double jitter_x = unit(random << 20), jitter_z = unit((random << 40) | (random & 0xFFFFF) << 20);
      const size_t first = set + size_t{point} * s.light_count;
      const double x = rectangle.low_x + step_x * (u + (point % side + jitter_x) / side);
      const double z = rectangle.low_z + step_z * (v + (point / side + jitter_z) / side);
      for (uint32_t packet = 0; packet < s.light_count; packet += k_packet) {
        const size_t from = first + packet;
        const uint32_t hidden = s.object.hidden(x, z, dx + from, dy + from, dz + from);
        for (uint32_t i = 0; i < k_packet; ++i) {
          const float weight = std::max(dy[from + i], 0.0f);  // light from below the horizon does not reach the plane
          all += weight;
          visible += (hidden >> i & 1) != 0 ? 0.0f : weight;
        }
      }
    }
    values[texel] = all > 0 ? visible / all : 1.0f;
  }
}

std::vector<float> whole_texture(uint32_t size, ThreadPool& pool,
                                 const std::function<void(const uint32_t*, uint32_t, float*)>& fill) {
  constexpr uint32_t k_rows = 16;
  std::vector<float> values(size_t{size} * size);
  pool.run((size + k_rows - 1) / k_rows, [&](uint32_t band) {
    const uint32_t begin = band * k_rows, end = std::min(size, begin + k_rows);
    std::vector<uint32_t> uv;
    for (uint32_t v = begin; v < end; ++v)
      for (uint32_t u = 0; u < size; ++u) uv.insert(uv.end(), {u, v});
    fill(uv.data(), (end - begin) * size, &values[size_t{begin} * size]);
  });
  return values;
}

std::vector<float> ShadowCaster::texture(const ShadowRectangle& rectangle, const Direction& light, uint64_t stream,
                                         uint32_t size, ThreadPool& pool) const {
  return whole_texture(size, pool, [&](const uint32_t* uv, uint32_t count, float* values) {
    texels(rectangle, light, stream, size, size, uv, count, values);
  });
}

std::vector<Direction> ring_directions(double polar_max, uint32_t count) {
  std::vector<float> points(3 * size_t{count});
  const char* reason = nullptr;
  if (sandglass_sample_ring(1.0f, 0.0f, static_cast<float>(polar_max), points.data(), count, &reason) != SANDGLASS_OK)
    throw cannot("choose", "lights", reason);
  std::vector<Direction> directions(count);
  for (size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(points[3 * i]), y = static_cast<double>(points[3 * i + 1]),
                 z = static_cast<double>(points[3 * i + 2]), length = std::sqrt(x * x + y * y + z * z);
    directions[i] = {x / length, y / length, z / length};
  }
  return directions;
}

}  // namespace sandglass::host

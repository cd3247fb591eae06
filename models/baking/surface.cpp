// See surface.h. Directions are drawn with the density cosine / pi, so a coefficient is the mean of the harmonic over
// the directions that are free.
#include "models/baking/surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "models/tracing/directions.h"
#include "models/work/random.h"
#include "runtime/light/harmonics.h"

namespace sandglass::host {
namespace {

static_assert(k_transfer == k_harmonics);
constexpr uint32_t k_strata = 24;  // of the hemisphere along each axis
constexpr double k_lift = 1e-4;    // of the object's size: where rays start above the surface
constexpr uint64_t k_stream = 0x5FACE;
constexpr uint32_t k_task = 64, k_tasks = 64;  // points of a task, tasks between two calls of go_on

// A crease: the cosine of 40 degrees.
constexpr double k_crease = 0.766;

Vec3 vertex(const Mesh& mesh, uint32_t i) { return from_floats(&mesh.vertices[3 * size_t{i}]); }

constexpr double k_longest_edge = 1.0 / 16;  // of the mesh's size
constexpr double k_buried = 0.02;            // of the hemisphere

void trace_point(const EmbreeScene& object, const SurfacePoint& point, uint64_t random, float* transfer) {
  double sums[k_transfer] = {};
  const Vec3 from = point.position + point.normal * k_lift;
  for (uint32_t i = 0; i < k_strata * k_strata; ++i) {
    random = random_mix(random);
    const double a = (i % k_strata + random_unit(random)) / k_strata;
    random = random_mix(random);
    const Vec3 d = cosine_direction(point.normal, a, (i / k_strata + random_unit(random)) / k_strata);
    if (object.occluded(from, d, INFINITY)) continue;
    const double direction[3] = {d.x, d.y, d.z};
    double polynomials[k_transfer];
    harmonic_polynomials(direction, polynomials);
    for (uint32_t j = 0; j < k_transfer; ++j) sums[j] += k_harmonic_factors[j] * polynomials[j];
  }
  for (uint32_t j = 0; j < k_transfer; ++j) transfer[j] = static_cast<float>(sums[j] / (k_strata * k_strata));
}

}  // namespace

std::vector<SurfacePoint> surface_points(const Mesh& coarse) {
  const Mesh mesh = with_short_edges(coarse, k_longest_edge * box_of(coarse).longest_side());
  struct Side {
    Vec3 first, sum;  // the normal of the first triangle, and the weighted sum
  };
  std::vector<std::vector<Side>> sides(mesh.vertex_count());
  const double turn = signed_volume(mesh) < 0 ? -1 : 1;
  for (size_t t = 0; t < mesh.indices.size(); t += 3)
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t i = mesh.indices[t + corner];
      const Vec3 a = vertex(mesh, mesh.indices[t + (corner + 1) % 3]) - vertex(mesh, i);
      const Vec3 b = vertex(mesh, mesh.indices[t + (corner + 2) % 3]) - vertex(mesh, i);
      const Vec3 across = cross(a, b);
      const double area = length(across);
      if (!(area > 0)) continue;
      const Vec3 normal = across * (turn / area), weighted = normal * std::atan2(area, dot(a, b));
      const auto found = std::find_if(sides[i].begin(), sides[i].end(),
                                      [&](const Side& side) { return dot(side.first, normal) > k_crease; });
      if (found == sides[i].end()) sides[i].push_back({normal, weighted});
      else found->sum = found->sum + weighted;
    }
  std::vector<SurfacePoint> points;
  for (uint32_t i = 0; i < mesh.vertex_count(); ++i)
    for (const Side& side : sides[i]) points.push_back({vertex(mesh, i), normalised(side.sum)});
  std::stable_sort(points.begin(), points.end(),
                   [](const SurfacePoint& a, const SurfacePoint& b) { return a.position.x < b.position.x; });
  return points;
}

std::vector<float> trace_transfer(const std::vector<SurfacePoint>& points, const EmbreeScene& object, uint64_t seed,
                                  ThreadPool& pool, const std::function<bool(uint32_t)>& go_on) {
  const uint32_t count = static_cast<uint32_t>(points.size());
  std::vector<float> transfer(size_t{count} * k_transfer);
  for (uint32_t begin = 0; begin < count;) {
    const uint32_t end = std::min(count, begin + k_task * k_tasks);
    pool.run((end - begin + k_task - 1) / k_task, [&](uint32_t task) {
      for (uint32_t i = begin + task * k_task; i < std::min(end, begin + (task + 1) * k_task); ++i)
        trace_point(object, points[i], random_mix(seed ^ k_stream) + i, &transfer[size_t{i} * k_transfer]);
    });
    begin = end;
    if (!go_on(begin) && begin < count) return {};
  }
  return transfer;
}

void drop_buried(std::vector<SurfacePoint>* points, std::vector<float>* transfer) {
  size_t kept = 0;
  for (size_t i = 0; i < points->size(); ++i) {
    const float* coefficients = transfer->data() + k_transfer * i;
    if (coefficients[0] < k_buried * k_harmonic_factors[0]) continue;
    (*points)[kept] = (*points)[i];
    std::copy(coefficients, coefficients + k_transfer, transfer->data() + k_transfer * kept);
    ++kept;
  }
  points->resize(kept);
  transfer->resize(k_transfer * kept);
}

SurfacePart round_surface(const std::vector<SurfacePoint>& points, const std::vector<float>& transfer) {
  constexpr double k_position_max = 65535;
  SurfacePart part;
  part.vertices = static_cast<uint32_t>(points.size());
  if (points.empty()) return part;
  Vec3 low = points[0].position, high = low;
  for (const SurfacePoint& p : points) {
    low = {std::min(low.x, p.position.x), std::min(low.y, p.position.y), std::min(low.z, p.position.z)};
    high = {std::max(high.x, p.position.x), std::max(high.y, p.position.y), std::max(high.z, p.position.z)};
  }
  part.low = low;
  part.step = std::max({high.x - low.x, high.y - low.y, high.z - low.z}) / k_position_max;
  for (const SurfacePoint& p : points) {
    const Vec3 place = (p.position - low) * (1 / part.step);
    for (const double x : {place.x, place.y, place.z})
      part.positions.push_back(static_cast<uint16_t>(std::clamp(std::nearbyint(x), 0.0, k_position_max)));
    for (const double x : {p.normal.x, p.normal.y, p.normal.z})
      part.normals.push_back(static_cast<int8_t>(std::nearbyint(127 * x)));
  }
  part.steps.assign(k_transfer, 0.0f);
  for (size_t i = 0; i < transfer.size(); ++i)
    part.steps[i % k_transfer] = std::max(part.steps[i % k_transfer], std::fabs(transfer[i]) / 127);
  for (size_t i = 0; i < transfer.size(); ++i) {
    const float step = part.steps[i % k_transfer];
    part.transfer.push_back(static_cast<int8_t>(step > 0 ? std::nearbyint(transfer[i] / step) : 0.0f));
  }
  return part;
}

}  // namespace sandglass::host

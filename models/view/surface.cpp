// See surface.h.
#include "models/view/surface.h"

#include <cmath>
#include <numbers>

#include "models/geometry/vec3.h"
#include "models/mesh/generated.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_around = 64;

// A sphere when `half` is 0. The outline goes from the lower pole to the upper one.
Mesh capsule_mesh(double radius, double half) {
  constexpr int k_steps = k_around / 4;  // from a pole to the equator
  Profile outline;
  for (int step = -k_steps; step <= k_steps; ++step) {
    const double angle = 0.5 * std::numbers::pi * step / k_steps;
    const double r = std::abs(step) == k_steps ? 0.0 : radius * std::cos(angle), y = radius * std::sin(angle);
    if (step <= 0) outline.push_back({r, y - half});
    if (step > 0 || (step == 0 && half > 0.0)) outline.push_back({r, y + half});
  }
  return make_revolved(outline, k_around);
}

}  // namespace

Mesh collider_mesh(const sandglass_collider& collider, const Mesh* of_field) {
  const float* size = collider.size;
  const float edges[3] = {2 * size[0], 2 * size[1], 2 * size[2]};
  float low[3], high[3];
  if (collider.shape == SANDGLASS_SHAPE_BOX) return make_box(edges);
  if (collider.shape == SANDGLASS_SHAPE_SPHERE) return capsule_mesh(static_cast<double>(size[0]), 0.0);
  if (collider.shape == SANDGLASS_SHAPE_CAPSULE)
    return capsule_mesh(static_cast<double>(size[0]), static_cast<double>(size[1]));
  if (collider.shape != SANDGLASS_SHAPE_FIELD || of_field == nullptr) return {};
  Mesh mesh = *of_field;
  const bool container = sandglass_field_bounds(collider.field, low, high) == SANDGLASS_SOLID_OUTSIDE;
  if ((signed_volume(mesh) < 0.0) != container)
    for (size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

std::vector<float> flat_triangles(const Mesh& mesh) {
  std::vector<float> floats;
  floats.reserve(6 * mesh.indices.size());
  const auto corner = [&](size_t i) { return from_floats(&mesh.vertices[3 * mesh.indices[i]]); };
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    float normal[3];
    to_floats(normalised(cross(corner(i + 1) - corner(i), corner(i + 2) - corner(i))), normal);
    for (size_t k = i; k < i + 3; ++k) {
      const float* position = &mesh.vertices[3 * mesh.indices[k]];
      floats.insert(floats.end(), position, position + 3);
      floats.insert(floats.end(), normal, normal + 3);
    }
  }
  return floats;
}

}  // namespace sandglass::host

// Fields become surfaces by surface nets (Gibson 1998). Each cell that the surface passes has one vertex: the mean of
// the places where the surface crosses the cell's edges. Each crossed edge has one quad, between the four cells around
// it.
#include "models/view/surface.h"

#include <cmath>
#include <numbers>

#include "runtime/granular/field.h"

namespace sandglass::host {

namespace {

constexpr int k_around = 32, k_half_rings = 8;

void add_vertex(Surface* surface, const float position[3], const float normal[3]) {
  surface->vertices.insert(surface->vertices.end(), position, position + 3);
  surface->vertices.insert(surface->vertices.end(), normal, normal + 3);
}

// Two triangles. Seen from the front, a b c d run counter-clockwise.
void add_quad(Surface* surface, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  surface->indices.insert(surface->indices.end(), {a, b, c, a, c, d});
}

Surface box_surface(const float half[3]) {
  Surface surface;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const uint32_t first = surface.vertex_count();
      constexpr float k_corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
      for (const auto& corner : k_corners) {
        float position[3], normal[3] = {};
        position[axis] = side * half[axis], normal[axis] = side;
        position[u] = corner[0] * half[u], position[v] = corner[1] * half[v];
        add_vertex(&surface, position, normal);
      }
      if (side > 0.0f) add_quad(&surface, first, first + 1, first + 2, first + 3);
      else add_quad(&surface, first + 3, first + 2, first + 1, first);
    }
  return surface;
}

// A capsule, or a sphere when `half` is 0. Its rings go from the lower pole to the upper one, with the equator twice.
Surface capsule_surface(float radius, float half) {
  Surface surface;
  const int rings = 2 * k_half_rings + 2;
  for (int ring = 0; ring < rings; ++ring) {
    const bool upper = ring > k_half_rings;
    const double polar = std::numbers::pi * (upper ? ring - 1 : ring) / (2 * k_half_rings);
    for (int i = 0; i <= k_around; ++i) {
      const double turn = 2.0 * std::numbers::pi * i / k_around;
      const float normal[3] = {static_cast<float>(std::sin(polar) * std::cos(turn)),
                               static_cast<float>(-std::cos(polar)),
                               static_cast<float>(std::sin(polar) * std::sin(turn))};
      const float position[3] = {radius * normal[0], radius * normal[1] + (upper ? half : -half), radius * normal[2]};
      add_vertex(&surface, position, normal);
    }
  }
  for (int ring = 0; ring + 1 < rings; ++ring)
    for (int i = 0; i < k_around; ++i) {
      const uint32_t a = static_cast<uint32_t>(ring * (k_around + 1) + i), b = a + k_around + 1;
      add_quad(&surface, a, b, b + 1, a + 1);
    }
  return surface;
}

struct NetBuilder {
  const sandglass_field* field;
  const FieldGrid& grid;
  Surface surface;
  std::vector<uint32_t> vertex_of_cell;

  explicit NetBuilder(const sandglass_field* f) : field(f), grid(f->grid) {
    vertex_of_cell.assign(static_cast<size_t>(grid.counts[0]) * grid.counts[1] * grid.counts[2], UINT32_MAX);
  }

  size_t node(uint32_t x, uint32_t y, uint32_t z) const {
    return x + static_cast<size_t>(grid.counts[0]) * (y + static_cast<size_t>(grid.counts[1]) * z);
  }
  float value(uint32_t x, uint32_t y, uint32_t z) const { return grid.values[node(x, y, z)]; }

  void place(uint32_t x, uint32_t y, uint32_t z) {
    float corners[8], sum[3] = {};
    int crossings = 0;
    for (uint32_t i = 0; i < 8; ++i) corners[i] = value(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
    for (uint32_t i = 0; i < 8; ++i)
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint32_t j = i | 1u << axis;
        if (j == i || (corners[i] < 0.0f) == (corners[j] < 0.0f)) continue;
        float at[3] = {static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2)};
        at[axis] = corners[i] / (corners[i] - corners[j]);
        for (int k = 0; k < 3; ++k) sum[k] += at[k];
        ++crossings;
      }
    if (crossings == 0) return;
    const uint32_t cell[3] = {x, y, z};
    float position[3], normal[3];
    for (int k = 0; k < 3; ++k)
      position[k] = grid.low[k] + grid.spacing * (static_cast<float>(cell[k]) + sum[k] / static_cast<float>(crossings));
    sandglass_field_distance(field, position, normal);
    vertex_of_cell[node(x, y, z)] = surface.vertex_count();
    add_vertex(&surface, position, normal);
  }

  // Adds the quad across the edge from this node along `axis`.
  void join(uint32_t x, uint32_t y, uint32_t z, uint32_t axis) {
    const uint32_t at[3] = {x, y, z}, u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (at[u] == 0 || at[v] == 0) return;
    uint32_t next[3] = {x, y, z};
    ++next[axis];
    const bool solid = value(x, y, z) < 0.0f;
    if (solid == (value(next[0], next[1], next[2]) < 0.0f)) return;
    uint32_t corner[4];
    for (int i = 0; i < 4; ++i) {
      uint32_t cell[3] = {x, y, z};
      if (i == 1 || i == 2) --cell[u];
      if (i >= 2) --cell[v];
      corner[i] = vertex_of_cell[node(cell[0], cell[1], cell[2])];
      if (corner[i] == UINT32_MAX) return;
    }
    if (solid) add_quad(&surface, corner[0], corner[1], corner[2], corner[3]);
    else add_quad(&surface, corner[3], corner[2], corner[1], corner[0]);
  }

  Surface build() {
    const uint32_t *n = grid.counts, cells[3] = {n[0] - 1, n[1] - 1, n[2] - 1};
    for (uint32_t z = 0; z < cells[2]; ++z)
      for (uint32_t y = 0; y < cells[1]; ++y)
        for (uint32_t x = 0; x < cells[0]; ++x) place(x, y, z);
    for (uint32_t z = 0; z < cells[2]; ++z)
      for (uint32_t y = 0; y < cells[1]; ++y)
        for (uint32_t x = 0; x < cells[0]; ++x)
          for (uint32_t axis = 0; axis < 3; ++axis) join(x, y, z, axis);
    return std::move(surface);
  }
};

}  // namespace

Surface collider_surface(const sandglass_collider& collider) {
  switch (collider.shape) {
    case SANDGLASS_SHAPE_SPHERE:
      return capsule_surface(collider.size[0], 0.0f);
    case SANDGLASS_SHAPE_CAPSULE:
      return capsule_surface(collider.size[0], collider.size[1]);
    case SANDGLASS_SHAPE_BOX:
      return box_surface(collider.size);
    case SANDGLASS_SHAPE_FIELD:
      return collider.field == nullptr ? Surface{} : NetBuilder(collider.field).build();
    default:
      return {};
  }
}

}  // namespace sandglass::host

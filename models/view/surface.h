// Makes the triangles that draw a collider, in its local frame: boxes, spheres and capsules by formula, fields from
// their zero level. Front faces look to where sand can be, so that a container shows its far wall.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Surface {
  std::vector<float> vertices;  // six floats per vertex: position and unit normal
  std::vector<uint32_t> indices;

  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size() / 6); }
};

// The result is empty for a half-space, because that has no end.
Surface collider_surface(const sandglass_collider& collider);

}  // namespace sandglass::host

// The triangles that colliders are drawn as, in their local frames: boxes, spheres and capsules by formula, fields by
// their zero level. Front faces are seen from where sand can be, so that a container shows its far wall.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Surface {
  std::vector<float> vertices;  // position and unit normal: six floats
  std::vector<uint32_t> indices;

  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size() / 6); }
};

// Empty for a half-space, which has no end.
Surface collider_surface(const sandglass_collider& collider);

}  // namespace sandglass::host

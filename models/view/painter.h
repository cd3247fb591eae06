// Draws a scene with OpenGL 3.3: grains as lit spheres (one square each), the floor, the solids, the library's shadows
// of objects and sand, and a shadow map for everything without such a shadow. It needs a current context for its whole
// life.
#pragma once

#include <memory>
#include <span>

#include "models/drawing/render.h"
#include "models/files/image.h"
#include "models/simulation/scene_meshes.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Painted {
  std::span<const float> spheres;  // `sphere_floats` floats each; the position comes first
  int sphere_floats = 4;
  double radius = 0.01;
  bool grains = false;  // the spheres differ in size and have faces
  std::span<const sandglass_collider> colliders;
  const CollisionFields* fields = nullptr;  // those of the colliders
  std::span<const FloorShadow> shadows;
  // The shadow of the sand: both, or both null. Without them the sand is in the shadow map.
  const FloorShadow *pile = nullptr, *pile_on_sand = nullptr;
  Vec3 to_light;
  Camera camera;
  Bounds bounds;
};

struct Overlay {
  const Picture* picture;
  int x, y;  // of the upper left corner, pixels
};

class Painter {
 public:
  Painter();  // throws a Failure when the context has no OpenGL 3.3
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  void paint(const Painted& scene, int width, int height, std::span<const Overlay> overlays);
  Picture read_back(int width, int height) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

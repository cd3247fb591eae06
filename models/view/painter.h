// Draws a scene with OpenGL 3.3: grains as lit spheres, one square each; floor, solids, the library's shadows of
// objects and sand, a shadow map for what has none of them. Needs a current context for its whole life.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "models/drawing/render.h"
#include "models/files/image.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Painted {
  std::span<const float> spheres;  // `sphere_floats` floats each, the position first
  int sphere_floats = 4;
  double radius = 0.01;
  std::span<const sandglass_collider> colliders;
  std::span<const FloorShadow> shadows;
  const FloorShadow *pile = nullptr, *pile_on_sand = nullptr;  // of the sand; null: it is in the shadow map
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
  Painter();  // a Failure when the context is no OpenGL 3.3
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

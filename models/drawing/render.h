// A small ray tracer, good enough to judge a pile of sand by eye: shaded grains whose colour varies, floor with a
// checker, analytic colliders, soft sun shadow, ambient occlusion, a ruler and a scale bar. The same input gives the
// same picture.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "models/files/image.h"
#include "models/geometry/camera.h"
#include "models/geometry/vec3.h"
#include "models/simulation/floor_shadow.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Bounds {
  Vec3 low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  bool empty() const { return low.x > high.x; }
  void add(Vec3 p);
  // All but the outermost 1 % of the points on either side of each axis: strays would shrink the picture.
  void add_most(std::span<const float> xyz);
};

// Looks down at the boxes (one an instant of the run, say) from the front right, so that all of them just fit into the
// picture.
Camera automatic_camera(std::span<const Bounds> boxes, double aspect);

Vec3 grain_colour(uint32_t index);  // reflectance of a grain of dry sand, by number

struct SceneView {
  std::span<const float> spheres;  // 3 floats each
  float radius = 0.01f;            // metres, as drawn
  std::span<const sandglass_collider> colliders;
  Camera camera;
  std::span<const FloorShadow> shadows;
  Vec3 to_light;  // of length 0: the renderer's own sun
  Bounds bounds;  // of what is looked at: sizes the checker, the ruler and the reach of the occlusion
};

struct RenderOptions {
  int width = 960, height = 720;
  int samples = 2;  // per pixel and axis
  uint32_t threads = 4;
  bool scale = true;   // ruler, scale bar and the size of the checker in words
  bool plain = false;  // warm colours and a floor without checker: a picture to look at, not to measure in
};

Picture render(const SceneView& view, const RenderOptions& options);

// Where a point appears, in pixels from the upper left corner; depth <= 0 when it is behind the camera.
struct PixelPlace {
  double x, y, depth;
};
PixelPlace project(const Camera& camera, int width, int height, Vec3 point);

}  // namespace sandglass::host

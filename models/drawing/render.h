// A small ray tracer, good enough to judge a pile of sand by eye: shaded grains of varying colour, a floor with a
// checker, colliders, soft sun shadows, ambient occlusion, a ruler and a scale bar. The same input gives the same
// picture.
#pragma once

#include <cstdint>
#include <span>

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
  // Adds all points except the outermost 1 % on either side of each axis. Stray points would shrink the picture.
  void add_most(std::span<const float> xyz);
};

// A camera that looks down at the boxes from the front right and is near enough that all of them fit into the picture
// with a margin. There is, for example, one box per instant of a run.
Camera automatic_camera(std::span<const Bounds> boxes, double aspect);

// How one grain of dry sand differs from the next; all of it depends on the grain's number.
Vec3 grain_colour(uint32_t index);               // reflectance
float grain_size(uint32_t index);                // its radius over the mean one
Vec3 grain_normal(uint32_t index, Vec3 normal);  // that of a sphere, or of a face that is broken off it

struct SceneView {
  std::span<const float> spheres;  // 3 floats each
  float radius = 0.01f;            // of a drawn sphere, metres
  bool grains = false;             // the spheres differ in size and have faces
  std::span<const sandglass_collider> colliders;
  Camera camera;
  std::span<const FloorShadow> shadows;
  Vec3 to_light;  // length 0: the renderer's own sun
  // Around what the camera looks at. It sets the size of the checker and the ruler, and the reach of the occlusion.
  Bounds bounds;
};

struct RenderOptions {
  int width = 960, height = 720;
  int samples = 2;  // per pixel and axis
  uint32_t threads = 4;
  bool scale = true;   // draws the ruler, the scale bar and the size of a floor tile
  bool plain = false;  // warm colours and a floor without checker: a picture to look at, not to measure in
};

Picture render(const SceneView& view, const RenderOptions& options);

// Where a point appears, in pixels from the upper left corner. The depth is not above 0 when it is behind the camera.
struct PixelPlace {
  double x, y, depth;
};
PixelPlace project(const Camera& camera, int width, int height, Vec3 point);

}  // namespace sandglass::host

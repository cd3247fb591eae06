// A small ray tracer for a scene by itself: a floor, colliders, soft shadows of the sun, the room's light where nothing is
// near, and sand as the kit draws it, or balls where particles are to be seen. A coin tells how large things are. The same
// input gives the same picture.
#pragma once

#include <cstdint>
#include <span>

#include "models/drawing/sand_shape.h"
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
  void add_inner(std::span<const float> xyz);
};

// A camera that looks down at the boxes from the front right and is near enough that all of them fit into the picture
// with a margin. There is, for example, one box per instant of a run.
Camera automatic_camera(std::span<const Bounds> boxes, double aspect);

// From the front left.
constexpr Vec3 k_sun = {-0.5144957554275266, 0.7717436331412899, 0.3736};

struct SceneView {
  std::span<const float> spheres;  // 3 floats each
  float radius = 0.01f;            // of a sphere, metres
  // Drawn instead of the spheres.
  const SandShape* sand = nullptr;
  const SceneShadows* on_sand = nullptr;  // of the sand on itself, main light and room's; null: none
  std::span<const sandglass_collider> colliders;
  Camera camera;
  std::span<const FloorShadow> shadows;
  Vec3 to_light = k_sun;
  // Around what the camera looks at. It sets the place of the coin, and the reach of the occlusion.
  Bounds bounds;
};

struct RenderOptions {
  int width = 960, height = 720;
  int samples = 3;  // per pixel and axis
  uint32_t threads = 4;
  bool coin = false;  // of one euro, beside what is seen, on its floor
};

Picture render(const SceneView& view, const RenderOptions& options);

// Where a point appears, in pixels from the upper left corner. The depth is not above 0 when it is behind the camera.
struct PixelPlace {
  double x, y, depth;
};
PixelPlace project(const Camera& camera, int width, int height, Vec3 point);

}  // namespace sandglass::host

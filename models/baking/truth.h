// The truth that shadow networks are trained on and measured against: the transparency of a plane under an object in
// the light of a soft directional source, by ray casting. Equation numbers are those of the dissertation.
//
// The light is a cap of uniform radiance around a direction; its radius is `half_angle`. The transparency of a texel is
// its irradiance divided by its irradiance without the object, averaged over its area (6.18). Samples are uniform in
// solid angle, so
//     nu = sum (r . y) visible / sum (r . y)
// This corrects (6.16) and (6.17). The printed sum has another factor sin(theta_s), which counts the Jacobian of (6.15)
// twice. It also has a cosine at the emitter, which is 1 for a cap of the unit sphere.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/work/thread_pool.h"
#include "runtime/math/shadow_rectangle.h"

namespace sandglass::host {

using Direction = std::array<double, 3>;

// An object in the frame of plane.h, scaled so that its longest side is 1. So tiny and huge meshes are traced with the
// same precision.
struct StandingObject {
  Mesh mesh;              // normalised
  ShadowBox box;          // normalised
  double scale = 1;       // lengths of the mesh file = scale * normalised lengths
  double origin[3] = {};  // in the mesh file's coordinates: the centre of the footprint, on the plane
};

// Stands the object on the plane at its lowest point. Throws a Failure for a mesh without triangles, for coordinates
// that are not finite, for a size out of range, for an object that is flat on the ground or a line (it has no shadow to
// learn), and for one so far from its origin that rounding spoils its shape.
StandingObject stand_on_plane(const Mesh& mesh, const std::string& name);

struct SampleCounts {
  uint32_t points = 2;  // per texel and axis: S_p = points^2 = 4
  uint32_t light = 8;   // strata of the light per axis: S_l = light^2 = 64
};

class ShadowCaster {
 public:
  // `half_angle` is that of the light, in radians and below 90 degrees.
  ShadowCaster(const Mesh& mesh, double half_angle, SampleCounts counts, uint64_t seed);
  ~ShadowCaster();
  ShadowCaster(const ShadowCaster&) = delete;
  ShadowCaster& operator=(const ShadowCaster&) = delete;

  // Traces `count` texels of a size_x x size_y texture that covers `rectangle`. `uv` holds two numbers (u, v) for each
  // texel. Texel (u, v) has its centre at x = low_x + (u + 1/2) (high_x - low_x) / size_x; z follows from v in the same
  // way. Values are in 0..1. `stream` gives each texture its own random numbers. A texel's value does not depend on
  // which other texels are asked for. Any number of threads may call at the same time.
  void texels(const ShadowRectangle& rectangle, const Direction& light, uint64_t stream, uint32_t size_x,
              uint32_t size_y, const uint32_t* uv, uint32_t count, float* values) const;

  // Traces all texels of a square texture, row by row. The pool shares the work.
  std::vector<float> texture(const ShadowRectangle& rectangle, const Direction& light, uint64_t stream, uint32_t size,
                             ThreadPool& pool) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

// Computes all texels (u, v) of a square texture, row by row. The pool shares bands of rows; it calls
// fill(uv, count, values) for each band.
std::vector<float> whole_texture(uint32_t size, ThreadPool& pool,
                                 const std::function<void(const uint32_t* uv, uint32_t count, float* values)>& fill);

// `count` directions, spread evenly over the cap of polar angles 0..polar_max by the library's ring sampler.
std::vector<Direction> ring_directions(double polar_max, uint32_t count);

}  // namespace sandglass::host

// Procedural indoor rooms. They train the lighting network and light the demos; nobody else has rights in them. A seed
// decides everything: size, openings and the sky behind them, surfaces and their colours, furniture, clutter, and which
// lamps there are and which are on. Units are metres and candela per square metre; y is up, the floor is y = 0. A room
// is triangles with materials, and emitters that a path tracer can aim at.
#pragma once

#include <cstdint>
#include <vector>

#include "models/geometry/vec3.h"

namespace sandglass::host {

enum class Pattern { plain, checker, tiles, planks, stripes, bricks, blotches, mosaic };

// Diffuse, with an optional mirror-like coat. The coat reflects the fraction `coat` at normal incidence. `coat_blur` is
// the radius of the disk about the reflected unit direction.
struct RoomMaterial {
  Vec3 colour = {0.7, 0.7, 0.7}, second = {0.7, 0.7, 0.7};  // reflectances; the second of the pattern
  Pattern pattern = Pattern::plain;
  double scale = 1.0;  // of the pattern, metres
  double coat = 0.0, coat_blur = 0.0;
};

// What gives light. A quad shines to the side of cross(edge_a, edge_b) only. A window is a quad without triangles: it
// marks the opening through which the sky is seen.
struct Emitter {
  enum class Kind { quad, sphere, window } kind = Kind::quad;
  Vec3 corner, edge_a, edge_b;  // quad and window; a window shines into the room
  Vec3 centre;                  // sphere
  double radius = 0.0;
  Vec3 radiance;  // quad and sphere
};

// Seen through windows: a gradient, the ground, a skyline, and the sun.
struct Sky {
  Vec3 zenith, horizon, ground, skyline;
  uint64_t skyline_seed = 0;
  Vec3 sun_direction = {0, 1, 0};  // towards it
  Vec3 sun_radiance;               // 0: none, or hidden
};

constexpr double k_sun_cosine = 0.99998917;  // of the sun's angular radius, 0.2666 degrees

Vec3 sky_radiance(const Sky& sky, Vec3 direction);  // without the sun

// The reflectance of a material at a point of a surface with that normal.
Vec3 reflectance(const RoomMaterial& material, Vec3 point, Vec3 normal);

struct RoomTriangle {
  uint32_t corners[3];
  uint16_t material;
  int16_t emitter;  // -1: gives no light
};

struct Room {
  std::vector<float> vertices;  // three floats each
  std::vector<RoomTriangle> triangles;
  std::vector<RoomMaterial> materials;
  std::vector<Emitter> emitters;
  Sky sky;
  Vec3 size;         // along x, y, z; the floor's corners are (0, 0, 0) and (size.x, 0, size.z)
  Vec3 eye;          // where the panorama is taken
  double key = 0.2;  // logarithmic mean of luminance to which the panorama is exposed
};

Room make_room(uint64_t seed);

}  // namespace sandglass::host

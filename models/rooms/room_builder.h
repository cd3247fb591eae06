// The shapes that rooms are made of, and the choices of a seed.
#pragma once

#include "models/rooms/room.h"
#include "runtime/math/random.h"

namespace sandglass::host {

struct Span {
  double low, high;
};

// An argument may draw no more than one random number: compilers differ in the order of arguments, and a seed must
// give one room.
struct RoomBuilder {
  Room room;
  Random random;
  // Axis-aligned floor areas that are taken: x0, z0, x1, z1.
  struct Area {
    double x0, z0, x1, z1;
  };
  std::vector<Area> taken;

  explicit RoomBuilder(uint64_t seed) : random(random_stream(seed, k_room_stream)) {}

  double between(double low, double high) { return low + (high - low) * random.uniform(); }
  double log_between(double low, double high);  // uniform in the logarithm
  bool chance(double probability) { return random.uniform() < probability; }
  int pick(int count) { return static_cast<int>(random.below(static_cast<uint32_t>(count))); }

  // A random colour of that brightness. The saturation is drawn before the hue.
  Vec3 colour(Span hue, Span saturation, double bright);
  int material(const RoomMaterial& m);
  // A corner and two edges; visible from both sides, an emitter shines to the side of cross(a, b).
  void quad(Vec3 corner, Vec3 a, Vec3 b, int material, int emitter = -1);
  int quad_emitter(Vec3 corner, Vec3 a, Vec3 b, Vec3 radiance);  // and its two triangles
  int sphere_emitter(Vec3 centre, double radius, Vec3 radiance);
  // Boxes stand on `base` (the middle of the underside), turned about y by `yaw`.
  void box(Vec3 base, Vec3 size, double yaw, int material);
  void cylinder(Vec3 base, double radius, double height, int sides, int material);
  // A lampshade: an open frustum that glows outwards (and nothing inside, which the bulb's light would show).
  void shade(Vec3 base, double low_radius, double high_radius, double height, Vec3 radiance);
  void sphere(Vec3 centre, double radius, int material, int emitter = -1);
  uint32_t vertex(Vec3 p);
  void triangle(Vec3 a, Vec3 b, Vec3 c, int material, int emitter);

  // A free axis-aligned place on the floor, marked taken; false if ten tries find none.
  bool place(double width, double depth, Vec3* centre);
  bool place_at(double x0, double z0, double x1, double z1);

  static constexpr uint64_t k_room_stream = 11;
};

// The chromaticity of a black body as a linear BT.709 colour of luminance 1 (Planckian locus by Kim's cubic fit).
Vec3 colour_of_temperature(double kelvin);

Vec3 colour_of_hue(double hue, double saturation, double luminance);  // hue and saturation in 0..1

void furnish(RoomBuilder* builder);
void light(RoomBuilder* builder, bool daylight);

}  // namespace sandglass::host

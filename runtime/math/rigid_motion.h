// A rigid motion: from one pose to another.
#pragma once

namespace sandglass {

// x, y, z and 0, in the registers of four that all targets have or the compiler makes do without. Also half a record.
typedef float Quad __attribute__((vector_size(16), may_alias));

inline Quad quad(const float v[3]) { return Quad{v[0], v[1], v[2], 0.0f}; }
inline float dot(const Quad& a, const Quad& b) {
  const Quad products = a * b;
  return products[0] + products[1] + products[2];
}
inline float square_of(const Quad& v) { return dot(v, v); }

// x becomes x + turn (x - from) + shift. Small displacements are exact to the last bits.
struct RigidMotion {
  Quad turn[3], from, shift;  // turn: its columns

  Quad turned(const Quad& r) const { return (turn[0] * r[0] + turn[1] * r[1]) + turn[2] * r[2]; }
  Quad displacement(const Quad& x) const { return turned(x - from) + shift; }
  void move(float x[3]) const { put(quad(x) + displacement(quad(x)), x); }
  void rotate(float v[3]) const { put(quad(v) + turned(quad(v)), v); }

 private:
  static void put(const Quad& u, float x[3]) {
    for (int k = 0; k < 3; ++k) x[k] = u[k];
  }
};

// From one pose to another: RigidPoses, or frames of colliders.
template <class Pose>
RigidMotion rigid_motion(const Pose& from, const Pose& to) {
  RigidMotion m = {};
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < 3; ++k) m.turn[j] += (quad(to.axes[k]) - quad(from.axes[k])) * from.axes[k][j];
  m.from = quad(from.position);
  m.shift = quad(to.position) - m.from;
  return m;
}

struct RigidPose {
  float position[3], axes[3][3];  // images of x, y, z
};

}  // namespace sandglass

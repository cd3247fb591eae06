// A rigid motion, as the way from one pose to another.
#pragma once

namespace sandglass {

// A rigid motion by how far it takes a point: x becomes x + turn (x - from) + shift. Exact to the last bits of small ones.
struct RigidWay {
  float turn[3][3], from[3], shift[3];

  void way(const float x[3], float u[3]) const {
    const float r[3] = {x[0] - from[0], x[1] - from[1], x[2] - from[2]};
    for (int k = 0; k < 3; ++k) u[k] = (turn[k][0] * r[0] + turn[k][1] * r[1] + turn[k][2] * r[2]) + shift[k];
  }
  void move(float x[3]) const {
    float u[3];
    way(x, u);
    for (int k = 0; k < 3; ++k) x[k] += u[k];
  }
  void rotate(float v[3]) const {
    const float x = v[0], y = v[1], z = v[2];
    for (int k = 0; k < 3; ++k) v[k] += turn[k][0] * x + turn[k][1] * y + turn[k][2] * z;
  }
};

// From one pose to another: positions, and images of x, y, z.
inline RigidWay rigid_way(const float from[3], const float from_axes[3][3], const float to[3],
                          const float to_axes[3][3]) {
  RigidWay w = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) w.turn[i][j] += (to_axes[k][i] - from_axes[k][i]) * from_axes[k][j];
    }
    w.from[i] = from[i];
    w.shift[i] = to[i] - from[i];
  }
  return w;
}

struct RigidPose {
  float position[3], axes[3][3];  // images of x, y, z
};

// x, y, z and 0, in the registers of four that all targets have or the compiler makes do without.
typedef float Quad __attribute__((vector_size(16)));
inline Quad quad(const float v[3]) { return Quad{v[0], v[1], v[2], 0.0f}; }
inline Quad times(const Quad columns[3], const Quad& v) {
  const Quad x = {v[0], v[0], v[0], v[0]}, y = {v[1], v[1], v[1], v[1]}, z = {v[2], v[2], v[2], v[2]};
  return (columns[0] * x + columns[1] * y) + columns[2] * z;
}

// A rigid motion for many.
struct QuadMotion {
  Quad from, turn[3], shift;

  Quad turned(const Quad& v) const { return times(turn, v); }
  Quad way(const Quad& x) const { return times(turn, x - from) + shift; }
};
inline QuadMotion quad_motion(const RigidWay& w) {
  QuadMotion q = {quad(w.from), {}, quad(w.shift)};
  for (int k = 0; k < 3; ++k) q.turn[k] = Quad{w.turn[0][k], w.turn[1][k], w.turn[2][k], 0.0f};
  return q;
}

}  // namespace sandglass

// Depth images of a table that a hand-held device looks at, and the truth in closed form: boxes and hollow cylinders on a
// table over a floor. The images have what devices' images have: noise that hangs together, holes, pixels that fly
// between near and far, a bias, and poses that drift.
#pragma once

#include <cstdint>
#include <vector>

#include "models/geometry/vec3.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

// A box that stands upright, turned about y; or an upright cylinder with a hole from its top down to `inside`.
struct Thing {
  bool is_box = true;
  Vec3 low_middle, half;  // of a box: the middle of its lower face; half its sides
  double yaw = 0;
  double radius = 0, hole = 0, inside = 0;  // of a cylinder; its height is 2 half.y

  double top() const { return low_middle.y + 2 * half.y; }
};
Thing box_thing(Vec3 low_middle, Vec3 half, double yaw = 0);
Thing cup_thing(Vec3 low_middle, double height, double radius, double wall, double bottom);

// What is on the table at one time, beside what always is: a box that is put there and taken away, a hand that passes.
struct TableState {
  bool box = false, hand = false;
  double hand_share = 0;  // of its way
};

struct Table {
  std::vector<Thing> things;
  Thing box;  // the one that comes and goes

  // The highest surface above a place, without the hand; k_floor beyond the table.
  double height(double x, double z, const TableState& state) const;
  // The depth that a ray sees, in units of its direction; 0: nothing.
  double depth(Vec3 from, Vec3 direction, const TableState& state) const;
  // What a scan of the room knows: corners of triangles, x y z each, of the table, the floor and what always is. A lamp
  // hangs over it from a ceiling.
  std::vector<float> triangles() const;
};
constexpr double k_floor = -0.72;            // metres below the table
constexpr double k_table[2] = {0.60, 0.42};  // half its sides
Table usual_table();                         // books, carton, cup, bowl, pot
Table table_with_a_book();                   // of 3 cm, that fills the view

enum class DepthKind { raw, lidar, smoothed };
constexpr double k_image_rate = 15;  // a second

// Of the usual recording: the box stands from 2 to 6 s, a hand passes from 3.5 to 4.7 s.
TableState usual_state(double seconds);
constexpr double k_put = 2, k_taken = 6;

// Exact images of a recording, to which noise is added.
struct DepthRecording {
  DepthKind kind;
  const Table* table;
  uint32_t width, height;
  double focal;
  std::vector<std::vector<float>> depths;  // metres along the camera's axis
};
DepthRecording record_depth(DepthKind kind, const Table& table, double seconds);

struct DepthFaults {
  uint64_t seed = 1;
  double bias = 0.02;  // of the depth; a lidar has 4 mm
  bool drift = true;
};

// The images of a recording with such faults, one after another.
class DepthImages {
 public:
  DepthImages(const DepthRecording& recording, const DepthFaults& faults);
  // False after the last.
  bool next();
  const sandglass_depth_image& image() const { return image_; }
  double seconds() const { return seconds_; }
  // By how much the tracker has moved the world meanwhile.
  Vec3 drift() const { return drift_; }

 private:
  void add_noise(const std::vector<float>& exact);
  double gauss();

  const DepthRecording& recording_;
  DepthFaults faults_;
  sandglass_depth_image image_;
  std::vector<uint16_t> pixels_;
  std::vector<uint8_t> confidence_;
  std::vector<double> field_;  // noise that hangs together
  uint64_t random_;
  size_t count_ = 0;
  double seconds_ = 0;
  Vec3 drift_;
};

}  // namespace sandglass::host

// What an experiment with sand is made of besides sand: frames, vessels turned about the y axis, and random starts that
// no lattice biases.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "models/simulation/scene_file.h"
#include "models/work/block.h"
#include "models/work/random.h"
#include "sandglass/field.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

// Experiments run in frames of 20 ms without a budget: every frame does all its work.
constexpr double k_frame = 0.02;              // seconds
constexpr uint64_t k_no_budget = UINT64_MAX;  // nanoseconds
constexpr double k_gravity = 9.81;            // m/s^2, of the default description
inline uint32_t frames_in(double seconds) { return static_cast<uint32_t>(std::lround(seconds / k_frame)); }

// A vessel: sand stays inside the outline [[r, y], ...], closed, turned about the y axis; or, `solid_inside`, outside
// it. `spacing`: between the nodes of its field, metres.
class Vessel {
 public:
  Vessel(const Profile& outline, double spacing, bool solid_inside = false);
  sandglass_collider collider() const;

 private:
  Block block_;
  sandglass_field* field_ = nullptr;
};

sandglass_collider level_floor(double height = 0.0);

// Centres of spheres by random sequential addition at a fifth of the space, `count` of them from y = `bottom` upward in
// a shaft along y: the circle of radius `half_x` when `round`, else the rectangle of half sides half_x and half_z. 3
// floats each, none closer than 2.02 radii to another, none less than 1.01 radii from the shaft's wall.
struct Shaft {
  double half_x = 0.0, half_z = 0.0;  // metres
  bool round = true;
};
std::vector<float> scattered(uint32_t count, const Shaft& shaft, double bottom, double radius, uint64_t seed);

}  // namespace sandglass::host

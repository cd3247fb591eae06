// What an experiment with sand is made of besides sand: frames, vessels turned about the y axis, and random starts that
// no lattice biases.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "models/simulation/scene_file.h"
#include "models/work/random.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

// Experiments run in frames of 20 ms without a budget: every frame does all its work.
constexpr double k_frame = 0.02;              // seconds
constexpr uint64_t k_no_budget = UINT64_MAX;  // nanoseconds
constexpr double k_gravity = 9.81;            // m/s^2, of the default description
inline uint32_t frames_in(double seconds) { return static_cast<uint32_t>(std::lround(seconds / k_frame)); }

// The description with room for this much, and for the colliders of every experiment.
sandglass_scene_desc with_room(sandglass_scene_desc desc, uint32_t particles, uint32_t grains = 0);

// The field of a vessel: sand stays on that side of the outline [[r, y], ...], closed, turned about the y axis, which
// `solid` leaves free. `spacing`: between its nodes, metres.
cpp::Field vessel(const Profile& outline, double spacing, sandglass_solid solid = SANDGLASS_SOLID_OUTSIDE);
Profile cylinder(double radius, double bottom, double top);

double highest_of(std::span<const float> positions);

// Centres of spheres by random sequential addition at a fifth of the space, `count` of them from y = `bottom` upward in
// a round shaft along y. 3 floats each, none closer than 2.02 radii to another, none less than 1.01 radii from the
// shaft's wall.
std::vector<float> scattered(uint32_t count, double shaft, double bottom, double radius, uint64_t seed);

}  // namespace sandglass::host

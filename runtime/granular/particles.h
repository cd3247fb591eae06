// The particles: the records of the material's physics, and the box that holds them.
#pragma once

#include "kernels/particle.h"
#include "runtime/core/layout.h"

namespace sandglass {

struct Granular;

// A box around points, metres. Empty: low above high.
struct Bounds {
  float low[3], high[3];
};
constexpr Bounds k_nowhere = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};

static inline bool is_empty(const Bounds& b) { return b.low[0] > b.high[0]; }
static inline void bounds_join(Bounds* b, const Bounds& other) {
  for (int k = 0; k < 3; ++k) {
    b->low[k] = other.low[k] < b->low[k] ? other.low[k] : b->low[k];
    b->high[k] = other.high[k] > b->high[k] ? other.high[k] : b->high[k];
  }
}
// A ball.
static inline void bounds_include(Bounds* b, const float at[3], float radius = 0.0f) {
  bounds_join(b, {{at[0] - radius, at[1] - radius, at[2] - radius}, {at[0] + radius, at[1] + radius, at[2] + radius}});
}

struct Particles {
  // [0]: the state after the last complete sub-step. [1]: what the next one writes. [2]: only where a sub-step has more
  // than one pass. Each array holds the particles sorted by cell, padding, the boundary, and at last an inert particle.
  Particle* records[3];
  uint32_t count;
  uint32_t rows;   // room for particles and padding; the boundary follows
  uint32_t inert;  // index of the inert particle that pads neighbour rows
  float low[3], high[3];
  bool bounds_known;  // false: no particle has been added yet
  float speed_max;    // m/s, of the last sub-step and of what was added since
};

void particles_layout(Particles* particles, const sandglass_granular_desc& desc, Layout* layout);
void particles_reset(Particles* particles);

// What records[1] holds becomes the state.
void particles_swap(Particles* particles);
// The same for all arrays: `count` particles from `first` on, as the state has them.
void particles_copy_to_all(Particles* particles, uint32_t first, uint32_t count);

// Widens the bounds and the greatest speed to hold this particle.
void particles_include(Particles* particles, const float position[3], const float velocity[3]);
// The bounds of the particles as they are.
void particles_find_bounds(Particles* particles);

// Puts inert particles behind the last one, so that kernels may process whole vectors.
void particles_seal(Granular* granular);

}  // namespace sandglass

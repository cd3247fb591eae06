#include "runtime/granular/particles.h"

#include "runtime/granular/granular.h"

namespace sandglass {

void particles_layout(Particles* p, const sandglass_granular_desc& d, Layout* layout) {
  p->rows = (d.particle_capacity + k_lane_group - 1) / k_lane_group * k_lane_group + k_array_slack;
  p->inert = p->rows + d.boundary_capacity;
  const uint64_t records = static_cast<uint64_t>(p->inert) + k_array_slack;
  // Pairs are solved in place.
  const uint32_t solving = d.reference.scheme == SANDGLASS_SCHEME_SMALL_STEP ? 1 : d.reference.solver_iterations;
  const bool several_passes = solving + d.reference.stabilisation_iterations > 1;
  p->records[0] = layout_region<Particle>(layout, "granular.particles", records);
  p->records[1] = layout_region<Particle>(layout, "granular.particles_next", records);
  p->records[2] = layout_region<Particle>(layout, "granular.particles_between", several_passes ? records : 0);
}

void particles_reset(Particles* p) {
  p->count = 0;
  p->bounds_known = false;
  p->speed_max = 0.0f;
  for (int k = 0; k < 3; ++k) p->low[k] = p->high[k] = 0.0f;
  for (Particle* records : p->records) {
    if (records != nullptr) records[p->inert] = inert_particle();
  }
}

void particles_swap(Particles* p) {
  Particle* state = p->records[1];
  p->records[1] = p->records[0];
  p->records[0] = state;
}

void particles_copy_to_all(Particles* p, uint32_t first, uint32_t count) {
  for (int b = 1; b < 3; ++b) {
    if (p->records[b] != nullptr)
      __builtin_memcpy(p->records[b] + first, p->records[0] + first, count * sizeof(Particle));
  }
}

void particles_include(Particles* p, const float position[3], const float velocity[3]) {
  float speed2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    if (!p->bounds_known || position[k] < p->low[k]) p->low[k] = position[k];
    if (!p->bounds_known || position[k] > p->high[k]) p->high[k] = position[k];
    speed2 += velocity[k] * velocity[k];
  }
  p->bounds_known = true;
  const float speed = __builtin_sqrtf(speed2);
  if (speed > p->speed_max) p->speed_max = speed;
}

void particles_find_bounds(Particles* p) {
  for (uint32_t i = 0; i < p->count; ++i) {
    const float* at = p->records[0][i].position;
    for (int k = 0; k < 3; ++k) {
      if (i == 0 || at[k] < p->low[k]) p->low[k] = at[k];
      if (i == 0 || at[k] > p->high[k]) p->high[k] = at[k];
    }
  }
}

void particles_seal(Granular* g) {
  Particles& p = g->particles;
  for (uint32_t i = p.count; i < p.rows && i < p.count + k_array_slack; ++i) {
    for (Particle* records : p.records) {
      if (records != nullptr) records[i] = inert_particle();
    }
    neighbours_clear_row(&g->neighbours, i, p.inert);
  }
}

}  // namespace sandglass

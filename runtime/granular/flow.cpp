#include "runtime/granular/flow.h"

#include "kernels/whole.h"
#include "runtime/core/finite.h"
#include "runtime/core/random.h"
#include "runtime/core/refuse.h"
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

constexpr float k_spacing_radii = 2.02f;  // of the poured lattice
constexpr float k_row = 0.8660254f;       // sqrt(3)/2
constexpr float k_layer = 0.81649658f;    // sqrt(2/3)
constexpr float k_jitter_radii = 0.02f;   // added to every coordinate: perfect layers would stack
constexpr uint32_t k_batch = 64;          // sites added at once, from the stack

// The next number of the sequence that an emitter's jitter is drawn from.
uint64_t next_seed(uint64_t seed) { return mix_bits(seed + k_random_step); }

// From -1 to 1.
float symmetric(uint64_t bits) { return static_cast<float>(static_cast<int32_t>(bits >> 40) - (1 << 23)) * 0x1p-23f; }

bool accept(const Granular& g, const sandglass_emitter& emitter, sandglass_emitter* accepted) {
  const float r = g.desc.particle_radius;
  const float* q = emitter.rotation;
  if (!all_finite(emitter.position, 3) || !all_finite(q, 4)) return false;
  for (const float p : emitter.position) {
    if (!(__builtin_fabsf(p) <= SANDGLASS_COORDINATE_LIMIT)) return false;
  }
  if (!(emitter.radius >= r && emitter.radius <= 100.0f * r)) return false;
  if (!(emitter.speed > 0.0f && emitter.speed <= 100.0f) || emitter.grains_per_particle > 64) return false;
  const float length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length2 > 1e-12f && length2 < 1e12f)) return false;
  *accepted = emitter;
  const float fastest = g.desc.courant * r / g.substep.shortest, inverse = 1.0f / __builtin_sqrtf(length2);
  if (accepted->speed > fastest) accepted->speed = fastest;
  for (float& c : accepted->rotation) c *= inverse;
  return true;
}

struct Nozzle {
  float axes[3][3];  // local x, y, z in the world
};

Nozzle nozzle_of(const sandglass_emitter& e) {
  sandglass_collider frame = {};
  for (int k = 0; k < 4; ++k) frame.rotation[k] = e.rotation[k];
  ColliderFrame posed;
  colliders_pose(&frame, 1, 0.0f, &posed);
  Nozzle nozzle;
  __builtin_memcpy(nozzle.axes, posed.axes, sizeof nozzle.axes);
  return nozzle;
}

// Sites of a layer: rows of a triangular lattice within the nozzle, every layer shifted against the last. Calls take(x,
// z).
template <class Take>
void for_sites(const sandglass_emitter& e, float radius, uint32_t layer, const Take& take) {
  const float a = k_spacing_radii * radius, reach = e.radius;
  const float shift_x = layer % 2 == 0 ? 0.0f : 0.5f * a, shift_z = layer % 2 == 0 ? 0.0f : a * k_row / 3.0f;
  const int32_t rows = to_whole<int32_t>(reach / (a * k_row)) + 2, columns = to_whole<int32_t>(reach / a) + 2;
  for (int32_t j = -rows; j <= rows; ++j) {
    for (int32_t i = -columns; i <= columns; ++i) {
      const float x = (static_cast<float>(i) + ((j & 1) != 0 ? 0.5f : 0.0f)) * a + shift_x;
      const float z = static_cast<float>(j) * a * k_row + shift_z;
      if (x * x + z * z <= reach * reach) take(x, z);
    }
  }
}

struct Batch {
  float positions[3 * k_batch], velocities[3 * k_batch];
  uint32_t count;
};

void deny(Granular* g, uint32_t particles) {
  g->flow.counts.denied_particles += particles;
  g->counts.denied_particles += particles;
}

void flush(Granular* g, Batch* batch, bool grains) {
  // Room was checked for the whole layer. What can still fail is a site beyond the coordinate limit.
  const uint32_t particles = grains ? 0 : batch->count, fine = grains ? batch->count : 0;
  const sandglass_status status = granular_add(g, batch->positions, batch->velocities, particles, batch->positions,
                                               batch->velocities, fine, nullptr);
  batch->count = 0;
  if (status != SANDGLASS_OK) {
    deny(g, particles);
    return;
  }
  g->flow.counts.emitted_particles += particles;
  g->flow.counts.emitted_grains += fine;
}

// What left the nozzle `since` seconds ago has fallen freely since: the position and the velocity are given as they would
// be without gravity. A grain further along the jet than its particle left the nozzle earlier, so a jet stretches as it
// falls and does not part into layers.
void fall(const Granular& g, float since, float position[3], float velocity[3]) {
  for (int k = 0; k < 3; ++k) {
    position[k] += 0.5f * since * since * g.gravity[k];
    velocity[k] += since * g.gravity[k];
  }
}

void put_site(Granular* g, Batch* batch, bool grains, const float position[3], const float velocity[3]) {
  for (uint32_t k = 0; k < 3; ++k)
    batch->positions[3 * batch->count + k] = position[k], batch->velocities[3 * batch->count + k] = velocity[k];
  if (++batch->count == k_batch) flush(g, batch, grains);
}

void emit_layer(Granular* g, const sandglass_emitter& e, uint32_t index, uint32_t layer, uint32_t sites, float gone) {
  const float r = g->desc.particle_radius;
  const uint64_t grains = static_cast<uint64_t>(sites) * e.grains_per_particle;
  if (sites > g->desc.particle_capacity - g->particles.count || grains > g->desc.grain_capacity - g->grains.count) {
    deny(g, sites);
    return;
  }
  const Nozzle nozzle = nozzle_of(e);
  float out[3];
  for (int k = 0; k < 3; ++k) out[k] = -e.speed * nozzle.axes[1][k];
  const float since = gone / e.speed;
  // A grain is no more than this before or after its particle, so that gravity turns none of them round.
  const float most = e.speed / (g->gravity_length > 0.0f ? g->gravity_length : 1e-6f);
  // Grains that are behind the particles catch up with the next sweep.
  const float lag = static_cast<float>(g->time.grain_lag);
  Batch particles, fine;
  particles.count = fine.count = 0;
  uint64_t seed = next_seed((static_cast<uint64_t>(index) << 32) | layer);
  for_sites(e, r, layer, [&](float x, float z) {
    float at[3], position[3], velocity[3];
    for (int k = 0; k < 3; ++k) {
      seed = next_seed(seed);
      position[k] = at[k] = e.position[k] + x * nozzle.axes[0][k] - gone * nozzle.axes[1][k] + z * nozzle.axes[2][k] +
                            k_jitter_radii * r * symmetric(seed);
      velocity[k] = out[k];
    }
    fall(*g, since, position, velocity);
    put_site(g, &particles, false, position, velocity);
    for (uint32_t grain = 0; grain < e.grains_per_particle;) {
      float offset[3], length2 = 0.0f, along = 0.0f;
      for (float& o : offset) seed = next_seed(seed), o = symmetric(seed), length2 += o * o;
      if (length2 > 1.0f) continue;  // uniform within the ball
      for (int k = 0; k < 3; ++k) {
        along -= r * offset[k] * nozzle.axes[1][k];
        position[k] = at[k] - lag * out[k] + r * offset[k];
        velocity[k] = out[k];
      }
      const float earlier = along / e.speed;
      fall(*g, since - lag + (earlier < -most ? -most : earlier > most ? most : earlier), position, velocity);
      put_site(g, &fine, true, position, velocity);
      ++grain;
    }
  });
  if (particles.count != 0) flush(g, &particles, false);
  if (fine.count != 0) flush(g, &fine, true);
}

void remove_grain(Granular* g, uint32_t i) {
  Grain* gap = &g->grains.records[i];
  g->flow.free_grains[g->flow.free_grain_count++] = gap->number;
  const uint32_t last = --g->grains.count;
  *gap = g->grains.records[last];
}

// Removes what lies inside the shapes from the group that begins at `first`. Goes through it from its end, so what
// moves into a gap comes from behind the group. Returns how many were removed.
template <class Remove>
uint32_t drain_group(const Granular& g, const Record* records, const uint32_t* count, uint32_t first,
                     const ColliderFrame* shapes, uint32_t shape_count, const Remove& remove) {
  uint8_t inside[k_lane_group];
  uint32_t found = 0, removed = 0;
  const InsideArgs args = {records, *count, shapes, shape_count, inside};
  const uint32_t left = *count - first, lanes = left < k_lane_group ? left : k_lane_group;
  g.kernels->find_inside(&args, first, first + k_lane_group, &found);
  for (uint32_t l = lanes; found != 0 && l-- > 0;) {
    if (inside[l] != 0 && remove(first + l)) ++removed;
  }
  return removed;
}

}  // namespace

void flow_remove_particle(Granular* g, uint32_t i) {
  Particle* gap = &g->particles.records[0][i];
  g->flow.free_particles[g->flow.free_particle_count++] = number_of(*gap);
  if (is_awake(*gap)) --g->sleep.awake_count;
  const uint32_t last = --g->particles.count;
  if (i == last) return;
  *gap = g->particles.records[0][last];
  if (in_body(*gap)) bodies_note_row(g, i);
}

// Particles of sleeping groups may have moved to others. The next list build finds out which groups sleep.
void flow_after_removal(Granular* g) {
  g->neighbours.valid = false;
  substep_set_due(g, SubstepPhase::wake, false);
  g->sleep.waking_count = 0;
  sweep_particles_changed(g);
  particles_seal(g);
}

void flow_layout(Flow* f, const sandglass_granular_desc& d, Layout* layout) {
  f->free_particles = layout_region<uint32_t>(layout, "granular.free_particles", d.particle_capacity);
  f->free_grains = layout_region<uint32_t>(layout, "granular.free_grains", d.grain_capacity);
  f->emitters = layout_region<sandglass_emitter>(layout, "granular.emitters", d.emitter_capacity);
  f->emitter_states = layout_region<EmitterState>(layout, "granular.emitter_states", d.emitter_capacity);
  f->sinks = layout_region<ColliderFrame>(layout, "granular.sinks", d.sink_capacity);
}

void flow_reset(Flow* f, const sandglass_granular_desc& d) {
  f->free_particle_count = f->free_grain_count = f->emitter_count = f->sink_count = 0;
  f->counts = {};
  for (uint32_t e = 0; e < d.emitter_capacity; ++e) f->emitter_states[e] = {};
}

// Numbers in use and free ones together are 0, 1, 2, ...; without free ones the next is the count.
uint32_t flow_take_particle_number(Flow* f, uint32_t count) {
  return f->free_particle_count != 0 ? f->free_particles[--f->free_particle_count] : count;
}

uint32_t flow_take_grain_number(Flow* f, uint32_t count) {
  return f->free_grain_count != 0 ? f->free_grains[--f->free_grain_count] : count;
}

void flow_take(Granular* g, const sandglass_frame_input& input) {
  g->flow.emitter_count = 0;
  for (uint32_t e = 0; e < input.emitter_count; ++e) {
    if (g->flow.emitter_count == g->desc.emitter_capacity ||
        !accept(*g, input.emitters[e], &g->flow.emitters[g->flow.emitter_count])) {
      ++g->counts.ignored_emitters;
    } else {
      ++g->flow.emitter_count;
    }
  }
  // An emitter that is no longer passed starts from nothing when it comes back. A pause is not long enough to forget.
  for (uint32_t e = g->flow.emitter_count; e < g->desc.emitter_capacity && !time_paused(*g); ++e)
    g->flow.emitter_states[e] = {};
  g->flow.sink_count = 0;
  for (uint32_t s = 0; s < input.sink_count; ++s) {
    sandglass_collider accepted;
    if (g->flow.sink_count == g->desc.sink_capacity || !collider_accept(input.sinks[s], &accepted)) {
      ++g->counts.ignored_sinks;
    } else {
      colliders_pose(&accepted, 1, 0.0f, &g->flow.sinks[g->flow.sink_count++]);
    }
  }
}

void flow_emit(Granular* g, double seconds) {
  const double layer = static_cast<double>(k_spacing_radii * k_layer * g->desc.particle_radius);
  for (uint32_t e = 0; e < g->flow.emitter_count; ++e) {
    EmitterState& state = g->flow.emitter_states[e];
    const sandglass_emitter& emitter = g->flow.emitters[e];
    if (state.layer == 0) state.run = layer;  // the first comes at once
    state.run += seconds * static_cast<double>(emitter.speed);
    if (!sweep_takes_grains(*g)) continue;
    // Every other layer is the same. Counted once in a frame: one that finds no room costs nothing more.
    uint32_t sites[2] = {0, 0};
    while (state.run >= layer) {
      state.run -= layer;
      uint32_t& here = sites[state.layer % 2];
      if (here == 0) for_sites(emitter, g->desc.particle_radius, state.layer, [&](float, float) { ++here; });
      emit_layer(g, emitter, e, state.layer, here, static_cast<float>(state.run));
      ++state.layer;
    }
  }
}

bool flow_run_drain(Granular* g) {
  const uint32_t items = sleep_active_items(*g);
  const uint32_t end = items - g->substep.cursor < g->unit ? items : g->substep.cursor + g->unit;
  uint32_t removed = 0;
  if (g->substep.cursor == 0) bodies_begin_drain(&g->bodies);
  // From the last group to the first, so the particle that fills a gap has been looked at.
  for (uint32_t at = g->substep.cursor; at < end; at += k_lane_group) {
    const uint32_t first = g->sleep.active_groups[g->sleep.active_count - 1 - at / k_lane_group] * k_lane_group;
    if (first >= g->particles.count) continue;
    removed += drain_group(*g, as_records(g->particles.records[0]), &g->particles.count, first, g->flow.sinks,
                           g->flow.sink_count, [g](uint32_t i) {
                             const Particle& p = g->particles.records[0][i];
                             if (!is_awake(p)) return false;
                             if (in_body(p)) return bodies_note_inside(&g->bodies, body_of(p) - 1), false;
                             flow_remove_particle(g, i);
                             return true;
                           });
  }
  g->flow.counts.removed_particles += removed;
  if (removed != 0) flow_after_removal(g);
  g->substep.cursor = end;
  if (end < items) return false;
  bodies_drain(g);
  return true;
}

bool flow_run_grain_drain(Granular* g) {
  const uint32_t items = g->grain_sleep.group_count * k_lane_group;
  const uint32_t end = items - g->sweep.cursor < g->unit ? items : g->sweep.cursor + g->unit;
  uint32_t removed = 0;
  for (uint32_t at = g->sweep.cursor; at < end; at += k_lane_group) {
    const uint32_t first = g->grain_sleep.groups[g->grain_sleep.group_count - 1 - at / k_lane_group] * k_lane_group;
    if (first >= g->grains.count) continue;
    removed += drain_group(*g, as_records(g->grains.records), &g->grains.count, first, g->flow.sinks,
                           g->flow.sink_count, [g](uint32_t i) {
                             remove_grain(g, i);
                             return true;
                           });
  }
  g->flow.counts.removed_grains += removed;
  if (removed != 0) g->grain_sleep.groups_changed = true;
  g->sweep.cursor = end;
  return end >= items;
}

sandglass_status granular_remove(Granular* g, const sandglass_collider* region, uint32_t* particles, uint32_t* grains,
                                 const char** reason) {
  sandglass_collider accepted;
  if (region == nullptr) return refuse(reason, "sandglass_granular_remove: region is NULL: pass the shape to empty.");
  if (!collider_accept(*region, &accepted)) {
    return refuse(
        reason,
        "sandglass_granular_remove: region is not a usable shape: its numbers must be finite, its position within "
        "the coordinate limit, its sizes above 0, its rotation not zero, and its field made by this library.");
  }
  ColliderFrame shape;
  colliders_pose(&accepted, 1, 0.0f, &shape);
  sleep_wake_all(g);
  uint32_t removed = 0, removed_grains = 0;
  for (uint32_t group = (g->particles.count + k_lane_group - 1) / k_lane_group; group-- > 0;) {
    removed += drain_group(*g, as_records(g->particles.records[0]), &g->particles.count, group * k_lane_group, &shape,
                           1, [g](uint32_t i) {
                             if (in_body(g->particles.records[0][i])) return false;
                             flow_remove_particle(g, i);
                             return true;
                           });
  }
  for (uint32_t group = (g->grains.count + k_lane_group - 1) / k_lane_group; group-- > 0;) {
    removed_grains += drain_group(*g, as_records(g->grains.records), &g->grains.count, group * k_lane_group, &shape, 1,
                                  [g](uint32_t i) {
                                    remove_grain(g, i);
                                    return true;
                                  });
  }
  if (g->desc.particle_capacity != 0) flow_after_removal(g);
  if (removed_grains != 0) sweep_grains_removed(g);
  g->flow.counts.removed_particles += removed;
  g->flow.counts.removed_grains += removed_grains;
  if (particles != nullptr) *particles = removed;
  if (grains != nullptr) *grains = removed_grains;
  return accept(reason);
}

}  // namespace sandglass

// What comes and goes: emitters pour, sinks drain. world.h has the rules.
#include "kernels/whole.h"
#include "runtime/math/finite.h"
#include "runtime/math/random.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

constexpr float k_spacing_radii = 2.02f;  // of the poured lattice
constexpr float k_row = 0.8660254f;       // sqrt(3)/2
constexpr float k_layer = 0.81649658f;    // sqrt(2/3)
// Added to every coordinate, for perfect layers would stack. Two neighbours may each go all of it along the line between
// them, sqrt(3) of it: that is less than what the lattice leaves them, so no pair overlaps from the start.
constexpr float k_jitter_radii = 0.005f;
static_assert(2.0f * 1.7320508f * k_jitter_radii < k_spacing_radii - 2.0f);
constexpr float k_back_radii = k_spacing_radii * k_layer;  // that a particle may step back: to the next layer
constexpr float k_clear_radii = 0.9f;  // from a particle's centre to a collider, where its place is free
// By so much a lattice off the nozzle's middle comes back with each layer: about what gravity parts two layers by.
constexpr float k_centring_radii = 0.02f;
constexpr uint32_t k_batch = 64;  // sites added at once

}  // namespace

// Sites of a layer, before particles are put there.
struct Sites {
  SurfacePoint at[k_batch];
  uint64_t seeds[k_batch];  // what is drawn for the grains of each
  float back[k_batch];      // metres to step back
  bool taken[k_batch];
  uint32_t count;
  ColliderFrame box;  // what may overlap them has its centre in here
};

// Particles or grains to add.
struct Batch {
  float positions[3 * k_batch], velocities[3 * k_batch];
  uint32_t count;
};

namespace {

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

void find_axes(Nozzle* nozzle) {
  sandglass_collider frame = {};
  for (int k = 0; k < 4; ++k) frame.rotation[k] = nozzle->emitter.rotation[k];
  ColliderFrame posed;
  colliders_pose(&frame, 1, 0.0f, &posed);
  __builtin_memcpy(nozzle->axes, posed.axes, sizeof nozzle->axes);
}

// Sites of a layer: rows of a triangular lattice within the nozzle, every other layer in the hollows of the last. Calls
// take(x, z).
template <class Take>
void for_sites(const sandglass_emitter& e, float radius, uint32_t layer, const float shift[2], const Take& take) {
  const float a = k_spacing_radii * radius, reach = e.radius;
  const float shift_x = shift[0] + (layer % 2 == 0 ? 0.0f : 0.5f * a);
  const float shift_z = shift[1] + (layer % 2 == 0 ? 0.0f : a * k_row / 3.0f);
  const int32_t rows = to_whole<int32_t>(reach / (a * k_row)) + 2, columns = to_whole<int32_t>(reach / a) + 2;
  for (int32_t j = -rows; j <= rows; ++j) {
    for (int32_t i = -columns; i <= columns; ++i) {
      const float x = (static_cast<float>(i) + ((j & 1) != 0 ? 0.5f : 0.0f)) * a + shift_x;
      const float z = static_cast<float>(j) * a * k_row + shift_z;
      if (x * x + z * z <= reach * reach) take(x, z);
    }
  }
}

// The layer that sites belong to.
struct Layer {
  const Nozzle* nozzle;
  float direction[3];  // unit vector: of what leaves the nozzle
  float since;         // seconds since it left the nozzle
  float drop[3];       // by which it has fallen since
};

// Where a layer goes.
struct Pouring {
  Flow* flow;
  const Inlet* inlet;
  FrameCounts* counts;
};

void deny(const Pouring& to, uint32_t particles) {
  to.flow->counts.denied_particles += particles;
  to.counts->denied_particles += particles;
}

void flush(const Pouring& to, Batch* batch, bool grains) {
  // Room was checked for the whole layer. What can still fail is a site beyond the coordinate limit.
  const uint32_t particles = grains ? 0 : batch->count, fine = grains ? batch->count : 0;
  const bool came = inlet_let_in(*to.inlet, batch->positions, batch->velocities, particles, fine);
  batch->count = 0;
  if (!came) {
    deny(to, particles);
    return;
  }
  to.flow->counts.emitted_particles += particles;
  to.flow->counts.emitted_grains += fine;
}

void put(const Pouring& to, Batch* batch, bool grains, const float position[3], const float velocity[3]) {
  for (uint32_t k = 0; k < 3; ++k) {
    batch->positions[3 * batch->count + k] = position[k];
    batch->velocities[3 * batch->count + k] = velocity[k];
  }
  if (++batch->count == k_batch) flush(to, batch, grains);
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

// The sites step back until they do not overlap this particle.
void step_back(Sites* sites, const Layer& layer, const float particle[3], float radius) {
  const float touch2 = 4.0f * radius * radius;
  for (uint32_t s = 0; s < sites->count; ++s) {
    float length2 = 0.0f, ahead = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float difference = particle[k] - sites->at[s].position[k];
      length2 += difference * difference;
      ahead += difference * layer.direction[k];
    }
    const float aside2 = length2 - ahead * ahead;
    if (aside2 >= touch2) continue;
    const float reach = __builtin_sqrtf(touch2 - aside2), back = reach - ahead;
    if (back > sites->back[s] && -reach - ahead < k_back_radii * radius) sites->back[s] = back;
  }
}

// The sites step back from those of `count` records that overlap them.
void step_back_from(const Granular& g, Sites* sites, const Layer& layer, const Record* records, uint32_t count) {
  uint8_t inside[k_lane_group];
  const InsideArgs args = {records, count, &sites->box, 1, inside};
  for (uint32_t first = 0; first < count; first += k_lane_group) {
    uint32_t found = 0;
    g.kernels->find_inside(&args, first, first + k_lane_group, &found);
    for (uint32_t l = 0; found != 0 && l < k_lane_group; ++l) {
      if (inside[l] != 0) step_back(sites, layer, records[first + l].position, g.desc.particle_radius);
    }
  }
}

// A place is taken where a particle would still reach into a collider once it has gone on by a radius. So a nozzle may
// lie in a collider's surface.
void avoid_colliders(const Granular& g, Sites* sites, const Layer& layer) {
  const float r = g.desc.particle_radius;
  const uint32_t end = (sites->count + k_lane_group - 1) / k_lane_group * k_lane_group;
  const auto go_on = [&](float by) {
    for (uint32_t s = 0; s < sites->count; ++s)
      for (int k = 0; k < 3; ++k) sites->at[s].position[k] += by * layer.direction[k];
  };
  go_on(r);
  for (uint32_t s = sites->count; s < end; ++s) sites->at[s] = sites->at[0];  // whole vectors
  for (uint32_t c = 0; c < g.colliders.substep_count; ++c) {
    const SurfaceArgs args = {sites->at, &g.colliders.substep_frames[c]};
    uint32_t unused;
    g.kernels->surface_at(&args, 0, end, &unused);
    for (uint32_t s = 0; s < sites->count; ++s)
      sites->taken[s] = sites->taken[s] || sites->at[s].distance < k_clear_radii * r;
  }
  go_on(-r);
}

// Moves the sites to where they overlap nothing, or finds that there is no such place.
void find_room(const Granular& g, Sites* sites, const Layer& layer) {
  const float back_max = k_back_radii * g.desc.particle_radius;
  ColliderFrame& box = sites->box;
  box = {};
  box.shape = SANDGLASS_SHAPE_BOX;
  for (int k = 0; k < 3; ++k) {
    float low = 3e38f, high = -3e38f;
    for (uint32_t s = 0; s < sites->count; ++s) {
      const float c = sites->at[s].position[k];
      low = c < low ? c : low;
      high = c > high ? c : high;
    }
    box.axes[k][k] = 1.0f;
    box.position[k] = 0.5f * (low + high);
    box.size[k] = 0.5f * (high - low) + 2.0f * g.desc.particle_radius + back_max;
  }
  for (uint32_t s = 0; s < sites->count; ++s) sites->back[s] = 0.0f;
  find_extent(&box);
  step_back_from(g, sites, layer, as_records(g.particles.records[0]), g.particles.count);
  step_back_from(g, sites, layer, as_records(boundary_particles(g)), g.boundary.count);
  for (uint32_t s = 0; s < sites->count; ++s) {
    sites->taken[s] = sites->back[s] > back_max;
    for (int k = 0; k < 3; ++k) sites->at[s].position[k] -= sites->back[s] * layer.direction[k];
  }
  avoid_colliders(g, sites, layer);
}

// The grains of a particle that has come to `at`. `seed` is where the sequence of its numbers goes on.
void emit_grains(const Pouring& to, const Granular& g, const Layer& layer, const SurfacePoint& at, uint64_t seed,
                 Batch* batch) {
  const sandglass_emitter& e = layer.nozzle->emitter;
  const float r = g.desc.particle_radius;
  // A grain is no more than this before or after its particle, so that gravity turns none of them round.
  const float limit = e.speed / (g.gravity_length > 0.0f ? g.gravity_length : 1e-6f);
  // Grains that are behind the particles catch up with the next sweep.
  const float lag = static_cast<float>(g.time.grain_lag);
  for (uint32_t grain = 0; grain < e.grains_per_particle;) {
    float offset[3], length2 = 0.0f, along = 0.0f, position[3], velocity[3];
    for (float& o : offset) {
      seed = next_seed(seed);
      o = symmetric(seed);
      length2 += o * o;
    }
    if (length2 > 1.0f) continue;  // uniform within the ball
    for (int k = 0; k < 3; ++k) {
      along += r * offset[k] * layer.direction[k];
      velocity[k] = e.speed * layer.direction[k];
      position[k] = at.position[k] - layer.drop[k] - lag * velocity[k] + r * offset[k];
    }
    const float earlier = along / e.speed;
    fall(g, layer.since - lag + (earlier < -limit ? -limit : earlier > limit ? limit : earlier), position, velocity);
    put(to, batch, true, position, velocity);
    ++grain;
  }
}

// If the nozzle moves aside, the lattice stays behind and comes back to its middle in small steps: so a nozzle that
// stands still pours as much everywhere.
void follow_lattice(const Granular& g, EmitterState* state, Nozzle* nozzle) {
  const float* here = nozzle->emitter.position;
  const float a = k_spacing_radii * g.desc.particle_radius, row = a * k_row;
  float x = 0.0f, z = 0.0f;
  for (int k = 0; k < 3 && state->layer != 0; ++k) {
    x += (state->origin[k] - here[k]) * nozzle->axes[0][k];
    z += (state->origin[k] - here[k]) * nozzle->axes[2][k];
  }
  // To the nearest point of the lattice.
  const float rows = static_cast<float>(floor_whole(z / row + 0.5f));
  x -= 0.5f * a * rows;
  z -= row * rows;
  x -= a * static_cast<float>(floor_whole(x / a + 0.5f));
  const float off = __builtin_sqrtf(x * x + z * z), step = k_centring_radii * g.desc.particle_radius;
  const float left = off > step ? 1.0f - step / off : 0.0f;
  x *= left;
  z *= left;
  nozzle->shift[0] = x;
  nozzle->shift[1] = z;
  for (int k = 0; k < 3; ++k) state->origin[k] = here[k] + x * nozzle->axes[0][k] + z * nozzle->axes[2][k];
}

bool has_room(const Granular& g, const sandglass_emitter& e, uint32_t particles) {
  const uint64_t grains = static_cast<uint64_t>(particles) * e.grains_per_particle;
  return particles <= g.desc.particle_capacity - g.particles.count && grains <= g.desc.grain_capacity - g.grains.count;
}

void emit_sites(const Pouring& to, const Granular& g, Sites* sites, const Layer& layer) {
  const sandglass_emitter& e = layer.nozzle->emitter;
  const bool room = has_room(g, e, sites->count);  // a shifted layer may have some more
  Batch* batch = to.flow->batch;
  batch->count = 0;
  find_room(g, sites, layer);
  float velocity[3];
  for (int k = 0; k < 3; ++k) velocity[k] = e.speed * layer.direction[k] + layer.since * g.gravity[k];
  uint32_t free = 0;
  for (uint32_t s = 0; s < sites->count; ++s) {
    if (!room || sites->taken[s]) continue;
    sites->at[free] = sites->at[s];
    sites->seeds[free] = sites->seeds[s];
    put(to, batch, false, sites->at[free++].position, velocity);
  }
  if (batch->count != 0) flush(to, batch, false);
  deny(to, sites->count - free);
  for (uint32_t s = 0; s < free; ++s) emit_grains(to, g, layer, sites->at[s], sites->seeds[s], batch);
  if (batch->count != 0) flush(to, batch, true);
  sites->count = 0;
}

// `number` names the layer: of all layers of all emitters.
void emit_layer(const Pouring& to, const Granular& g, const Nozzle& nozzle, uint64_t number, float fallen) {
  const sandglass_emitter& e = nozzle.emitter;
  const uint32_t index = static_cast<uint32_t>(number), count = nozzle.sites[index % 2];
  if (!has_room(g, e, count)) return deny(to, count);
  Layer layer = {&nozzle, {}, fallen / e.speed, {}};
  for (int k = 0; k < 3; ++k) {
    layer.direction[k] = -nozzle.axes[1][k];
    layer.drop[k] = 0.5f * layer.since * layer.since * g.gravity[k];
  }
  Sites& sites = *to.flow->sites;
  sites.count = 0;
  uint64_t seed = next_seed(number);
  for_sites(e, g.desc.particle_radius, index, nozzle.shift, [&](float x, float z) {
    SurfacePoint& at = sites.at[sites.count];
    for (int k = 0; k < 3; ++k) {
      seed = next_seed(seed);
      at.position[k] = e.position[k] + x * nozzle.axes[0][k] + fallen * layer.direction[k] + z * nozzle.axes[2][k] +
                       k_jitter_radii * g.desc.particle_radius * symmetric(seed) + layer.drop[k];
    }
    sites.seeds[sites.count] = mix_bits(seed);
    if (++sites.count == k_batch) emit_sites(to, g, &sites, layer);
  });
  if (sites.count != 0) emit_sites(to, g, &sites, layer);
}

// The items of the group that begins at `first` that lie inside the shapes; if `going`, also those that have fallen or
// flown too far (departed.cpp).
uint32_t find_leaving(const Granular& g, const Record* records, uint32_t count, uint32_t first,
                      const ColliderFrame* shapes, uint32_t shape_count, bool going, uint32_t leaving[k_lane_group]) {
  uint8_t inside[k_lane_group];
  uint32_t found = 0, leave = 0;
  const InsideArgs args = {records, count, shapes, shape_count, inside};
  const uint32_t left = count - first, lanes = left < k_lane_group ? left : k_lane_group;
  g.kernels->find_inside(&args, first, first + k_lane_group, &found);
  for (uint32_t l = lanes; (found != 0 || going) && l-- > 0;) {
    if (inside[l] != 0 || (going && departed_is_gone(g, records[first + l].position))) leaving[leave++] = first + l;
  }
  return leave;
}

}  // namespace

uint32_t flow_find_inside(const Granular& g, const Record* records, uint32_t count, uint32_t first,
                          const ColliderFrame* shapes, uint32_t shape_count, uint32_t found[k_lane_group]) {
  return find_leaving(g, records, count, first, shapes, shape_count, false, found);
}

uint32_t flow_find_leaving_particles(const Granular& g, uint32_t first, uint32_t found[k_lane_group]) {
  const uint32_t count = find_leaving(g, as_records(g.particles.records[0]), g.particles.count, first, g.flow.sinks,
                                      g.flow.sink_count, g.departed.gone, found);
  uint32_t sand = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const Particle& p = g.particles.records[0][found[k]];
    if (!is_awake(p)) continue;
    if (in_body(p)) bodies_note_inside(g.bodies, body_of(p) - 1);
    else found[sand++] = found[k];
  }
  return sand;
}

uint32_t flow_find_leaving_grains(const Granular& g, uint32_t first, uint32_t found[k_lane_group]) {
  return find_leaving(g, as_records(g.grains.records), g.grains.count, first, g.flow.sinks, g.flow.sink_count,
                      g.departed.grains_go, found);
}

void flow_count_removed(Flow* f, uint64_t particles, uint64_t grains, uint64_t bodies) {
  f->counts.removed_particles += particles;
  f->counts.removed_grains += grains;
  f->counts.removed_bodies += bodies;
}

void flow_layout(Flow* f, const sandglass_granular_desc& d, Layout* layout) {
  f->free_particles = layout_region<uint32_t>(layout, "granular.free_particles", d.particle_capacity);
  f->free_grains = layout_region<uint32_t>(layout, "granular.free_grains", d.grain_capacity);
  f->nozzles = layout_region<Nozzle>(layout, "granular.nozzles", d.emitter_capacity);
  f->sites = layout_region<Sites>(layout, "granular.sites", d.emitter_capacity != 0 ? 1 : 0);
  f->batch = layout_region<Batch>(layout, "granular.batch", d.emitter_capacity != 0 ? 1 : 0);
  f->emitter_states = layout_region<EmitterState>(layout, "granular.emitter_states", d.emitter_capacity);
  f->sinks = layout_region<ColliderFrame>(layout, "granular.sinks", d.sink_capacity);
}

void flow_reset(Flow* f, const sandglass_granular_desc& d) {
  f->free_particle_count = f->free_grain_count = f->emitter_count = f->sink_count = 0;
  f->counts = {};
  for (uint32_t e = 0; e < d.emitter_capacity; ++e) f->emitter_states[e] = {};
}

void flow_restore(Flow* f, const SavedScene& s) {
  f->free_particle_count = s.free_particles;
  f->free_grain_count = s.free_grains;
  f->counts = s.state.flow;
}

void flow_free_particle_number(Flow* f, uint32_t number) { f->free_particles[f->free_particle_count++] = number; }

void flow_free_grain_number(Flow* f, uint32_t number) { f->free_grains[f->free_grain_count++] = number; }

// Numbers in use and free ones together are 0, 1, 2, ...; without free ones the next is the count.
uint32_t flow_take_particle_number(Flow* f, uint32_t count) {
  return f->free_particle_count != 0 ? f->free_particles[--f->free_particle_count] : count;
}

uint32_t flow_take_grain_number(Flow* f, uint32_t count) {
  return f->free_grain_count != 0 ? f->free_grains[--f->free_grain_count] : count;
}

void flow_take(Flow* f, const Granular& g, const sandglass_frame_input& input, FrameCounts* counts) {
  f->emitter_count = 0;
  for (uint32_t e = 0; e < input.emitter_count; ++e) {
    sandglass_emitter accepted;
    if (f->emitter_count == g.desc.emitter_capacity || !accept(g, input.emitters[e], &accepted)) {
      ++counts->ignored_emitters;
      continue;
    }
    Nozzle& nozzle = f->nozzles[f->emitter_count++];
    nozzle = {accepted, {}, {0.0f, 0.0f}, {0, 0}};
    find_axes(&nozzle);
  }
  // An emitter that is no longer passed starts from nothing when it comes back. A pause is not long enough to forget.
  for (uint32_t e = f->emitter_count; e < g.desc.emitter_capacity && !time_paused(g); ++e) f->emitter_states[e] = {};
  f->sink_count = 0;
  for (uint32_t s = 0; s < input.sink_count; ++s) {
    sandglass_collider accepted;
    if (f->sink_count == g.desc.sink_capacity || !collider_accept(input.sinks[s], &accepted)) {
      ++counts->ignored_sinks;
    } else {
      colliders_pose(&accepted, 1, 0.0f, &f->sinks[f->sink_count++]);
    }
  }
}

void flow_pass_time(Flow* f, double seconds) {
  for (uint32_t e = 0; e < f->emitter_count; ++e)
    f->emitter_states[e].run += seconds * static_cast<double>(f->nozzles[e].emitter.speed);
}

// Metres from one layer to the next.
static double layer_distance(const Granular& g) {
  return static_cast<double>(k_spacing_radii * k_layer * g.desc.particle_radius);
}

// The first comes at once.
static bool is_due(const EmitterState& state, double distance) { return state.layer == 0 || state.run >= distance; }

bool flow_is_due(const Granular& g) {
  if (!sweep_takes_grains(g)) return false;
  const double distance = layer_distance(g);
  for (uint32_t e = 0; e < g.flow.emitter_count; ++e) {
    if (is_due(g.flow.emitter_states[e], distance)) return true;
  }
  return false;
}

float flow_speed(const Flow& f) {
  float fastest = 0.0f;
  for (uint32_t e = 0; e < f.emitter_count; ++e)
    fastest = f.nozzles[e].emitter.speed > fastest ? f.nozzles[e].emitter.speed : fastest;
  return fastest;
}

void flow_emit(Flow* f, const Granular& g, const Inlet& inlet, FrameCounts* counts) {
  const Pouring to = {f, &inlet, counts};
  const double distance = layer_distance(g);
  for (uint32_t e = 0; e < f->emitter_count; ++e) {
    EmitterState& state = f->emitter_states[e];
    Nozzle& nozzle = f->nozzles[e];
    for (; is_due(state, distance); ++state.layer) {
      state.run = state.layer == 0 ? 0.0 : state.run - distance;
      follow_lattice(g, &state, &nozzle);
      // Counted once in a frame: a layer that finds no room costs nothing more.
      uint32_t& sites = nozzle.sites[state.layer % 2];
      const float unshifted[2] = {0.0f, 0.0f};
      if (sites == 0)
        for_sites(nozzle.emitter, g.desc.particle_radius, state.layer, unshifted, [&](float, float) { ++sites; });
      emit_layer(to, g, nozzle, (static_cast<uint64_t>(e) << 32) | state.layer, static_cast<float>(state.run));
    }
  }
}

}  // namespace sandglass

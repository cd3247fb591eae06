// A scene as bytes, and back.
//
// Saving first settles the scene, and restoring ends in the same state. So a scene that was saved goes on exactly as
// the one restored from the bytes, to the bit, whatever it was in the middle of.
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

constexpr uint32_t k_magic = 0x73676473;  // "sgds"
constexpr uint32_t k_version = 6;

struct Header {
  uint32_t magic, version;
  uint64_t bytes;     // all of it
  uint64_t checksum;  // FNV-1a over what follows the header
  uint32_t particles, free_particles, grains, free_grains, boundary, bodies, body_particles, emitters;
  float particle_radius;
  uint32_t colliders;  // slots
};

SavedState state_of(const Granular& g) {
  SavedState s = {};
  s.debt = g.time.debt;
  s.slipped = g.time.slipped;
  s.simulated = g.time.simulated;
  s.grain_lag = g.time.grain_lag;
  s.next_check = g.sleep.next_check;
  s.shown = g.time.grains;
  s.share = g.time.share;
  s.rate = g.time.rate;
  s.flow = g.flow.counts;
  __builtin_memcpy(s.low, g.particles.low, sizeof s.low);
  __builtin_memcpy(s.high, g.particles.high, sizeof s.high);
  s.speed_max = g.particles.speed_max;
  s.frame_step = g.time.frame_step;
  s.densest_body = g.bodies.densest;
  s.builds_per_substep = g.neighbours.builds_per_substep;
  s.bounds_known = g.particles.bounds_known ? 1 : 0;
  s.awake = g.sleep.awake_count;
  s.dither = g.contacts.dither;
  for (int k = 0; k < 3; ++k) s.resting_gravity[k] = g.resting_gravity[k];
  return s;
}

Header header_of(const Granular& g) {
  Header h = {};
  h.magic = k_magic;
  h.version = k_version;
  h.particles = g.particles.count;
  h.free_particles = g.flow.free_particle_count;
  h.grains = g.grains.count;
  h.free_grains = g.flow.free_grain_count;
  h.boundary = g.boundary.count;
  h.bodies = g.bodies.count;
  h.body_particles = g.bodies.particle_count;
  h.emitters = g.desc.emitter_capacity;
  h.particle_radius = g.desc.particle_radius;
  for (uint32_t slot = 0; slot < g.desc.collider_capacity; ++slot) {
    const bool seen =
        g.colliders.for_particles.seen[slot].present != 0 || g.colliders.for_grains.seen[slot].present != 0;
    if (g.colliders.known[slot].used != 0 || seen) h.colliders = slot + 1;
  }
  return h;
}

// The one walk over the arrays: counts, copies out or copies in.
template <class Visit>
void for_arrays(const Granular& g, const Header& h, SavedState* state, const Visit& visit) {
  visit(state, sizeof *state);
  visit(g.particles.records[0], h.particles * sizeof(Particle));
  visit(g.sleep.anchors, (static_cast<uint64_t>(h.particles) + h.free_particles) * sizeof(Anchor));
  visit(g.flow.free_particles, h.free_particles * sizeof(uint32_t));
  visit(g.grains.records, h.grains * sizeof(Grain));
  visit(g.flow.free_grains, h.free_grains * sizeof(uint32_t));
  visit(g.particles.records[0] == nullptr ? nullptr : boundary_particles(g), h.boundary * sizeof(Particle));
  visit(g.bodies.all, h.bodies * sizeof(RigidBody));
  visit(g.bodies.rest_shape, 3ull * h.body_particles * sizeof(float));
  visit(g.bodies.rows, h.body_particles * sizeof(uint32_t));
  visit(g.bodies.numbers, h.body_particles * sizeof(uint32_t));
  visit(g.flow.emitter_states, h.emitters * sizeof(EmitterState));
  visit(g.colliders.known, h.colliders * sizeof(KnownCollider));
  visit(g.colliders.for_particles.seen, h.colliders * sizeof(SeenCollider));
  visit(g.colliders.for_grains.seen, h.colliders * sizeof(SeenCollider));
}

uint64_t size_of(const Granular& g, const Header& h) {
  uint64_t bytes = sizeof(Header);
  SavedState unused;
  for_arrays(g, h, &unused, [&bytes](const void*, uint64_t count) { bytes += count; });
  return bytes;
}

// What no scene exceeds. Sand is slowed to a speed that the shortest sub-step and the largest radius leave below this.
constexpr float k_speed_bound = 1e10f;
constexpr float k_spin_bound = 1e15f;  // rad/s; that speed at a tenth of the smallest radius
constexpr double k_lag_bound = 10.0;   // seconds that grains without particles may be behind; scenes hold some frames
// List builds in a sub-step: a frame may build lists, lose them to what the app removes, and build them again.
constexpr float k_builds_bound = 16.0f;

template <class Item>
bool sound_motion(const Item* items, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    if (!all_within(items[i].position, 3, -k_coordinate_bound, k_coordinate_bound) ||
        !all_within(items[i].velocity, 3, -k_speed_bound, k_speed_bound))
      return false;
  }
  return true;
}

uint32_t number_of(const Grain& grain) { return grain.number; }

// Whether the numbers of `count` items and the `free` ones are 0, 1, 2, ... in some order. marks: count + free words.
template <class Item>
bool sound_numbers(const Item* items, uint32_t count, const uint32_t* free, uint32_t free_count, uint32_t* marks) {
  const uint64_t all = static_cast<uint64_t>(count) + free_count;
  for (uint64_t i = 0; i < all; ++i) marks[i] = 0;
  for (uint64_t i = 0; i < all; ++i) {
    const uint32_t number = i < count ? number_of(items[i]) : free[i - count];
    if (number >= all || marks[number]++ != 0) return false;
  }
  return true;
}

bool sound_state(const Granular& g, const Header& h, const SavedState& s) {
  const double times[] = {s.debt,          s.slipped,     s.simulated,  s.grain_lag,  s.next_check,
                          s.shown.reached, s.shown.shown, s.shown.rate, s.shown.spare};
  for (const double t : times) {
    if (!is_finite(t)) return false;
  }
  for (int k = 0; k < 3; ++k) {
    // The particles of a body may lie beyond the bound, by the body's size.
    constexpr float k_bound = 4.0f * k_coordinate_bound;
    if (h.particles != 0 && !(within(s.low[k], -k_bound, k_bound) && within(s.high[k], s.low[k], k_bound)))
      return false;
  }
  // A settled scene's grains have followed its particles; where those began is not saved.
  const double lag_bound = h.grains != 0 && h.particles != 0 ? k_time_resolution : k_lag_bound;
  if (!within(s.debt, 0.0, 1.0) || !(s.slipped >= 0.0) || !within(s.grain_lag, 0.0, lag_bound)) return false;
  if (!within(s.share, 0.0, 1.0) || !within(s.rate, 0.0, 1.0) || !(s.share > 0.0 && s.rate > 0.0)) return false;
  if (!within(s.shown.rate, 0.0, 10.0) || !within(s.shown.spare, 0.0, 10.0) || !(s.shown.shown <= s.shown.reached))
    return false;
  if (!is_finite(s.speed_max) || !within(s.frame_step, 0.0f, 1.0f) || !within(s.densest_body, 0.0f, 1e3f)) return false;
  if (!within(s.builds_per_substep, 0.0f, k_builds_bound) || !gravity_fits(s.resting_gravity)) return false;
  // What has run out of a nozzle comes at once when it is restored: no more than a second's.
  const float fastest = g.desc.courant * g.desc.particle_radius / g.substep.shortest;
  const double run_max = static_cast<double>((fastest < 100.0f ? fastest : 100.0f) + 4.0f * g.desc.particle_radius);
  for (uint32_t e = 0; e < h.emitters; ++e) {
    const EmitterState& state = g.flow.emitter_states[e];
    if (!within(state.run, 0.0, run_max) || !all_within(state.origin, 3, -k_coordinate_bound, k_coordinate_bound))
      return false;
  }
  return true;
}

bool at_rest(const RigidBody& body) {
  for (int k = 0; k < 3; ++k)
    if (body.linear[k] != 0.0f || body.angular[k] != 0.0f) return false;
  return true;
}

// What a removed body leaves: nothing but zeros.
bool is_hole(const RigidBody& body) {
  double sum = static_cast<double>(body.first);
  for (int k = 0; k < 3; ++k) {
    const float moves = __builtin_fabsf(body.linear[k]) + __builtin_fabsf(body.angular[k]);
    sum += __builtin_fabs(body.center[k]) + static_cast<double>(moves);
  }
  for (int k = 0; k < 4; ++k) sum += __builtin_fabs(body.rotation[k]);
  return sum == 0.0;  // not for NaN
}

// A body is a unit quaternion and particles that are where its pose says, all awake or all asleep, and at rest then.
bool sound_body(const Granular& g, const RigidBody& body, uint32_t number, uint32_t particles) {
  double length2 = 0.0;
  for (int k = 0; k < 4; ++k) length2 += body.rotation[k] * body.rotation[k];
  if (!within(length2, 0.99, 1.01)) return false;
  for (int k = 0; k < 3; ++k) {
    if (!within(body.center[k], -static_cast<double>(k_coordinate_bound), static_cast<double>(k_coordinate_bound)) ||
        !within(body.linear[k], -k_speed_bound, k_speed_bound) || !within(body.angular[k], -k_spin_bound, k_spin_bound))
      return false;
  }
  float mobility = 0.0f;
  for (uint32_t slot = body.first; slot < body.first + body.count; ++slot) {
    const uint32_t row = g.bodies.rows[slot];
    if (row >= particles) return false;
    const Particle& p = g.particles.records[0][row];
    if (body_of(p) != number || number_of(p) != g.bodies.numbers[slot]) return false;
    if (g.sleep.anchors[number_of(p)].body_slot != slot) return false;
    if (slot == body.first) mobility = p.mobility;
    float at[3];
    bodies_place(g.bodies, body, slot, at);
    // Positions are rounded to floats; moving a scene turns particles and poses apart.
    const float slack = g.desc.particle_radius + 1e-3f;
    for (int k = 0; k < 3; ++k) {
      if (!within(at[k] - p.position[k], -slack, slack)) return false;
    }
    if (p.mobility != mobility) return false;
    if (is_asleep(p) && !at_rest(body)) return false;
  }
  return true;
}

bool sound_pose(const Pose& p, sandglass_shape shape) {
  const float* q = p.rotation;
  // A moved scene may take colliders that nobody passes any more beyond the bound.
  constexpr float k_far = 1e6f;
  const uint32_t sizes = shape == SANDGLASS_SHAPE_CAPSULE ? 2 : shape >= SANDGLASS_SHAPE_BOX ? 3 : shape;
  for (uint32_t k = 0; k < sizes; ++k) {
    if (!(p.size[k] > 0.0f)) return false;
  }
  return all_within(p.position, 3, -k_far, k_far) && all_within(p.size, 3, -k_far, k_far) &&
         within(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 0.99f, 1.01f);
}

bool sound_shape(sandglass_shape shape) {
  return shape >= SANDGLASS_SHAPE_HALF_SPACE && shape <= SANDGLASS_SHAPE_RELIEF;
}

bool sound_known(const KnownCollider& known) {
  if (known.used == 0) return true;
  const HeldPose& p = known.pose;
  constexpr float k_speed = 2e4f, k_path = 1e6f, k_long = 1e9f;
  const Pose* poses[] = {&p.held.pose, &p.given, &p.stand};
  bool good = known.used == 1 && sound_shape(known.shape) && p.follows <= 1 && p.believed <= 1 &&
              within(known.absent, 0.0f, k_long);
  for (const Pose* pose : poses) good = good && sound_pose(*pose, known.shape);
  good = good && all_within(p.held.linear, 3, -k_speed, k_speed) && all_within(p.held.angular, 3, -k_speed, k_speed);
  good = good && all_within(p.run, 6, -k_path, k_path) && all_within(p.missing_velocity, 6, -k_speed, k_speed);
  good = good && all_within(p.slide, 6, -k_speed, k_speed) && all_within(p.pose_velocity, 6, -k_long, k_long);
  const float lengths[] = {p.since_turn, p.since_velocity, p.since_gap, p.age, p.stood, p.speed, p.last_speed};
  good = good && all_within(lengths, 7, 0.0f, k_long) && within(p.interval, 1.0f, k_long);
  return good;
}

bool sound_seen(const SeenCollider& seen) {
  return seen.present == 0 || (seen.present == 1 && sound_shape(seen.shape) && sound_pose(seen.pose, seen.shape));
}

// Everything that is used as an index, or that something else is computed from. Runs on the restored arrays; a scene
// that fails is reset.
bool sound(const Granular& g, const Header& h, const SavedState& s) {
  if (!sound_state(g, h, s)) return false;
  if (!sound_motion(g.particles.records[0], h.particles) || !sound_motion(g.grains.records, h.grains)) return false;
  if (!sound_motion(boundary_particles(g), h.boundary)) return false;
  // The lists are invalid by now: their memory serves for marks. The keys of the last sort do for the grains.
  if (!sound_numbers(g.particles.records[0], h.particles, g.flow.free_particles, h.free_particles, g.neighbours.lists))
    return false;
  if (h.grains + static_cast<uint64_t>(h.free_grains) != 0 &&
      !sound_numbers(g.grains.records, h.grains, g.flow.free_grains, h.free_grains, g.grains.sort.keys))
    return false;
  for (uint32_t i = 0; i < h.boundary; ++i) {
    if (!is_fixed(boundary_particles(g)[i])) return false;
  }
  for (uint32_t i = 0; i < h.grains; ++i) {
    if (!within(g.grains.records[i].still_sweeps, 0.0f, 1e9f)) return false;
  }
  for (uint32_t slot = 0; slot < h.colliders; ++slot) {
    const Colliders& c = g.colliders;
    if (!sound_known(c.known[slot]) || !sound_seen(c.for_particles.seen[slot]) || !sound_seen(c.for_grains.seen[slot]))
      return false;
  }
  uint32_t slots = 0, awake = 0, in_bodies = 0;
  for (uint32_t b = 0; b < h.bodies; ++b) {
    const RigidBody& body = g.bodies.all[b];
    if (body.count == 0 && (b + 1 == h.bodies || !is_hole(body))) return false;
    if (body.count > h.body_particles - slots || body.first > h.body_particles - body.count) return false;
    if (body.count != 0 && !sound_body(g, body, b + 1, h.particles)) return false;
    slots += body.count;
  }
  if (slots != h.body_particles) return false;
  for (uint32_t i = 0; i < h.particles; ++i) {
    const Particle& p = g.particles.records[0][i];
    if (!within(inverse_mass(p), 1e-4f, 1e4f)) return false;
    if (is_asleep(p) != (g.sleep.anchors[number_of(p)].quiet == k_asleep)) return false;
    awake += is_awake(p) ? 1u : 0u;
    in_bodies += in_body(p) ? 1u : 0u;
  }
  return awake == s.awake && in_bodies == h.body_particles;
}

}  // namespace

uint64_t granular_save_bytes(const Granular& g) { return size_of(g, header_of(g)); }

sandglass_status saved_write(const Granular& g, void* data, uint64_t bytes, uint64_t* written, const char** reason) {
  Header h = header_of(g);
  h.bytes = size_of(g, h);
  if (bytes < h.bytes)
    return refuse(reason, SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                  "bytes is less than the scene needs: ask sandglass_scene_save_bytes.");
  SavedState s = state_of(g);
  uint8_t* to = static_cast<uint8_t*>(data) + sizeof h;
  for_arrays(g, h, &s, [&to](const void* from, uint64_t count) {
    if (to != nullptr && from != nullptr) __builtin_memcpy(to, from, count);
    to += count;
  });
  h.checksum = hash_bytes(static_cast<const uint8_t*>(data) + sizeof h, h.bytes - sizeof h);
  __builtin_memcpy(data, &h, sizeof h);
  *written = h.bytes;
  return accept(reason);
}

sandglass_status saved_check(const Granular& g, const void* data, uint64_t bytes, const char** reason) {
  Header h;
  if (data == nullptr) return refuse(reason, "data is NULL: pass the bytes that sandglass_scene_save wrote.");
  if (bytes < sizeof h) return refuse(reason, "the data is shorter than any saved scene: it was cut.");
  __builtin_memcpy(&h, data, sizeof h);
  if (h.magic != k_magic)
    return refuse(reason, "the data is no saved scene: pass the bytes that sandglass_scene_save wrote.");
  if (h.version != k_version)
    return refuse(reason,
                  "the data has the format of another version of the library: save again with "
                  "this one.");
  const sandglass_granular_desc& d = g.desc;
  if (h.bytes != bytes || hash_bytes(static_cast<const uint8_t*>(data) + sizeof h, bytes - sizeof h) != h.checksum)
    return refuse(reason, "the bytes are cut or damaged: pass all that sandglass_scene_save wrote.");
  if (h.particle_radius != d.particle_radius)
    return refuse(reason, "the scene was saved with another granular.particle_radius: create it with that one.");
  if (static_cast<uint64_t>(h.particles) + h.free_particles > d.particle_capacity ||
      static_cast<uint64_t>(h.grains) + h.free_grains > d.grain_capacity || h.boundary > d.boundary_capacity ||
      h.bodies > d.body_capacity || h.body_particles > d.body_particle_capacity || h.emitters > d.emitter_capacity ||
      h.colliders > d.collider_capacity) {
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "the saved scene holds more than this one has room for: raise its capacities.");
  }
  if (size_of(g, h) != bytes)
    return refuse(reason, "the bytes are cut or damaged: pass all that sandglass_scene_save wrote.");
  return accept(reason);
}

bool saved_read(const Granular& g, const void* data, SavedScene* saved) {
  Header h;
  __builtin_memcpy(&h, data, sizeof h);
  SavedState s = {};
  const uint8_t* from = static_cast<const uint8_t*>(data) + sizeof h;
  for_arrays(g, h, &s, [&from](void* to, uint64_t count) {
    if (to != nullptr && from != nullptr) __builtin_memcpy(to, from, count);
    from += count;
  });
  *saved = {h.particles, h.free_particles, h.grains, h.free_grains, h.boundary, h.bodies, h.body_particles, s};
  return sound(g, h, s);
}

}  // namespace sandglass

// The records of the granular stages: Particle and Grain. Both are 32 bytes long and 32-byte aligned, because a kernel
// loads a record as 8 lanes. The enumerators below name the lanes.
//
// A particle is in one of three states. Its field `mobility` holds the state and the inverse mass together:
//   above 0   awake: it moves, and this is its inverse mass; a sand particle's is 1
//   0         fixed: it never moves and has infinite mass (boundary and padding)
//   below 0   asleep: it stands still until something wakes it; its inverse mass is minus this
// A contact pass asks for the state of every neighbour, so the state has no field of its own. Everything but the
// kernels reads and writes it through the functions of this file.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sandglass {

constexpr uint32_t k_record_floats = 8;
constexpr uint32_t k_number_mask = 0x007fffff;
constexpr uint32_t k_departed = 0x00800000;
constexpr uint32_t k_body_shift = 24;
constexpr uint32_t k_body_mask = 0xff000000;
constexpr uint32_t k_inert_identity = ~0u;
// Metres. An inert particle has this coordinate along every axis. It pads vectors and neighbour rows, and nothing
// touches it.
constexpr float k_inert_position = 1e6f;

struct alignas(32) Particle {
  float position[3];  // metres
  float mobility;     // state and inverse mass, see above
  // Between sub-steps the velocity in m/s; between the passes of one sub-step its displacement so far, in metres.
  float velocity[3];
  // The number by which the app knows it; k_departed, where it can reach nothing (Departed, in runtime/sand/solver.h); in
  // k_body_mask the number of its rigid body, 0 for sand.
  uint32_t identity;
};

struct alignas(32) Grain {
  float position[3];   // metres
  uint32_t number;     // by which the app knows it
  float velocity[3];   // m/s
  float still_sweeps;  // sweeps in a row in which it kept still
};

// What kernels take that only read positions: a particle or a grain.
struct alignas(32) [[gnu::may_alias]] Record {
  float position[3];
  float others[5];
};

// What the kernel takes that wakes sleepers: a particle, or a sphere around a group of grains.
struct alignas(32) [[gnu::may_alias]] Sleeper {
  float position[3];
  float mobility;  // as a particle's
  float radius;    // metres; 0 for a particle, since what sleeps has no velocity
  float before;    // of a sphere: `mobility` before the kernel ran
  float unused[2];
};

// Where a collider's surface is asked for.
struct alignas(32) [[gnu::may_alias]] SurfacePoint {
  float position[3];
  float distance;   // metres; written by the kernel
  float normal[3];  // written by the kernel
  float unused;
};

// The lanes of a record.
enum : uint32_t {
  k_x,
  k_y,
  k_z,
  k_mobility,  // of a particle or a sleeper
  k_vx,
  k_vy,
  k_vz,
  k_identity,  // of a particle
  k_number = k_mobility,
  k_free_fall = k_mobility,     // of a particle in the grains' snapshot
  k_still_sweeps = k_identity,  // of a grain
  k_radius = k_vx,              // of a sleeper
  k_distance = k_mobility,      // of a surface point
  k_normal = k_vx,
};

#define SANDGLASS_LANE(Type, field, lane) static_assert(offsetof(Type, field) == sizeof(float) * (lane))
SANDGLASS_LANE(Particle, position, k_x);
SANDGLASS_LANE(Particle, mobility, k_mobility);
SANDGLASS_LANE(Particle, velocity, k_vx);
SANDGLASS_LANE(Particle, identity, k_identity);
SANDGLASS_LANE(Grain, position, k_x);
SANDGLASS_LANE(Grain, number, k_number);
SANDGLASS_LANE(Grain, velocity, k_vx);
SANDGLASS_LANE(Grain, still_sweeps, k_still_sweeps);
SANDGLASS_LANE(Record, position, k_x);
SANDGLASS_LANE(Sleeper, position, k_x);
SANDGLASS_LANE(Sleeper, mobility, k_mobility);
SANDGLASS_LANE(Sleeper, radius, k_radius);
SANDGLASS_LANE(SurfacePoint, position, k_x);
SANDGLASS_LANE(SurfacePoint, distance, k_distance);
SANDGLASS_LANE(SurfacePoint, normal, k_normal);
#undef SANDGLASS_LANE
static_assert(sizeof(Particle) == sizeof(float) * k_record_floats);
static_assert(sizeof(Grain) == sizeof(Particle) && sizeof(Record) == sizeof(Particle) &&
              sizeof(Sleeper) == sizeof(Particle) && sizeof(SurfacePoint) == sizeof(Particle));

// ---- the state of a particle
//
// Functions in kernels' headers are static: every instruction set's table needs its own copy, inlined or not.

static inline bool is_awake(const Particle& p) { return p.mobility > 0.0f; }
static inline bool is_asleep(const Particle& p) { return p.mobility < 0.0f; }
static inline bool is_fixed(const Particle& p) { return p.mobility == 0.0f; }

// 1 for a sand particle, 0 for infinite mass.
static inline float inverse_mass(const Particle& p) { return __builtin_fabsf(p.mobility); }

// An awake particle falls asleep: it stops.
static inline void put_to_sleep(Particle* p) {
  p->mobility = -p->mobility;
  p->velocity[0] = p->velocity[1] = p->velocity[2] = 0.0f;
}

// A sleeping particle wakes, at rest.
static inline void wake(Particle* p) { p->mobility = -p->mobility; }

// Sleepers of the other kind: spheres.
static inline bool is_awake(const Sleeper& s) { return s.mobility > 0.0f; }
static inline void set_asleep(Sleeper* s, bool asleep) { s->mobility = s->before = asleep ? -1.0f : 1.0f; }
static inline bool was_woken(const Sleeper& s) { return s.mobility > 0.0f && s.before < 0.0f; }

// ---- the share of free fall
//
// In the snapshot that grains follow, the state of a particle does not count. There the field holds how nearly the
// particle fell freely since the last sweep: 1 if nothing touched it, 0 for what lies, flows or has just hit something.

static inline float free_fall(const Particle& p) { return p.mobility; }
static inline void set_free_fall(Particle* p, float share) { p->mobility = share; }

// ---- the identity of a particle

static inline uint32_t number_of(const Particle& p) { return p.identity & k_number_mask; }
// 0: sand. Rigid bodies count from 1.
static inline uint32_t body_of(const Particle& p) { return p.identity >> k_body_shift; }
static inline bool in_body(const Particle& p) { return p.identity >> k_body_shift != 0; }
static inline bool is_inert(const Particle& p) { return p.identity == k_inert_identity; }
static inline bool has_departed(const Particle& p) { return (p.identity & k_departed) != 0; }
static inline void set_departed(Particle* p, bool departed) {
  p->identity = (p->identity & ~k_departed) | (departed ? k_departed : 0);
}
static inline void join_body(Particle* p, uint32_t body, float inverse_mass) {
  p->identity = number_of(*p) | (body << k_body_shift);
  p->mobility = inverse_mass;
}

// An awake particle of a sand particle's mass.
static inline Particle moving_particle(const float position[3], const float velocity[3], uint32_t number) {
  return {{position[0], position[1], position[2]}, 1.0f, {velocity[0], velocity[1], velocity[2]}, number};
}
static inline Particle fixed_particle(const float position[3], uint32_t number) {
  return {{position[0], position[1], position[2]}, 0.0f, {0.0f, 0.0f, 0.0f}, number};
}
static inline Particle inert_particle() {
  return {{k_inert_position, k_inert_position, k_inert_position}, 0.0f, {0.0f, 0.0f, 0.0f}, k_inert_identity};
}
// A grain that has not kept still yet.
static inline Grain moving_grain(const float position[3], const float velocity[3], uint32_t number) {
  return {{position[0], position[1], position[2]}, number, {velocity[0], velocity[1], velocity[2]}, 0.0f};
}

// ---- views

static inline const Record* as_records(const Particle* p) { return reinterpret_cast<const Record*>(p); }
static inline const Record* as_records(const Grain* g) { return reinterpret_cast<const Record*>(g); }
static inline Record* as_records(Particle* p) { return reinterpret_cast<Record*>(p); }
static inline Record* as_records(Grain* g) { return reinterpret_cast<Record*>(g); }
// Of a record that is a particle.
static inline const Particle& as_particle(const Record& r) { return reinterpret_cast<const Particle&>(r); }
static inline Sleeper* as_sleepers(Particle* p) { return reinterpret_cast<Sleeper*>(p); }

}  // namespace sandglass

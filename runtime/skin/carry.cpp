// What is shown at the end of a frame whose skin is not complete. The mesh before is carried along: each vertex goes
// with its particle. Where a collider's motion explains the particle's displacement best, it goes rigidly with that;
// what is left of it is held to about a node. So sand moves in every frame, and with its vessel, however slow the
// processor is. Loose sand is where its particles are; sand that came since the mesh was gathered is loose, before the
// first mesh all of it, and from when most of a mesh's sand has left it. What is made goes on from the mesh as it was
// made.
//
// It belongs to what closes a frame: all its units run there, so that no frame shows a mesh of two moments.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/sand/holding.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_offset_radii_max = 1.5f;  // that a vertex is carried beside a motion: about a node
constexpr float k_left_radii = 6.0f;        // one that went further has left the mesh: that is nodes away from it
constexpr float k_other_radii = 16.0f;      // one that went further has taken the number of one that left
constexpr uint32_t k_unit_items = 4096;     // particles and vertices: about 0.2 ms of a phone
constexpr float k_motion_min = 1e-5f;       // metres, or of a turn: the rest is rounding

bool same_bytes(const void* a, const void* b, size_t count) { return memcmp(a, b, count) == 0; }

bool is_begun(const SkinState& s) {
  return s.carry.frame == s.frame && s.carry.substeps == s.granular->counts.moments();
}

bool is_due(const SkinState& s) {
  const uint32_t substeps = s.granular->counts.moments();
  if (!s.valid && s.granular->particles.count == 0) return false;
  return (skin_has_work(s) || substeps != 0) && (s.shown.frame != s.frame || s.shown.substeps != substeps);
}

bool is_alike(const RigidMotion& a, const RigidMotion& b) {
  float square = square_of(a.displacement(a.from) - b.displacement(a.from));
  for (int k = 0; k < 3; ++k) square += square_of(a.turn[k] - b.turn[k]);
  return square < k_motion_min * k_motion_min;
}

// The different motions of colliders since the mesh was gathered, as sand met them then and meets them now.
void find_motions(SkinCarry* carry, const SkinState& s) {
  const Colliders& c = s.granular->colliders;
  carry->motion_count = 0;
  for (uint32_t i = 0; i < c.solid_count && carry->motion_count < k_skin_motions; ++i) {
    if (c.slots[i] >= s.desc.collider_capacity) continue;
    const ColliderFrame& from = carry->met[c.slots[i]];
    ColliderFrame to;
    colliders_pose(&c.given[i], 1, colliders_behind(*s.granular), &to);
    if (from.shape != to.shape) continue;
    const SkinMotion motion = {rigid_motion(from, to), holding_encloses(from)};
    RigidMotion still = {};
    still.from = motion.from;
    bool known = is_alike(motion, still);
    for (uint32_t k = 0; k < carry->motion_count && !known; ++k) known = is_alike(motion, carry->motions[k]);
    if (!known) carry->motions[carry->motion_count++] = motion;
  }
}

void begin_carry(SkinCarry* carry, const SkinState& s) {
  const SkinMesh& made = s.meshes.front;
  find_motions(carry, s);
  carry->frame = s.frame;
  carry->substeps = s.granular->counts.moments();
  carry->record = carry->chunk = carry->flying = carry->lying = 0;
  carry->left_surplus = 0;
  carry->motion = k_none;
  carry->changed = false;
  for (uint32_t i = 0; i < s.desc.particle_capacity; ++i) carry->carried[i] = {Quad{}, k_none, k_none};
  for (uint32_t i = 0; i < made.flying + made.lying; ++i)
    if (made.loose[i].number < s.desc.particle_capacity) carry->carried[made.loose[i].number].loose = i;
}

void show_loose(SkinCarry* carry, SkinShown* shown, uint32_t capacity, const sandglass_skin_loose& loose, bool flies) {
  if (carry->flying + carry->lying == capacity) return;
  shown->loose[flies ? carry->flying++ : capacity - ++carry->lying] = loose;
}

// How far a particle has gone with which motion, and beside it. False: it was not there when the mesh was gathered.
bool find_offset(SkinCarry* carry, const SkinState& s, const Particle& p, SkinCarried* carried) {
  const float radius = s.desc.particle_radius, offset_max = k_offset_radii_max * radius, other = k_other_radii * radius;
  const float left = k_left_radii * radius;
  const float offset_min = static_cast<float>(k_skin_held) / k_skin_steps * s.lattice.spacing;
  const float* from = carry->from + 3 * number_of(p);
  if (from[0] == k_skin_nowhere || s.shown.lost) return false;
  const Quad at = quad(from), displacement = quad(p.position) - at;
  Quad offset = displacement;
  float square = square_of(offset);
  bool enclosed = false;
  for (uint32_t m = 0; m < carry->motion_count; ++m) {
    const SkinMotion& motion = carry->motions[m];
    const Quad rest = displacement - motion.displacement(at);
    const float square_rest = square_of(rest);
    if (motion.encloses == enclosed ? !(square_rest < square) : enclosed) continue;
    enclosed = motion.encloses;
    square = square_rest;
    carried->motion = m;
    offset = rest;
  }
  const float scale = square > offset_max * offset_max ? offset_max / __builtin_sqrtf(square) : 1.0f;
  carried->offset = square > offset_min * offset_min ? scale * offset : Quad{};
  if (carried->loose != k_none) return true;
  carry->left_surplus += square > left * left ? 1 : -1;
  return square < other * other;
}

void carry_particle(SkinCarry* carry, SkinShown* shown, const SkinState& s, const Particle& p) {
  const SkinMesh& made = s.meshes.front;
  if (in_body(p) || has_departed(p)) return;
  const uint32_t number = number_of(p);
  SkinCarried none = {Quad{}, k_none, k_none};
  SkinCarried& carried = number < s.desc.particle_capacity ? carry->carried[number] : none;
  const bool known = &carried != &none && find_offset(carry, s, p, &carried);
  sandglass_skin_loose loose = {};
  float falls;
  bool flies = carried.loose < made.flying;
  if (carried.loose != k_none) loose = made.loose[carried.loose];
  else if (known) return;
  memcpy(loose.position, p.position, sizeof loose.position);
  if (!known) {
    loose.weight = 1.0f;
    loose.number = number;
    skin_find_fall(s, p.position, p.velocity, &falls, &flies);
    for (uint32_t a = 0; a < 3; ++a)
      loose.vector[s.lattice.axis[a]] = flies ? p.velocity[s.lattice.axis[a]] : s.lattice.sign[a] * s.lattice.up[a];
  }
  show_loose(carry, shown, s.desc.particle_capacity, loose, flies);
}

// The whole numbers below, of what is bounded to 2^30.
QuadWhole floor_of(Quad v) {
  const Quad limit = Quad{} + 1073741824.0f, low = v < limit ? v : limit, bounded = low > -limit ? low : -limit;
  const QuadWhole whole = __builtin_convertvector(bounded, QuadWhole);
  return whole + (bounded < __builtin_convertvector(whole, Quad));
}

// A vertex without a particle goes with the motion of the one before it; the first ones as the first that has one.
sandglass_skin_vertex carried_vertex(SkinCarry* carry, sandglass_skin_vertex vertex, uint32_t anchor) {
  Quad offset = {};
  if (anchor != k_none) {
    offset = carry->carried[anchor].offset;
    carry->motion = carry->carried[anchor].motion;
  }
  if (carry->motion != k_none) {
    const SkinMotion& motion = carry->motions[carry->motion];
    offset += motion.displacement(quad(vertex.position));
    Quad normal = {};
    for (int k = 0; k < 3; ++k) normal[k] = static_cast<float>(vertex.normal[k]);
    const QuadWhole turned = floor_of(normal + motion.turned(normal) + 0.5f);
    for (int k = 0; k < 3; ++k)
      vertex.normal[k] = static_cast<int8_t>(turned[k] > -127 ? (turned[k] < 127 ? turned[k] : 127) : -127);
  }
  const QuadWhole turns = floor_of(offset * (65536.0f * carry->inverse_side));  // of the block of grains
  for (int k = 0; k < 3; ++k) {
    vertex.position[k] += offset[k];
    vertex.origin[k] = static_cast<uint16_t>(vertex.origin[k] + turns[k]);
  }
  return vertex;
}

// Whether a byte of the chunk that is shown has changed.
bool carry_chunk(SkinCarry* carry, SkinShown* shown, const SkinMesh& mesh, uint32_t c) {
  const sandglass_skin_chunk& made = mesh.chunks[c];
  sandglass_skin_chunk& chunk = shown->chunks[c];
  const uint32_t first = mesh.first_vertex[c];
  const sandglass_skin_vertex* before = chunk.vertices;
  sandglass_skin_vertex* to = shown->vertices + first;
  if (shown->lost) {
    const bool was = chunk.index_count != 0;
    chunk.vertex_count = chunk.index_count = 0;
    chunk.vertices = to;
    return was;
  }
  bool differs = false;
  for (uint32_t v = made.vertex_count; v-- != 0;)
    if (mesh.anchors[first + v] != k_none) carry->motion = carry->carried[mesh.anchors[first + v]].motion;
  Bounds box = k_nowhere;
  for (uint32_t v = 0; v < made.vertex_count; ++v) {
    const sandglass_skin_vertex vertex = carried_vertex(carry, mesh.vertices[first + v], mesh.anchors[first + v]);
    bounds_include(&box, vertex.position);
    differs = differs || !same_bytes(before + v, &vertex, sizeof vertex);
    to[v] = vertex;
  }
  if (!differs) return false;
  memcpy(chunk.low, box.low, sizeof box.low);
  memcpy(chunk.high, box.high, sizeof box.high);
  chunk.vertices = to;
  return true;
}

void end_carry(SkinShown* shown, const SkinCarry& carry, uint32_t capacity) {
  memmove(shown->loose + carry.flying, shown->loose + capacity - carry.lying, carry.lying * sizeof *shown->loose);
  const bool changed = carry.flying + carry.lying != 0 || shown->flying + shown->lying != 0;
  shown->flying = carry.flying;
  shown->lying = carry.lying;
  shown->frame = carry.frame;
  shown->substeps = carry.substeps;
  shown->lost = shown->lost || carry.left_surplus > 0;
  if (carry.changed || changed) ++shown->version;
}

// One unit.
void carry_on(SkinCarry* carry, SkinShown* shown, const SkinState& s) {
  const Particles& particles = s.granular->particles;
  const uint32_t chunks = s.bricks.chunks.capacity;
  if (!is_begun(s)) begin_carry(carry, s);
  uint32_t done = 0;
  for (; carry->record < particles.count && done < k_unit_items; ++carry->record, ++done)
    carry_particle(carry, shown, s, particles.records[0][carry->record]);
  for (; carry->chunk < chunks && done < k_unit_items; ++carry->chunk) {
    const uint32_t vertices = s.meshes.front.chunks[carry->chunk].vertex_count;
    if (vertices == 0) continue;
    done += vertices;
    if (!carry_chunk(carry, shown, s.meshes.front, carry->chunk)) continue;
    shown->chunks[carry->chunk].version = shown->version + 1;
    carry->changed = true;
  }
  if (carry->record == particles.count && carry->chunk == chunks) end_carry(shown, *carry, s.desc.particle_capacity);
}

void run(void* state, uint32_t) {
  SkinState& s = static_cast<sandglass_skin*>(state)->skin;
  carry_on(&s.carry, &s.shown, s);
}

uint32_t items_left(const SkinState& s) {
  return s.granular->particles.count - (is_begun(s) ? s.carry.record : 0) + s.meshes.front.vertex_count;
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  const uint32_t left = items_left(s);
  *unit = {k_skin_carry, left < k_unit_items ? left : k_unit_items, "skin.carry"};
  return is_due(s);
}

// Skins that are made within their frame are expected to be: then no time is kept.
uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const SkinState& s = static_cast<const sandglass_skin*>(state)->skin;
  if (!skin_has_work(s) || !(skin_is_late(s) || !s.valid)) return 0;
  entries[0] = {k_skin_carry, s.granular->particles.count + s.meshes.front.vertex_count};
  return 1;
}

}  // namespace

void carry_from_here(SkinCarry* carry, const SkinState& s) {
  memcpy(carry->met, s.solids.colliders, s.desc.collider_capacity * sizeof *carry->met);
  carry->frame = 0;
}

Stage skin_carry_stage(void* skin) { return {skin, next, run, forecast, k_skin_kinds, k_all_units, 1.0f}; }

}  // namespace sandglass

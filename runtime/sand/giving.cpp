// What no collider holds gives way to what goes on without time for it, in steps: it is put out of the collider and along
// with it, as far as friction has it, and what that runs into gives way in turn. Nothing is lifted by what is below it.
#include "runtime/sand/giving.h"

namespace sandglass {

// Sand that is not held, while it gives way.
struct OpenSand {
  Quad at, displacement;  // displacement: of this step
  uint32_t row;
  float scale;           // of its copies' velocities
  uint16_t next, queue;  // in its cell; the one that is to push on at this place of the queue
  enum : uint16_t { stays, waits, gone } state;
  uint16_t pushed;  // in any step
};

namespace {

constexpr uint32_t k_open_max = 2048, k_heads = 1024, k_none = 0xffff;

// Sand that is hemmed in slips aside less than friction alone would let it: with these factors a pile that a hand or a
// finger goes through ends where it does with time, but for a few radii (sandglass_lab verify carried).
constexpr float k_grip = 2.7f, k_grip_between = 0.6f;  // aside over out; of what a collider meets, of what that meets
// In slow motion sand slides less far off than with time, as the square of its velocity: what is met gets this much of what
// the collider's velocity lacks beside the given one.
constexpr float k_thrown = 0.4f;
constexpr float k_step_out = 1.5f;                // radii that a collider goes at once
constexpr float k_out_max = 2.0f;                 // radii that sand goes in such a step
constexpr uint32_t k_steps_out = 16;              // at most
constexpr float k_ahead = 6.0f, k_beside = 3.0f;  // radii from a collider's path; what is beyond is not pushed
constexpr float k_push_min = 0.2f;                // radii; what goes less does not push on
constexpr uint32_t k_pushed_max = 512;            // in a step; what is beyond does not push on
constexpr uint32_t k_pushed_at_once = 96;         // in a unit
constexpr uint32_t k_push_items = 3;              // a push takes as long as to carry so many
constexpr uint32_t k_step_items = 4;              // of so many a step begins in the time that it takes to carry one
constexpr float k_cell = 3.0f;                    // radii
constexpr float k_above = 0.1f;                   // diameters aside; what is less lies above and is lifted

}  // namespace

struct Giving {
  OpenSand* open;
  uint32_t capacity, count, queued, cursor, step, steps;
  uint32_t items, usual;  // of all units so far, and the largest of lately
  Bounds pushing;         // around the paths of all that push
  struct {
    Quad low, high;  // around sixteen, where a step begins
  } boxes[k_open_max / k_lane_group];
  uint16_t heads[k_heads];
};

namespace {

// Whether a collider that goes on pushes what it does not hold.
bool pushes(const Granular& g, uint32_t i) {
  return holding_carries(g, i) && !holding_encloses(g.colliders.carriers[i].to);
}

// Cells along an axis, counted from far below all sand.
int32_t cell_of(float at, float inverse) { return static_cast<int32_t>(at * inverse + 4096.0f); }

uint32_t head_of(int32_t x, int32_t y, int32_t z) { return static_cast<uint32_t>(x + 9 * y + 83 * z) % k_heads; }

// Finds the sand of each cell, and boxes.
void begin_step(Giving* s, const Granular& g, bool cells) {
  const float inverse = 1.0f / (k_cell * g.desc.particle_radius);
  for (uint16_t& head : s->heads) head = k_none;
  s->queued = s->cursor = 0;
  for (uint32_t i = 0; i < s->count; ++i) {
    OpenSand& o = s->open[i];
    auto& box = s->boxes[i / k_lane_group];
    if (i % k_lane_group == 0) box = {o.at, o.at};
    box.low = o.at < box.low ? o.at : box.low;
    box.high = o.at > box.high ? o.at : box.high;
    o.state = OpenSand::stays;
    o.displacement = Quad{};
    if (!cells) continue;
    uint16_t& head = s->heads[head_of(cell_of(o.at[0], inverse), cell_of(o.at[1], inverse), cell_of(o.at[2], inverse))];
    o.next = head;
    head = static_cast<uint16_t>(i);
  }
}

void enqueue(Giving* s, uint32_t i) {
  if (s->open[i].state != OpenSand::stays || s->queued == k_pushed_max) return;
  s->open[i].state = OpenSand::waits;
  s->open[s->queued++].queue = static_cast<uint16_t>(i);
}

// Out of what has moved by `displacement`: so far `out` along the normal, and aside with it, as far as the grip
// reaches. `level` other than 0: not upwards.
void push(OpenSand* o, const Quad& normal, float out, const Quad& displacement, float grip, const Quad& level) {
  const float with = dot(normal, displacement), limit = grip * out;
  Quad moved = out * normal;
  if (with > 0.0f) {
    Quad aside = displacement - with * normal;
    const float falls = dot(aside, level);
    if (falls < 0.0f) aside -= falls * level;
    const float aside2 = square_of(aside);
    moved += (aside2 > limit * limit ? limit / __builtin_sqrtf(aside2) : 1.0f) * aside;
  }
  o->at += moved;
  o->displacement += moved;
  o->pushed = 1;
}

// What is met goes no slower than what meets it.
void take_velocity(Carry* c, const Granular& g, const OpenSand& o, const float v[3]) {
  const Particle& p = g.particles.records[0][o.row];
  const float with = dot(quad(v), quad(p.velocity)), square = square_of(quad(v));
  if (!is_awake(p) || with >= square) return;
  for (uint32_t copy = 0; copy < 3 && (copy == 0 || o.scale != 0.0f); ++copy) {
    Particle* const records = g.particles.records[copy];
    const float gain = (square - with) / square * (copy == 0 ? 1.0f : o.scale);
    for (int k = 0; k < 3 && records != nullptr; ++k) records[o.row].velocity[k] += gain * v[k];
  }
  float speed2 = 0.0f;
  for (const float u : p.velocity) speed2 += u * u;
  c->fastest2 = speed2 > c->fastest2 ? speed2 : c->fastest2;
}

// What a collider meets in a step.
void push_by_collider(Carry* c, const Granular& g, const Carrier& carrier, float grip) {
  Giving* const s = c->giving;
  const float r = g.desc.particle_radius, parts = static_cast<float>(s->steps);
  const float at = static_cast<float>(s->step) / parts;
  const ColliderFrame& pose = holding_posed(g, carrier, at);
  const Bounds box = holding_box(pose);
  const float thrown = 1.0f + k_thrown * (1.0f / static_cast<float>(g.time.rate) - 1.0f);
  HeldScratch& scratch = scratch_of(g);
  for (uint32_t first = 0; first < s->count; first += k_lane_group) {
    const uint32_t left = s->count - first, count = left < k_lane_group ? left : k_lane_group;
    const auto& b = s->boxes[first / k_lane_group];
    if (!holding_overlaps({{b.low[0], b.low[1], b.low[2]}, {b.high[0], b.high[1], b.high[2]}}, box, 2.0f * r)) continue;
    for (uint32_t l = 0; l < count; ++l) __builtin_memcpy(&scratch.points[l], &s->open[first + l].at, sizeof(Quad));
    holding_measure_points(g, pose, count);
    for (uint32_t l = 0; l < count; ++l) {
      OpenSand& o = s->open[first + l];
      const float out = r - scratch.points[l].distance, place[3] = {o.at[0], o.at[1], o.at[2]};
      if (!(out > 0.0f)) continue;
      const Quad normal = quad(scratch.points[l].normal);
      const Quad displacement = carrier.motion.displacement(o.at) / parts;
      float v[3];
      holding_velocity(carrier.to, place, v);
      for (float& u : v) u *= thrown;
      push(&o, normal, out < k_out_max * r ? out : k_out_max * r, displacement, grip, Quad{});
      if (dot(normal, displacement) > 0.0f) take_velocity(c, g, o, v);
      enqueue(s, first + l);
    }
  }
}

// What is run into gives way in turn, on its level where it lies higher.
void push_other(Giving* s, const OpenSand& from, const Quad& difference, float distance_squared, float d,
                const Quad& down, uint32_t i) {
  const float above = -dot(difference, down);
  const Quad level = difference + above * down;
  const float level2 = square_of(level);
  const bool aside = above > 0.0f && level2 > k_above * k_above * d * d;
  const float length = __builtin_sqrtf(aside ? level2 : distance_squared);
  const float out = (aside ? __builtin_sqrtf(d * d - above * above) : d) - length;
  push(&s->open[i], (aside ? level : difference) * (1.0f / length), out, from.displacement, k_grip_between, down);
  if (out > 0.5f * k_push_min * d) enqueue(s, i);
}

// A step ends before what stands, and before what goes elsewhere, by the face that was nearest where it began:
// nothing is pressed through a wall, and what is pressed against one goes along it.
void end_before_walls(const Carry& c, const Granular& g, OpenSand* o) {
  const float r = g.desc.particle_radius, length = __builtin_sqrtf(square_of(o->displacement));
  const Quad from = o->at - o->displacement;
  const Bounds here = {{from[0], from[1], from[2]}, {from[0], from[1], from[2]}};
  const float share = static_cast<float>(c.giving->step) / static_cast<float>(c.giving->steps);
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    const Carrier& carrier = g.colliders.carriers[i];
    const bool flat = carrier.to.shape == SANDGLASS_SHAPE_HALF_SPACE, stands = carry_stands(g, i, carry_group_alone(c));
    if (!stands && (c.group_count < 2 || !pushes(g, i))) continue;
    const ColliderFrame& wall = stands ? carrier.to : holding_posed(g, carrier, share);
    if (!flat && !holding_overlaps(here, stands ? c.reaches[i] : holding_box(wall), r + length)) continue;
    Quad normal;
    const float before = holding_distance(g, wall, from, &normal);
    const float in = (before < r ? before : r) - (before + dot(o->displacement, normal));
    if (in > 0.0f) {
      o->at += in * normal;
      o->displacement += in * normal;
    }
  }
}

// What lies ahead within a diameter, half a ball: its cells are those of the box around that.
void push_on(Carry* c, const Granular& g, uint32_t i) {
  Giving* const s = c->giving;
  OpenSand* const open = s->open;
  const float r = g.desc.particle_radius, d = 2.0f * r, d2 = d * d, inverse = 1.0f / (k_cell * r);
  OpenSand& o = open[i];
  o.state = OpenSand::gone;
  const float length = __builtin_sqrtf(square_of(o.displacement));
  if (length > k_out_max * r) {
    const Quad less = (1.0f - k_out_max * r / length) * o.displacement;
    o.at -= less;
    o.displacement -= less;
  }
  end_before_walls(*c, g, &o);
  const Quad at = o.at, displacement = o.displacement, down = quad(scratch_of(g).group.down);
  const float squared = square_of(displacement), scale = squared > 0.0f ? d2 / squared : 0.0f;
  int32_t low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    const float behind = __builtin_sqrtf(__builtin_fabsf(d2 - scale * displacement[k] * displacement[k]));
    low[k] = cell_of(at[k] - (displacement[k] > 0.0f ? behind : d), inverse);
    high[k] = cell_of(at[k] + (displacement[k] < 0.0f ? behind : d), inverse);
  }
  for (int32_t z = low[2]; z <= high[2]; ++z)
    for (int32_t y = low[1]; y <= high[1]; ++y)
      for (int32_t x = low[0]; x <= high[0]; ++x)
        for (uint16_t* next = &s->heads[head_of(x, y, z)]; *next != k_none;) {
          OpenSand& other = open[*next];
          if (other.state == OpenSand::gone) {
            *next = other.next;
            continue;
          }
          const Quad difference = other.at - at;
          const float square = square_of(difference);
          if (square < d2 && square > 1e-8f * d2 && dot(difference, displacement) > 0.0f)
            push_other(s, o, difference, square, d, down, *next);
          next = &other.next;
        }
}

// For which there is no room: out of where colliders are in the end, and nothing is pushed on.
void give_way_alone(Carry* c, const Granular& g, uint32_t row) {
  const float r = g.desc.particle_radius;
  OpenSand o = {quad(g.particles.records[0][row].position), Quad{}, row, 0.0f, 0, 0, OpenSand::stays, 0};
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i) {
    if (!pushes(g, i)) continue;
    Quad normal;
    const float out = r - holding_distance(g, g.colliders.carriers[i].to, o.at, &normal), limit = k_out_max * r;
    if (out > 0.0f) push(&o, normal, out < limit ? out : limit, Quad{}, 0.0f, Quad{});
  }
  if (square_of(o.displacement) == 0.0f) return;
  end_before_walls(*c, g, &o);
  carry_put(c, g, row, o.at);
}

}  // namespace

void giving_layout(Carry* c, const sandglass_granular_desc& d, Layout* layout) {
  c->giving = layout_region<Giving>(layout, "granular.carry_giving", 1);
  const uint32_t capacity = d.particle_capacity < k_open_max ? d.particle_capacity : k_open_max;
  OpenSand* const open = layout_region<OpenSand>(layout, "granular.carry_open", capacity);
  if (c->giving != nullptr) {
    c->giving->open = open;
    c->giving->capacity = capacity;
  }
}

void giving_begin(Carry* c, const Granular& g) {
  const float r = g.desc.particle_radius;
  Giving& s = *c->giving;
  s.usual = s.items > s.usual / 8 * 7 ? s.items : s.usual / 8 * 7;
  s.items = 0;
  s.pushing = k_nowhere;
  s.count = s.step = s.steps = s.queued = s.cursor = 0;
  for (uint32_t i = 0; i < g.colliders.solid_count && c->due == Carry::Moment::close; ++i) {
    if (!pushes(g, i)) continue;
    const Carrier& carrier = g.colliders.carriers[i];
    Bounds swept = holding_box(carrier.to), unused = k_nowhere;
    bounds_join(&swept, c->reaches[i]);
    for (int k = 0; k < 3; ++k) {
      swept.low[k] = swept.low[k] > g.particles.low[k] ? swept.low[k] : g.particles.low[k];
      swept.high[k] = swept.high[k] < g.particles.high[k] ? swept.high[k] : g.particles.high[k];
    }
    if (is_empty(swept)) continue;
    const float parts = carry_box(carrier.motion, swept, &unused) / (k_step_out * r);
    const uint32_t steps = parts < static_cast<float>(k_steps_out) ? static_cast<uint32_t>(parts) + 1 : k_steps_out;
    s.steps = steps > s.steps ? steps : s.steps;
    bounds_join(&s.pushing, swept);
    const Quad displacement = carrier.motion.displacement(0.5f * (quad(swept.low) + quad(swept.high)));
    const float length = __builtin_sqrtf(square_of(displacement)), on = length > 0.0f ? k_ahead * r / length : 0.0f;
    for (int k = 0; k < 3; ++k) {
      swept.low[k] += on * displacement[k];
      swept.high[k] += on * displacement[k];
    }
    bounds_join(&s.pushing, swept);
  }
}

void giving_note(Carry* c, const Granular& g, const Bounds& box, uint32_t first, uint32_t which, float scale) {
  Giving& s = *c->giving;
  if (s.steps == 0 || !holding_overlaps(box, s.pushing, k_beside * g.desc.particle_radius)) return;
  for (; which != 0; which &= which - 1) {
    const uint32_t i = first + static_cast<uint32_t>(__builtin_ctz(which));
    if (s.count == s.capacity) give_way_alone(c, g, i);
    else s.open[s.count++] = {quad(g.particles.records[0][i].position), Quad{}, i, scale, 0, 0, OpenSand::stays, 0};
  }
}

uint32_t giving_items(const Carry& c) {
  const Giving& s = *c.giving;
  if (s.count == 0) return 0;
  const uint32_t left = s.queued - s.cursor;
  return left == 0 ? s.count / k_step_items + 1 : k_push_items * (left < k_pushed_at_once ? left : k_pushed_at_once);
}

uint32_t giving_usual(const Carry& c) { return c.giving->usual; }

bool giving_run(Carry* c, const Granular& g) {
  Giving& s = *c->giving;
  s.items += giving_items(*c);
  const uint32_t left = s.queued - s.cursor, end = s.cursor + (left < k_pushed_at_once ? left : k_pushed_at_once);
  for (; s.cursor < end; ++s.cursor) push_on(c, g, s.open[s.cursor].queue);
  if (left != 0) return false;
  const bool last = s.step++ == s.steps;
  begin_step(&s, g, !last);
  for (uint32_t i = 0; i < g.colliders.solid_count; ++i)
    if (pushes(g, i)) push_by_collider(c, g, g.colliders.carriers[i], last ? 0.0f : k_grip);
  for (uint32_t i = 0; i < s.count && last; ++i) {
    OpenSand& o = s.open[i];
    if (o.pushed == 0) continue;
    if (square_of(o.displacement) != 0.0f) end_before_walls(*c, g, &o);
    carry_put(c, g, o.row, o.at);
  }
  if (last) s.count = 0;
  return last;
}

}  // namespace sandglass

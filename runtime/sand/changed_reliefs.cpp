// Reliefs with other heights than sleepers saw: which of these wake. Contact depends on the four nodes around a centre
// alone, as they are and as they were. So what does not touch what has changed sleeps on.
#include "runtime/relief/relief.h"
#include "runtime/sand/world.h"

namespace sandglass {
namespace {

// Where a place lies: in nodes along x and z, and metres above the plane.
struct OverRelief {
  float at[2], above;
};
OverRelief over(const ColliderFrame& c, const float place[3]) {
  OverRelief o = {{-c.field.low[0], -c.field.low[2]}, 0.0f};
  for (int k = 0; k < 3; ++k) {
    const float d = place[k] - c.position[k];
    o.at[0] += d * c.axes[0][k];
    o.at[1] += d * c.axes[2][k];
    o.above += d * c.axes[1][k];
  }
  for (float& at : o.at) at *= c.field.inverse_spacing;
  return o;
}

// Whether a height has changed that counts at places so many nodes from one.
bool changed_about(const ChangedRelief& relief, const float at[2], float within) {
  const FieldGrid& grid = relief.at.field;
  int32_t low[2], high[2];
  for (int k = 0; k < 2; ++k) {
    const int32_t last = static_cast<int32_t>(grid.counts[2 * k]) - 1;
    const float from = at[k] - within, to = at[k] + within + 1.0f;  // a node counts for less than a cell around
    if (!(to > -1.0f && from < static_cast<float>(last + 1))) return false;
    low[k] = from > 0.0f ? static_cast<int32_t>(from) : 0;
    high[k] = to < static_cast<float>(last) ? static_cast<int32_t>(to < 0.0f ? 0.0f : to) : last;
  }
  for (int32_t z = low[1]; z <= high[1]; ++z)
    for (int32_t x = low[0]; x <= high[0]; ++x)
      if (relief.changes[static_cast<uint32_t>(z) * grid.counts[0] + static_cast<uint32_t>(x)].last > relief.seen)
        return true;
  return false;
}

// Whether a ball touches what lies between four nodes, two by two.
bool touches(const float nodes[4], const float share[2], float inverse_spacing, float above, float radius) {
  constexpr float k_gap = 0.25f;  // radii: what rests does not come nearer by itself
  const float near = nodes[1] - nodes[0], far = nodes[3] - nodes[2];
  const float low = nodes[0] + share[0] * near, across = nodes[2] + share[0] * far - low,
              along = near + share[1] * (far - near);
  const float slope2 = (along * along + across * across) * (inverse_spacing * inverse_spacing);
  return above - (low + share[1] * across) - radius < k_gap * radius * __builtin_sqrtf(1.0f + slope2);
}

bool wakes(const ChangedRelief& relief, const float place[3], float radius) {
  const FieldGrid& grid = relief.at.field;
  const OverRelief o = over(relief.at, place);
  if (!changed_about(relief, o.at, 0.0f)) return false;
  float share[2], now[4], was[4];
  uint32_t first = 0;
  for (int k = 1; k >= 0; --k) {
    if (!(o.at[k] >= 0.0f && o.at[k] < static_cast<float>(grid.counts[2 * k] - 1))) return true;  // on the map's face
    const uint32_t cell = static_cast<uint32_t>(o.at[k]);
    share[k] = o.at[k] - static_cast<float>(cell);
    first += k == 0 ? cell : cell * grid.counts[0];
  }
  for (uint32_t n = 0; n < 4; ++n) {
    const uint32_t node = first + n % 2 + n / 2 * grid.counts[0];
    const CellChange& change = relief.changes[node];
    if (change.last > relief.seen && change.before > relief.seen) return true;  // who knows how high it was then
    now[n] = grid.values[node];
    was[n] = change.last > relief.seen ? change.height_before : now[n];
  }
  return touches(now, share, grid.inverse_spacing, o.above, radius) ||
         touches(was, share, grid.inverse_spacing, o.above, radius);
}

}  // namespace

bool reliefs_changed(const MovedColliders& moved, const float at[3], float within) {
  for (uint32_t i = 0; i < moved.relief_count; ++i) {
    const ChangedRelief& relief = moved.reliefs[i];
    if (changed_about(relief, over(relief.at, at).at, within * relief.at.field.inverse_spacing)) return true;
  }
  return false;
}

bool reliefs_wake(const MovedColliders& moved, const float at[3], float radius) {
  for (uint32_t i = 0; i < moved.relief_count; ++i)
    if (wakes(moved.reliefs[i], at, radius)) return true;
  return false;
}

}  // namespace sandglass

// What is solid at the nodes of bricks: the distance to the nearest collider, and walls between two nodes. Walls may be
// thinner than nodes are apart: nothing passes from node to node through one.
//
// Colliders are kept as they were when sand was taken; one that has come, gone or moved changes the bricks near it.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/rows.h"
#include "runtime/skin/skin.h"
#include "runtime/solid/field/field.h"

namespace sandglass {
namespace {

constexpr float k_solid_node = 48.0f, k_solid_reach = 2.6f;                // of BrickNodes::solid: a node; nodes
constexpr float k_half_row = 0.5f * static_cast<float>(k_brick_side - 1);  // nodes from a brick's middle to its faces
constexpr float k_middle[3] = {k_half_row, k_half_row, k_half_row};

bool stands_as(const ColliderFrame& a, const ColliderFrame& b) {
  bool same = a.shape == b.shape && a.field.values == b.field.values;
  for (uint32_t k = 0; k < 3; ++k) {
    same = same && a.position[k] == b.position[k] && a.size[k] == b.size[k];
    for (uint32_t m = 0; m < 3; ++m) same = same && a.axes[k][m] == b.axes[k][m];
  }
  return same;
}

// A box of its extent stands for a grid that the app may have freed.
ColliderFrame box_of(const ColliderFrame& collider) {
  ColliderFrame box = collider;
  if (is_grid(box.shape)) {
    box.shape = SANDGLASS_SHAPE_BOX;
    find_extent(&box);
  }
  return box;
}

// The place of a node in the world, metres. `node`: counted from the brick's first one.
void place_of(const SkinLattice& l, const Brick& brick, const float node[3], float place[3]) {
  for (uint32_t a = 0; a < 3; ++a)
    place[l.axis[a]] = l.sign[a] * l.spacing * (static_cast<float>(first_node(brick.at[a])) + node[a] + 0.5f);
}

// The distances of the first of `points` from a collider.
void find_distances(const SkinState& s, SurfacePoint* points, uint32_t count, const ColliderFrame& collider) {
  const SurfaceArgs args = {points, &collider};
  uint32_t unused = 0;
  s.kernels->surface_at(&args, 0, count, &unused);
}

// Whether a collider is so near to a brick that its nodes may feel it. The first of `points` tells how near.
bool is_near(const SkinState& s, SurfacePoint* points, const Brick& brick, const ColliderFrame& collider) {
  constexpr float k_half = 6.1f;  // to the outermost node
  const float reach = (k_half + k_solid_reach + 0.5f) * s.lattice.spacing;
  place_of(s.lattice, brick, k_middle, points[0].position);
  if (collider.shape == SANDGLASS_SHAPE_RELIEF) {  // its distances are those from planes
    float above = -greatest_height(collider.field);
    for (uint32_t k = 0; k < 3; ++k) above += (points[0].position[k] - collider.position[k]) * collider.axes[1][k];
    return above < reach;
  }
  find_distances(s, points, 1, collider);
  return points[0].distance < reach;
}

// Whether sand of a brick feels a collider: it changes what is made of a node beside sand. First rows of nodes are
// looked at, then the nodes of those that are near.
bool feels(const SkinState& s, SurfacePoint* points, uint32_t number, const ColliderFrame& collider) {
  constexpr float k_felt = k_solid_reach + 0.25f;
  const Brick& brick = s.bricks.records[number];
  const uint8_t* beside = s.bricks.nodes[number].beside_sand;
  uint8_t rows[k_brick_layer];
  uint32_t count = 0, near = 0;
  const auto look_at = [&](float x, uint32_t row) {
    const uint32_t y = row / k_brick_side, z = row % k_brick_side;
    const float node[3] = {x, static_cast<float>(y), static_cast<float>(z)};
    place_of(s.lattice, brick, node, points[count++].position);
  };
  const auto is_felt = [&](uint32_t i, float reach) { return points[i].distance < reach * s.lattice.spacing; };
  for (uint32_t row = 0; row < k_brick_layer; ++row)
    if (beside[row] != 0) {
      rows[count] = static_cast<uint8_t>(row);
      look_at(k_half_row, row);
    }
  find_distances(s, points, count, collider);
  const bool rough = collider.shape == SANDGLASS_SHAPE_RELIEF;
  for (uint32_t i = 0; i < count; ++i)
    if (rough || is_felt(i, k_felt + k_half_row)) rows[near++] = rows[i];
  count = 0;
  for (uint32_t i = 0; i < near; ++i)
    for (uint32_t bits = beside[rows[i]]; bits != 0; bits &= bits - 1)
      look_at(static_cast<float>(__builtin_ctz(bits)), rows[i]);
  find_distances(s, points, count, collider);
  for (uint32_t i = 0; i < count; ++i)
    if (is_felt(i, k_felt)) return true;
  return false;
}

// `changed`: null, or what has changed of this one, a relief. Where it fell, what is near now does not count.
void mark_near(SkinBricks* bricks, const SkinState& s, const ColliderFrame& collider, bool* asked,
               const MovedColliders* changed = nullptr) {
  constexpr float k_around = 13.3f;  // nodes from a brick's middle to its corners, and as far as they feel
  const SkinPhase phase = s.progress.phase;
  for (uint32_t b = 0; b < bricks->count && collider.shape != k_no_shape; ++b) {
    Brick& brick = bricks->records[b];
    float middle[3];
    if (changed != nullptr) place_of(s.lattice, brick, k_middle, middle);
    if (changed != nullptr && !reliefs_changed(*changed, middle, k_around * s.lattice.spacing)) continue;
    if (!brick.used || (changed == nullptr && !is_near(s, s.solids.points, brick, collider))) continue;
    brick.stale |= k_stale_solid;
    if (phase != SkinPhase::take && !*asked)
      *asked = phase != SkinPhase::idle || feels(s, s.solids.points, b, collider);
  }
}

// A relief that stands where it stood, with other heights than at its change `seen`.
void mark_changed(SkinBricks* bricks, const SkinState& s, const sandglass_collider& relief, const ColliderFrame& now,
                  uint32_t seen, bool* asked) {
  ChangedRelief one = {now, changes_of(relief), seen};
  const MovedColliders changed = {nullptr, nullptr, 0, &one, 1};
  mark_near(bricks, s, now, asked, &changed);
}

// Whether a solid lies between two nodes: its distance falls from either towards the other, and would be below 0 where
// both meet. So it does in a wall of any thickness, and not beside a floor or an edge that both look at.
bool is_between(const SurfacePoint& a, const SurfacePoint& b, uint32_t axis, float sign, float distance) {
  if (a.distance + b.distance >= distance) return false;
  const float from_a = -sign * a.normal[axis], from_b = sign * b.normal[axis];
  return from_a > 0 && from_b > 0 && a.distance * from_b + b.distance * from_a < from_a * from_b * distance;
}

// The distances of a brick's nodes, and of those after them up to `side` along each axis, from a collider.
void look_at_nodes(const SkinState& s, const Brick& brick, uint32_t side, const ColliderFrame& collider) {
  SurfacePoint* next = s.solids.points;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t z = 0; z < side; ++z)
      for (uint32_t x = 0; x < side; ++x) {
        const float node[3] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        place_of(s.lattice, brick, node, next++->position);
      }
  find_distances(s, s.solids.points, side * side * side, collider);
}

void find_solid(SkinBricks* bricks, const SkinState& s, uint32_t number) {
  constexpr float k_walls_within = 7.1f;  // nodes from a brick's middle: to the outermost one, and one more
  const SkinLattice& l = s.lattice;
  const SurfacePoint* points = s.solids.points;
  Brick& brick = bricks->records[number];
  uint8_t *solid = bricks->nodes[number].solid, *walls = bricks->nodes[number].walls;
  brick.open = true;
  brick.walled = false;
  memset(solid, 255, k_brick_nodes);
  memset(walls, 0, k_brick_nodes);
  for (uint32_t c = 0; c < s.desc.collider_capacity; ++c) {
    const ColliderFrame& collider = s.solids.colliders[c];
    if (collider.shape == k_no_shape || !is_near(s, s.solids.points, brick, collider)) continue;
    const bool walls_too = collider.shape != SANDGLASS_SHAPE_HALF_SPACE && collider.shape != SANDGLASS_SHAPE_RELIEF &&
                           points[0].distance < k_walls_within * l.spacing;
    const uint32_t side = walls_too ? k_edges_side : k_brick_side, steps[3] = {1, side * side, side};
    look_at_nodes(s, brick, side, collider);
    for (uint32_t i = 0; i < k_brick_nodes; ++i) {
      const uint32_t x = i % k_brick_side, y = i / k_brick_layer, z = i / k_brick_side % k_brick_side;
      const SurfacePoint* point = points + x + steps[2] * z + steps[1] * y;
      const float value = 128.5f + k_solid_node * l.inverse_spacing * point->distance;
      const uint32_t whole = to_whole<uint32_t>(value < 255.0f ? value : 255.0f);
      if (whole < solid[i]) solid[i] = static_cast<uint8_t>(whole);
      if (whole < 255) brick.open = false;
      for (uint32_t a = 0; a < 3 && walls_too && point->distance < l.spacing; ++a)
        if (is_between(*point, point[steps[a]], l.axis[a], l.sign[a], l.spacing)) {
          walls[i] = static_cast<uint8_t>(walls[i] | 1u << a);
          brick.walled = true;
        }
    }
  }
}

}  // namespace

// Only where sand feels what has changed is a skin asked for; other bricks wait until one is made.
void solids_take(SkinSolids* solids, SkinBricks* bricks, const SkinState& s, float before, bool* asked) {
  const Colliders& given = s.granular->colliders;
  solids_drop_gone_fields(solids, bricks, s, asked);
  solids->mover_count = 0;
  for (uint32_t slot = 0; slot < s.desc.collider_capacity; ++slot) {
    uint32_t i = 0;
    while (i < given.count && given.slots[i] != slot) ++i;
    ColliderFrame now = {}, &was = solids->colliders[slot];
    now.shape = k_no_shape;
    uint64_t version = 0;
    if (i < given.count) {
      const sandglass_collider& collider = given.given[i];
      colliders_pose(&collider, 1, before, &now);
      version = version_of(collider);
      memcpy(now.extent, box_of(now).extent, sizeof now.extent);
    }
    const bool stands = stands_as(now, was), same = stands && version == solids->fields[slot];
    if (stands && now.shape == SANDGLASS_SHAPE_RELIEF && version > solids->fields[slot]) {
      mark_changed(bricks, s, given.given[i], now, static_cast<uint32_t>(solids->fields[slot]), asked);
    } else if (!same) {
      mark_near(bricks, s, box_of(was), asked);
      mark_near(bricks, s, now, asked);
    }
    was = now;
    solids->fields[slot] = version;
    bool moves = false;
    for (uint32_t k = 0; k < 3; ++k) moves = moves || now.linear[k] != 0 || now.angular[k] != 0;
    if (moves) solids->movers[solids->mover_count++] = slot;
  }
}

void solids_drop_gone_fields(SkinSolids* solids, SkinBricks* bricks, const SkinState& s, bool* asked) {
  const Colliders& given = s.granular->colliders;
  for (uint32_t slot = 0; slot < s.desc.collider_capacity; ++slot) {
    ColliderFrame& was = solids->colliders[slot];
    bool there = !is_grid(was.shape);
    for (uint32_t i = 0; i < given.count && !there; ++i)
      there = has_grid(was, given.given[i]) &&
              (was.shape == SANDGLASS_SHAPE_RELIEF || version_of(given.given[i]) == solids->fields[slot]);
    if (there) continue;
    mark_near(bricks, s, box_of(was), asked);
    was.shape = k_no_shape;
    solids->fields[slot] = 0;
  }
}

// Its own frame, as find_density has: kernels are called from here.
__attribute__((noinline)) void solids_renew(SkinSolids* solids, SkinBricks* bricks, const SkinState& s,
                                            uint32_t number) {
  Brick& brick = bricks->records[number];
  BrickNodes& nodes = bricks->nodes[number];
  memcpy(solids->solid_before, nodes.solid, sizeof nodes.solid);
  memcpy(solids->walls_before, nodes.walls, sizeof nodes.walls);
  if ((brick.stale & k_stale_solid) != 0) find_solid(bricks, s, number);
  brick.stale &= ~k_stale_solid;
  const bool other_walls = memcmp(solids->walls_before, nodes.walls, sizeof nodes.walls) != 0;
  if (other_walls) mark_around(bricks, brick, k_all_around, k_stale_density | k_stale_fill);
  if (!other_walls && memcmp(solids->solid_before, nodes.solid, sizeof nodes.solid) == 0) return;
  for (uint32_t row = 0; row < k_brick_nodes; row += k_brick_side) take_part(&nodes, row);
  memset(nodes.changed, 255, sizeof nodes.changed);
  brick.stale |= k_stale_fill;
  mark_around(bricks, brick, k_all_around, k_stale_calm | k_stale_mesh);
  for (const uint32_t other : brick.around)
    if (other != k_none) bricks->records[other].room_known = false;
}

}  // namespace sandglass

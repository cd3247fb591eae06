// The vertex of a cell that the surface passes: where the density has the level, moved out of colliders and out along a
// floor; its normal; and the particle that it goes with.
#include <cstring>

#include "runtime/math/random.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr uint32_t k_step[3] = {1, k_mesh_pitch* k_mesh_pitch, k_mesh_pitch};  // of SkinBlocks::calm, along x, y and z
constexpr float k_level = static_cast<float>(k_skin_level);
constexpr float k_foot_radii = 1.2f;   // over a floor, where the foot begins
constexpr float k_foot_slope = 1.45f;  // its cotangent at the floor
constexpr float k_far = 1e6f;
constexpr float k_deepest = -0.25f;   // nodes over a collider of a vertex; in corners of two a third
constexpr float k_buried = -1.6f;     // nodes over a collider, of a cell's middle: none of it looks out
constexpr float k_kept_radii = 2.2f;  // so far a vertex keeps its particle
constexpr float k_hollow_flat = 0.5f, k_hollow_gain = 2.6f;

// The uniform quadratic B-spline at a point, along an axis: weights of the four nodes about its cell, and their slopes.
struct Spline {
  float weight[4] = {}, slope[4] = {};
  explicit Spline(float t) {
    const uint32_t first = t < 0.5f ? 0 : 1;
    const float d = t - static_cast<float>(first), low = 0.5f - d, high = 0.5f + d;
    weight[first] = 0.5f * low * low;
    weight[first + 1] = 0.75f - d * d;
    weight[first + 2] = 0.5f * high * high;
    slope[first] = -low;
    slope[first + 1] = -2.0f * d;
    slope[first + 2] = high;
  }
};

float clamped(float x, float low, float high) { return x > low ? (x < high ? x : high) : low; }

using FourShort = uint16_t __attribute__((vector_size(8)));

// The 4^3 nodes about a cell, and their density smoothed.
struct Nodes {
  Quad v[4][4];  // of y and z
  explicit Nodes(const uint16_t* first) {
    for (uint32_t y = 0; y < 4; ++y)
      for (uint32_t z = 0; z < 4; ++z) {
        FourShort shorts;
        memcpy(&shorts, first + y * k_step[1] + z * k_step[2], sizeof shorts);
        v[y][z] = __builtin_convertvector(__builtin_convertvector(shorts, QuadWhole), Quad);
      }
  }

  float mean() const {
    Quad sum = {};
    for (const auto& layer : v) sum += (layer[0] + layer[1]) + (layer[2] + layer[3]);
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) * (1.0f / 64);
  }

  // The mean of the places where the level crosses the cell's edges. On an edge with a wall that is where the wall
  // begins, by `solid` of the corner within it. Whether there was such an edge.
  bool crossing(const CellValues& solid, const CellValues& walls, float u[3]) const {
    bool walled = false;
    float value[8], sum[3] = {0, 0, 0}, count = 0;
    uint32_t inside = 0;
    for (uint32_t c = 0; c < 8; ++c) {
      value[c] = v[1 + (c >> 1 & 1)][1 + (c >> 2)][1 + (c & 1)];
      inside |= (value[c] > k_level ? 1u : 0u) << c;
    }
    constexpr uint32_t k_low[3] = {0x55, 0x33, 0x0f};  // the corners at 0 of each axis
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t edges = (inside ^ inside >> (1u << k)) & k_low[k]; edges != 0; edges &= edges - 1) {
        const uint32_t c = static_cast<uint32_t>(__builtin_ctz(edges)), d = c | 1u << k;
        for (uint32_t m = 0; m < 3; ++m) sum[m] += static_cast<float>(c >> m & 1);
        count += 1;
        if ((to_whole<uint32_t>(walls.v[c]) >> k & 1) != 0) {
          const bool low_within = (inside >> c & 1) != 0;
          const float deep = clamped((solid.v[low_within ? c : d] - 128.0f) * (1.0f / 48.0f), 0, 1);
          sum[k] += low_within ? deep : 1.0f - deep;
          walled = true;
        } else {
          sum[k] += (k_level - value[c]) / (value[d] - value[c]);
        }
      }
    for (uint32_t m = 0; m < 3; ++m) u[m] = sum[m] / count;
    return walled;
  }

  // The smoothed density at u in the cell, and its gradient for a node's distance.
  float smoothed(const float u[3], float gradient[3]) const {
    const Spline x(u[0]), y(u[1]), z(u[2]);
    Quad sum = {}, over_y = {}, over_z = {};
    for (uint32_t k = 0; k < 4; ++k) {
      Quad column = {}, slope = {};
      for (uint32_t j = 0; j < 4; ++j) column += y.weight[j] * v[j][k];
      for (uint32_t j = 0; j < 4; ++j) slope += y.slope[j] * v[j][k];
      sum += z.weight[k] * column;
      over_y += z.weight[k] * slope;
      over_z += z.slope[k] * column;
    }
    float value = 0;
    gradient[0] = gradient[1] = gradient[2] = 0;
    for (uint32_t i = 0; i < 4; ++i) {
      value += x.weight[i] * sum[i];
      gradient[0] += x.slope[i] * sum[i];
      gradient[1] += x.weight[i] * over_y[i];
      gradient[2] += x.weight[i] * over_z[i];
    }
    return value;
  }
};

float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// One over the length; 0 for a vector of length 0.
float inverse_length(const float a[3]) {
  const float square = dot(a, a);
  return square > 1e-20f ? 1.0f / __builtin_sqrtf(square) : 0.0f;
}

// The foot: near a floor a vertex moves outward along it, so that the sand runs out at a slope. The normal goes with
// it. `limit`: nodes.
void run_out(const SkinState& s, const float floor[3], float over, float limit, float shift[3], float normal[3]) {
  const float top = k_foot_radii * s.desc.particle_radius * s.lattice.inverse_spacing;
  const float level = dot(floor, s.lattice.up), y = over > 0 ? over : 0.0f;
  if (y >= top || level < 0.5f) return;
  const float rise = dot(normal, floor);
  float flat[3];
  for (uint32_t m = 0; m < 3; ++m) flat[m] = normal[m] - rise * floor[m];
  const float across = __builtin_sqrtf(dot(flat, flat));
  if (across < 0.2f) return;
  const float fade = clamped((across - 0.2f) * (1.0f / 0.3f), 0, 1) * clamped((level - 0.5f) * 5.0f, 0, 1);
  const float missing = fade * clamped(k_foot_slope - rise / across, 0, 2.2f);
  const float wanted = missing * (top - y) * (top - y) / top, far = (wanted < limit ? wanted : limit) / across;
  for (uint32_t m = 0; m < 3; ++m) shift[m] = far * flat[m];
  const float more = 2.0f * missing * (1.0f - y / top) * across;
  for (uint32_t m = 0; m < 3; ++m) normal[m] += more * floor[m];
  const float inverse = inverse_length(normal);
  for (uint32_t m = 0; m < 3; ++m) normal[m] *= inverse;
}

// How many nodes aside a cell's vertex may be moved: not through a wall.
float room_aside(const SkinBlocks& blocks, const uint32_t cell[3]) {
  if (!blocks.walled) return 3.0f;
  uint32_t any = 0;
  for (uint32_t y = cell[1]; y < cell[1] + 3; ++y)
    for (uint32_t z = cell[2]; z < cell[2] + 3; ++z)
      for (uint32_t x = cell[0]; x < cell[0] + 3; ++x)
        any |= blocks.walls[x + k_mesh_solid_pitch * (z + k_mesh_solid_pitch * y)];
  return (any & 5) == 0 ? 1.0f : 0.0f;  // edges along x and z
}

float distance_squared(const int32_t a[3], const float b[3]) {
  float sum = 0;
  for (uint32_t m = 0; m < 3; ++m) {
    const float d = static_cast<float>(a[m]) - b[m];
    sum += d * d;
  }
  return sum;
}

// The particle whose sand lies about a place (in lattice steps): the one of before while it is near, else the nearest
// of those about the cell.
uint32_t anchor_of(const SkinState& s, const Brick& brick, const uint32_t cell[3], const float place[3],
                   uint32_t before) {
  constexpr uint32_t k_looked_at = 4;  // of a cell
  const float keep = k_kept_radii / k_skin_spacing * k_skin_steps;
  if (before != k_none && s.sand.particles[before].share != 0 &&
      distance_squared(s.sand.particles[before].at, place) < keep * keep)
    return before;
  uint32_t nearest = k_none;
  float smallest = 3e38f;
  // From the brick before.
  const uint32_t x = cell[0] + k_brick_side, y = cell[1] + k_brick_side, z = cell[2] + k_brick_side;
  for (uint32_t j = y - 1; j <= y + 1; ++j)
    for (uint32_t k = z - 1; k <= z + 1; ++k) {
      const uint32_t* three = brick.around + around_index(0, brick_along(j), brick_along(k));
      const uint32_t row = node_index(0, node_along(j), node_along(k));
      for (uint32_t i = x - 1; i <= x + 1; ++i) {
        if (three[brick_along(i)] == k_none) continue;
        uint32_t p = s.bricks.nodes[three[brick_along(i)]].particles[row + node_along(i)];
        for (uint32_t n = 0; n < k_looked_at && p != k_none; ++n, p = s.sand.particles[p].next) {
          const float distance = distance_squared(s.sand.particles[p].at, place);
          if (distance < smallest || (distance == smallest && p < nearest)) {
            smallest = distance;
            nearest = p;
          }
        }
      }
    }
  return nearest;
}

// The fraction of a number, in 65536ths.
uint16_t turns(float turns) {
  const float whole = static_cast<float>(floor_whole(turns));
  return static_cast<uint16_t>(to_whole<uint32_t>((turns - whole) * 65536.0f) & 0xffff);
}

int8_t of_127(float x) { return static_cast<int8_t>(floor_whole(127.0f * x + 0.5f)); }

// Finds where in the cell the smoothed density has the level. `normal`: away from the sand. `around`: by how much the
// mean density about there exceeds that beside a plane. True: it is at a wall.
bool find_level(const SkinState& s, const Nodes& nodes, const CellValues& solid, const CellValues& walls, float u[3],
                float normal[3], float* around) {
  const bool walled = nodes.crossing(solid, walls, u);
  const float value = nodes.smoothed(u, normal), square = dot(normal, normal);
  float scale = square > 1.0f && !walled ? (k_level - value) / square : 0.0f;  // Newton's step to the level
  const float step = __builtin_fabsf(scale) * __builtin_sqrtf(square);
  if (step > 0.5f) scale *= 0.5f / step;
  for (uint32_t m = 0; m < 3; ++m) u[m] = clamped(u[m] + scale * normal[m], 0, 1);
  *around = nodes.mean() - k_level;
  for (uint32_t m = 0; m < 3; ++m) *around += normal[m] * (u[m] - 0.5f);
  const float inverse = inverse_length(normal);
  for (uint32_t m = 0; m < 3; ++m) normal[m] = inverse != 0.0f ? -inverse * normal[m] : s.lattice.up[m];
  return walled;
}

// Shifts a vertex beside a collider out of it and outward along it, with its normal. Returns its height over the
// collider, in nodes.
float meet_collider(const SkinState& s, const SkinBlocks& blocks, const uint32_t cell[3], const CellValues& solid,
                    bool walled, const float u[3], float shift[3], float normal[3]) {
  const float distance = solid.at(u);
  float over = distance < 250.0f ? (distance - 128.0f) * (1.0f / 48.0f) : k_far, floor[3];
  if (!(over < k_foot_radii / k_skin_spacing)) return over;
  solid.gradient(u, floor);
  const float length = inverse_length(floor);
  for (uint32_t m = 0; m < 3; ++m) floor[m] *= length;
  const float lifted = over < k_deepest && s.desc.capped == 0 ? k_deepest - over : 0.0f;
  over += lifted;
  if (s.desc.capped != 0 && dot(normal, floor) < 0) over = k_far;  // it faces the wall
  else run_out(s, floor, over, walled ? 0 : room_aside(blocks, cell), shift, normal);
  for (uint32_t m = 0; m < 3; ++m) shift[m] += lifted * floor[m];
  return over;
}

// Writes a vertex: its place in the world, and in the block of grains, which lies the same about the same particle.
void put_vertex(const SkinState& s, const float place[3], const float shift[3], const float normal[3], uint32_t anchor,
                sandglass_skin_vertex* out) {
  for (uint32_t m = 0; m < 3; ++m) {
    const uint32_t w = s.lattice.axis[m];
    out->position[w] = s.lattice.sign[m] * s.lattice.spacing * (place[m] + shift[m] + 0.5f);
    out->normal[w] = of_127(s.lattice.sign[m] * normal[m]);
    float at = 0;
    if (anchor != k_none)
      at = s.lattice.sign[m] * s.lattice.spacing *
           (static_cast<float>(s.sand.particles[anchor].at[m]) * (1.0f / k_skin_steps) + 0.5f);
    out->origin[w] = turns(at / s.desc.block_side);
  }
  const uint64_t seed = mix_bits(anchor);  // another place in the block for each particle
  for (uint32_t m = 0; m < 3; ++m) out->origin[m] = static_cast<uint16_t>(out->origin[m] - (seed >> (16 * m)));
}

}  // namespace

void vertex_read_blocks(const SkinState& s, const Brick& brick, SkinBlocks* blocks) {
  brick_block<k_mesh_apron>(s.bricks, brick, &BrickNodes::calm, uint16_t{0}, blocks->calm);
  blocks->walled = has_walls(s.bricks, brick);
  if (brick.open) return;
  brick_block<1>(s.bricks, brick, &BrickNodes::solid, uint8_t{255}, blocks->solid);
  brick_block<1>(s.bricks, brick, &BrickNodes::walls, uint8_t{0}, blocks->walls);
  // Where there is no brick after this one, its last nodes stand for that.
  for (uint32_t y = 1; y <= k_edges_side; ++y)
    for (uint32_t z = 1; z <= k_edges_side; ++z)
      for (uint32_t x = y == k_edges_side || z == k_edges_side ? 1 : k_edges_side; x <= k_edges_side; ++x) {
        const uint32_t after[3] = {x / k_edges_side, y / k_edges_side, z / k_edges_side};
        if (brick.around[around_index(1 + after[0], 1 + after[1], 1 + after[2])] != k_none) continue;
        uint8_t* node = blocks->solid + x + k_mesh_solid_pitch * (z + k_mesh_solid_pitch * y);
        *node = *(node - after[0] - k_mesh_solid_pitch * (after[2] + k_mesh_solid_pitch * after[1]));
      }
}

bool vertex_make(const SkinState& s, const Brick& brick, const SkinBlocks& blocks, const uint32_t cell[3],
                 sandglass_skin_vertex* out, uint32_t* anchor) {
  float u[3], normal[3], shift[3] = {0, 0, 0}, over = k_far, around;
  constexpr uint32_t k_steps[3] = {1, k_mesh_solid_pitch * k_mesh_solid_pitch, k_mesh_solid_pitch};
  CellValues solid, walls;
  if (!brick.open) {
    const uint32_t first = (cell[0] + 1) * k_steps[0] + (cell[1] + 1) * k_steps[1] + (cell[2] + 1) * k_steps[2];
    solid = CellValues(blocks.solid + first, k_steps);
    walls = CellValues(blocks.walls + first, k_steps);
    if (solid.sum() < 8 * (128.0f + 48.0f * k_buried)) return false;
  }
  constexpr uint32_t k_before = k_mesh_apron - 1;
  const Nodes nodes(blocks.calm + (cell[0] + k_before) * k_step[0] + (cell[1] + k_before) * k_step[1] +
                    (cell[2] + k_before) * k_step[2]);
  const bool walled = find_level(s, nodes, solid, walls, u, normal, &around);
  if (!brick.open) over = meet_collider(s, blocks, cell, solid, walled, u, shift, normal);
  float place[3], steps[3];  // in nodes, in lattice steps
  for (uint32_t m = 0; m < 3; ++m) {
    place[m] = static_cast<float>(first_node(brick.at[m]) + static_cast<int32_t>(cell[m])) + u[m];
    steps[m] = place[m] * k_skin_steps;
  }
  *anchor = anchor_of(s, brick, cell, steps, *anchor);
  put_vertex(s, place, shift, normal, *anchor, out);
  const float hollow = k_hollow_flat + k_hollow_gain * (1.0f / k_skin_one) * around;
  out->hollow = static_cast<uint8_t>(to_whole<uint32_t>(255.0f * clamped(hollow, 0, 1) + 0.5f));
  const float micrometres = clamped(1e6f * s.lattice.spacing * over, -32768.0f, 32767.0f);
  out->over = static_cast<int16_t>(floor_whole(micrometres));
  return true;
}

}  // namespace sandglass

// The mesh: surface nets (Gibson 1998). A cell between eight nodes that the surface passes has one vertex, an edge between two
// nodes that it crosses has one quad, of the four cells about it.
//
// A brick that has changed makes its vertices anew; those of others are copied from the mesh before. A chunk in which
// nothing has changed is copied whole. A chunk's triangles need vertices of the bricks below it along each axis: it holds
// copies of them, so that it is drawn by itself. Chunks are made in the order of their places, so those bricks are done.
#include <cstring>

#include "runtime/math/random.h"
#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr uint32_t k_apron = k_mesh_apron, k_pitch = k_mesh_pitch;
constexpr uint32_t k_step[3] = {1, k_pitch* k_pitch, k_pitch};  // of a block, along x, y and z
constexpr uint32_t k_solid_pitch = k_mesh_solid_pitch;
constexpr float k_level = static_cast<float>(k_skin_level);
constexpr float k_foot_radii = 1.2f;   // over a floor, where the foot begins
constexpr float k_foot_slope = 1.45f;  // its cotangent at the floor
constexpr float k_far = 1e6f;
constexpr float k_deepest = -0.25f;    // nodes over a collider of a vertex; in corners of two a third
constexpr float k_below = -1.0f / 16;  // and of one that is hidden, not rounded
constexpr float k_buried = -1.6f;      // nodes over a collider, of a cell's middle: none of it looks out
constexpr float k_kept_radii = 2.2f;   // so far a vertex keeps its particle
constexpr float k_hollow_flat = 0.5f, k_hollow_gain = 2.6f;

// Bits of the rows of a brick's nodes, and of as many nodes before and after it on every side.
template <uint32_t before, uint32_t after>
void read_rows(const SkinState& s, const Brick& brick, uint8_t (BrickNodes::*field)[k_brick_layer], uint16_t* rows) {
  constexpr uint32_t k_first = k_brick_side - before, k_end = 2 * k_brick_side + after;
  constexpr uint8_t k_nothing[k_brick_layer] = {};
  const uint8_t* from[3] = {k_nothing, k_nothing, k_nothing};
  for (uint32_t y = k_first; y < k_end; ++y)
    for (uint32_t z = k_first; z < k_end; ++z) {
      const uint32_t *three = brick.around + 3 * (z >> 3) + 9 * (y >> 3), row = 8 * (y & 7) + (z & 7);
      if (z == k_first || (z & 7) == 0)
        for (uint32_t x = 0; x < 3; ++x) from[x] = three[x] == k_brick_none ? k_nothing : s.nodes[three[x]].*field;
      const uint32_t bits = uint32_t{from[0][row]} | uint32_t{from[1][row]} << 8 | uint32_t{from[2][row]} << 16;
      *rows++ = static_cast<uint16_t>(bits >> k_first & ((1u << (k_end - k_first)) - 1));
    }
}

// The cells of which no node that counts has changed since their vertices were made: bits of a row.
void find_kept(const SkinState& s, const Brick& brick, uint8_t kept[k_brick_layer]) {
  constexpr uint32_t k_side = k_brick_side + 3;  // from the node before a cell to the second one after it
  uint16_t rows[k_side * k_side];
  read_rows<1, 2>(s, brick, &BrickNodes::changed, rows);
  for (uint16_t& row : rows) row = static_cast<uint16_t>(row | row >> 1 | row >> 2 | row >> 3);
  for (uint32_t step = 1; step <= k_side; step += k_side - 1)
    for (uint32_t i = 0; i + 3 * step < k_side * k_side; ++i)
      rows[i] = static_cast<uint16_t>(rows[i] | rows[i + step] | rows[i + 2 * step] | rows[i + 3 * step]);
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) kept[8 * y + z] = static_cast<uint8_t>(~rows[k_side * y + z]);
}

// The cells of a row through which the surface passes.
uint32_t crossed(const SkinBlocks& b, uint32_t y, uint32_t z) {
  const uint32_t any = b.rows[y][z] | b.rows[y + 1][z] | b.rows[y][z + 1] | b.rows[y + 1][z + 1];
  const uint32_t all = b.rows[y][z] & b.rows[y + 1][z] & b.rows[y][z + 1] & b.rows[y + 1][z + 1];
  return (any | any >> 1) & ~(all & all >> 1) & 0xff;
}

// A point's uniform quadratic B-spline along an axis: what the four nodes about its cell weigh, and how that changes.
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

  // Where the level crosses the cell's edges, on average. At a wall it does so where the wall begins: `solid` of the corner
  // within. True: there was one.
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

  // At u in the cell, and how it changes, in nodes.
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

// One over the length, 0 of nothing.
float inverse_length(const float a[3]) {
  const float square = dot(a, a);
  return square > 1e-20f ? 1.0f / __builtin_sqrtf(square) : 0.0f;
}

// The foot: near a floor a vertex moves outward along it, so that the sand runs out at a slope. The normal goes with it.
// `most`: nodes.
void run_out(const SkinState& s, const float floor[3], float over, float most, float shift[3], float normal[3]) {
  const float top = k_foot_radii * s.desc.particle_radius * s.inverse_spacing;
  const float level = dot(floor, s.up), y = over > 0 ? over : 0.0f;
  if (y >= top || level < 0.5f) return;
  const float rise = dot(normal, floor);
  float flat[3];
  for (uint32_t m = 0; m < 3; ++m) flat[m] = normal[m] - rise * floor[m];
  const float across = __builtin_sqrtf(dot(flat, flat));
  if (across < 0.2f) return;
  const float fade = clamped((across - 0.2f) * (1.0f / 0.3f), 0, 1) * clamped((level - 0.5f) * 5.0f, 0, 1);
  const float missing = fade * clamped(k_foot_slope - rise / across, 0, 2.2f);
  const float wanted = missing * (top - y) * (top - y) / top, way = (wanted < most ? wanted : most) / across;
  for (uint32_t m = 0; m < 3; ++m) shift[m] = way * flat[m];
  const float more = 2.0f * missing * (1.0f - y / top) * across;
  for (uint32_t m = 0; m < 3; ++m) normal[m] += more * floor[m];
  const float inverse = inverse_length(normal);
  for (uint32_t m = 0; m < 3; ++m) normal[m] *= inverse;
}

// How many nodes aside a cell's vertex may go: behind a wall there is another place.
float room_aside(const SkinBlocks& blocks, const uint32_t cell[3]) {
  if (!blocks.walled) return 3.0f;
  uint32_t any = 0;
  for (uint32_t y = cell[1]; y < cell[1] + 3; ++y)
    for (uint32_t z = cell[2]; z < cell[2] + 3; ++z)
      for (uint32_t x = cell[0]; x < cell[0] + 3; ++x) any |= blocks.walls[x + k_solid_pitch * (z + k_solid_pitch * y)];
  return (any & 5) == 0 ? 1.0f : 0.0f;  // edges along x and z
}

float apart2(const int32_t a[3], const float b[3]) {
  float sum = 0;
  for (uint32_t m = 0; m < 3; ++m) {
    const float d = static_cast<float>(a[m]) - b[m];
    sum += d * d;
  }
  return sum;
}

// The particle whose sand lies about a place (in lattice steps): the one of before while it is near, else the nearest of
// those about the cell.
uint32_t anchor_of(const SkinState& s, const Brick& brick, const uint32_t cell[3], const float place[3],
                   uint32_t before) {
  constexpr uint32_t k_looked_at = 4;  // of a cell
  const float keep = k_kept_radii / k_skin_spacing * k_skin_steps;
  if (before != k_brick_none && s.particles[before].share != 0 && apart2(s.particles[before].at, place) < keep * keep)
    return before;
  uint32_t nearest = k_brick_none;
  float least = 3e38f;
  const uint32_t x = cell[0] + 8, y = cell[1] + 8, z = cell[2] + 8;
  for (uint32_t j = y - 1; j <= y + 1; ++j)
    for (uint32_t k = z - 1; k <= z + 1; ++k) {
      const uint32_t* three = brick.around + 3 * (k >> 3) + 9 * (j >> 3);
      const uint32_t row = 8 * (k & 7) + 64 * (j & 7);
      for (uint32_t i = x - 1; i <= x + 1; ++i) {
        if (three[i >> 3] == k_brick_none) continue;
        uint32_t p = s.nodes[three[i >> 3]].particles[(i & 7) + row];
        for (uint32_t n = 0; n < k_looked_at && p != k_brick_none; ++n, p = s.particles[p].next) {
          const float distance = apart2(s.particles[p].at, place);
          if (distance < least || (distance == least && p < nearest)) {
            least = distance;
            nearest = p;
          }
        }
      }
    }
  return nearest;
}

// In 1/65536 of the block's side, from whole turns of it.
uint16_t turns(float turns) {
  const float whole = static_cast<float>(floor_whole(turns));
  return static_cast<uint16_t>(to_whole<uint32_t>((turns - whole) * 65536.0f) & 0xffff);
}

int8_t of_127(float x) { return static_cast<int8_t>(floor_whole(127.0f * x + 0.5f)); }

void read_blocks(const SkinState& s, const Brick& brick, SkinBlocks* blocks) {
  brick_block<k_apron>(s, brick, &BrickNodes::calm, uint16_t{0}, blocks->calm);
  blocks->walled = has_walls(s, brick);
  if (brick.open) return;
  brick_block<1>(s, brick, &BrickNodes::solid, uint8_t{255}, blocks->solid);
  brick_block<1>(s, brick, &BrickNodes::walls, uint8_t{0}, blocks->walls);
  // Where there is no brick after this one, its last nodes stand for that.
  for (uint32_t y = 1; y <= k_edges_side; ++y)
    for (uint32_t z = 1; z <= k_edges_side; ++z)
      for (uint32_t x = y == k_edges_side || z == k_edges_side ? 1 : k_edges_side; x <= k_edges_side; ++x) {
        const uint32_t after[3] = {x / k_edges_side, y / k_edges_side, z / k_edges_side};
        if (brick.around[k_brick_itself + after[0] + 9 * after[1] + 3 * after[2]] != k_brick_none) continue;
        uint8_t* node = blocks->solid + x + k_solid_pitch * (z + k_solid_pitch * y);
        *node = *(node - after[0] - k_solid_pitch * (after[2] + k_solid_pitch * after[1]));
      }
}

// False: it lies deep in a collider, and nobody sees it.
bool make_vertex(const SkinState& s, const Brick& brick, const SkinBlocks& blocks, const uint32_t cell[3],
                 sandglass_skin_vertex* out, uint32_t* anchor) {
  float u[3], normal[3], floor[3], shift[3] = {0, 0, 0}, over = k_far;
  constexpr uint32_t k_steps[3] = {1, k_solid_pitch * k_solid_pitch, k_solid_pitch};
  CellValues solid, walls;
  if (!brick.open) {
    const uint32_t first = (cell[0] + 1) * k_steps[0] + (cell[1] + 1) * k_steps[1] + (cell[2] + 1) * k_steps[2];
    solid = CellValues(blocks.solid + first, k_steps);
    walls = CellValues(blocks.walls + first, k_steps);
    if (solid.sum() < 8 * (128.0f + 48.0f * k_buried)) return false;
  }
  constexpr uint32_t k_before = k_apron - 1;
  const Nodes nodes(blocks.calm + (cell[0] + k_before) * k_step[0] + (cell[1] + k_before) * k_step[1] +
                    (cell[2] + k_before) * k_step[2]);
  const bool walled = nodes.crossing(solid, walls, u);
  const float value = nodes.smoothed(u, normal), square = dot(normal, normal);
  float scale = square > 1.0f && !walled ? (k_level - value) / square : 0.0f;  // Newton's step to the level
  const float step = __builtin_fabsf(scale) * __builtin_sqrtf(square);
  if (step > 0.5f) scale *= 0.5f / step;
  for (uint32_t m = 0; m < 3; ++m) u[m] = clamped(u[m] + scale * normal[m], 0, 1);
  float around = nodes.mean() - k_level;  // the mean density about u, less that of a plane
  for (uint32_t m = 0; m < 3; ++m) around += normal[m] * (u[m] - 0.5f);
  const float inverse = inverse_length(normal);
  for (uint32_t m = 0; m < 3; ++m) normal[m] = inverse != 0.0f ? -inverse * normal[m] : s.up[m];
  if (!brick.open) {
    const float distance = solid.at(u);
    if (distance < 250.0f) over = (distance - 128.0f) * (1.0f / 48.0f);
    if (over < k_foot_radii / k_skin_spacing) {
      solid.gradient(u, floor);
      const float length = inverse_length(floor);
      for (uint32_t m = 0; m < 3; ++m) floor[m] *= length;
      const float lifted = over < k_deepest && s.desc.capped == 0 ? k_deepest - over : 0.0f;
      over += lifted;
      if (s.desc.capped != 0 && dot(normal, floor) < 0) over = k_far;  // it faces the wall
      else run_out(s, floor, over, walled ? 0 : room_aside(blocks, cell), shift, normal);
      for (uint32_t m = 0; m < 3; ++m) shift[m] += lifted * floor[m];
    }
  }
  float place[3];  // in nodes
  for (uint32_t m = 0; m < 3; ++m)
    place[m] = static_cast<float>(8 * brick.at[m] + static_cast<int32_t>(cell[m])) + u[m];
  const float steps[3] = {place[0] * k_skin_steps, place[1] * k_skin_steps, place[2] * k_skin_steps};
  *anchor = anchor_of(s, brick, cell, steps, *anchor);
  for (uint32_t m = 0; m < 3; ++m) {
    const uint32_t w = s.axis[m];
    out->position[w] = s.sign[m] * s.spacing * (place[m] + shift[m] + 0.5f);
    out->normal[w] = of_127(s.sign[m] * normal[m]);
    float at = 0;
    if (*anchor != k_brick_none)
      at = s.sign[m] * s.spacing * (static_cast<float>(s.particles[*anchor].at[m]) * (1.0f / k_skin_steps) + 0.5f);
    out->origin[w] = turns(at / s.desc.block_side);
  }
  const uint64_t seed = mix_bits(*anchor);  // another place in the block for each particle
  for (uint32_t m = 0; m < 3; ++m) out->origin[m] = static_cast<uint16_t>(out->origin[m] - (seed >> (16 * m)));
  const float hollow = k_hollow_flat + k_hollow_gain * (1.0f / k_skin_one) * around;
  out->hollow = static_cast<uint8_t>(to_whole<uint32_t>(255.0f * clamped(hollow, 0, 1) + 0.5f));
  const float micrometres = clamped(1e6f * s.spacing * over, -32768.0f, 32767.0f);
  out->over = static_cast<int16_t>(floor_whole(micrometres));
  return true;
}

// ---- bricks of a chunk

uint32_t brick_of_chunk(const SkinState& s, const SkinChunk& chunk, uint32_t i) {
  const int32_t at[3] = {4 * chunk.at[0] + static_cast<int32_t>(i & 3), 4 * chunk.at[1] + static_cast<int32_t>(i >> 4),
                         4 * chunk.at[2] + static_cast<int32_t>(i >> 2 & 3)};
  return brick_find(s, at);
}
constexpr uint32_t k_chunk_volume = k_chunk_bricks * k_chunk_bricks * k_chunk_bricks;

void make_vertices(SkinState* s, uint32_t number, uint32_t chunk) {
  Brick& brick = s->bricks[number];
  BrickNodes& nodes = s->nodes[number];
  SkinMesh& back = s->back;
  SkinBlocks& blocks = *s->blocks;
  uint16_t* before = blocks.before;
  const uint32_t old = s->front.first_vertex[chunk] + brick.first;
  const bool had = brick.count != 0;
  memcpy(before, nodes.vertices, sizeof nodes.vertices);
  memset(nodes.vertices, 0xff, sizeof nodes.vertices);
  brick.first = back.vertex_count - back.first_vertex[chunk];
  brick.count = 0;
  read_rows<0, 1>(*s, brick, &BrickNodes::inside, blocks.rows[0]);
  uint32_t any = 0;
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z) any |= crossed(blocks, y, z);
  if (any == 0) return;
  uint8_t kept[k_brick_layer];
  find_kept(*s, brick, kept);
  bool read = false;
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z)
      for (uint32_t cells = crossed(blocks, y, z); cells != 0; cells &= cells - 1) {
        if (back.vertex_count == s->vertex_capacity) return;
        const uint32_t x = static_cast<uint32_t>(__builtin_ctz(cells)), at = x + 8 * z + 64 * y;
        const uint32_t cell[3] = {x, y, z};
        sandglass_skin_vertex& vertex = back.vertices[back.vertex_count];
        uint32_t& anchor = back.anchors[back.vertex_count];
        anchor = k_brick_none;
        bool as_before = false;
        if (had && before[at] != k_vertex_none) {
          anchor = s->front.anchors[old + before[at]];
          as_before =
              (kept[z + 8 * y] >> x & 1) != 0 && (anchor == k_brick_none || s->particles[anchor].moved != s->cycle);
        }
        if (as_before) {
          vertex = s->front.vertices[old + before[at]];
        } else {
          if (!read) read_blocks(*s, brick, &blocks);
          read = true;
          if (!make_vertex(*s, brick, blocks, cell, &vertex, &anchor)) continue;
        }
        nodes.vertices[at] = static_cast<uint16_t>(brick.count++);
        ++back.vertex_count;
      }
}

void copy_vertices(SkinState* s, uint32_t number, uint32_t chunk) {
  Brick& brick = s->bricks[number];
  SkinMesh &back = s->back, &front = s->front;
  const uint32_t old = front.first_vertex[chunk] + brick.first, room = s->vertex_capacity - back.vertex_count;
  brick.first = back.vertex_count - back.first_vertex[chunk];
  if (brick.count > room) {
    memset(s->nodes[number].vertices, 0xff, sizeof s->nodes[number].vertices);
    brick.count = 0;
  }
  memcpy(back.vertices + back.vertex_count, front.vertices + old, brick.count * sizeof *back.vertices);
  memcpy(back.anchors + back.vertex_count, front.anchors + old, brick.count * sizeof *back.anchors);
  back.vertex_count += brick.count;
}

// Whether nothing of a chunk, nor of the bricks whose vertices it copies, has changed.
bool is_as_before(const SkinState& s, const SkinChunk& chunk) {
  for (uint32_t i = 0; i < 125; ++i) {
    const int32_t at[3] = {4 * chunk.at[0] + static_cast<int32_t>(i % 5) - 1,
                           4 * chunk.at[1] + static_cast<int32_t>(i / 25) - 1,
                           4 * chunk.at[2] + static_cast<int32_t>(i / 5 % 5) - 1};
    const uint32_t number = brick_find(s, at);
    if (number != k_brick_none && (s.bricks[number].stale & k_stale_mesh) != 0) return false;
  }
  return true;
}

// ---- triangles

struct Corner {
  uint32_t brick, node;
};

// The cell `steps` below one, along the axes of `which` (bits of x, y, z).
Corner below(const SkinState& s, uint32_t number, const uint32_t cell[3], uint32_t which) {
  uint32_t k = k_brick_itself, local[3];
  constexpr uint32_t k_around[3] = {1, 9, 3};
  for (uint32_t m = 0; m < 3; ++m) {
    local[m] = cell[m];
    if ((which >> m & 1) == 0) continue;
    if (local[m] == 0) k -= k_around[m];
    local[m] = (local[m] + 7) % 8;
  }
  return {s.bricks[number].around[k], local[0] + 8 * local[2] + 64 * local[1]};
}

// Of the outer bricks of a chunk, by their place in 5^3.
uint32_t outer_of(const int32_t brick[3], const SkinChunk& chunk) {
  uint32_t at[3];
  for (uint32_t m = 0; m < 3; ++m) at[m] = static_cast<uint32_t>(brick[m] - 4 * chunk.at[m] + 1);
  if (at[0] == 0) return at[1] + 5 * at[2];
  if (at[1] == 0) return 25 + at[0] - 1 + 4 * at[2];
  return 45 + at[0] - 1 + 4 * (at[1] - 1);
}

// The index in the chunk of a cell's vertex, or k_vertex_none.
uint32_t index_of(SkinState* s, uint32_t chunk, const Corner& corner) {
  if (corner.brick == k_brick_none) return k_vertex_none;
  const Brick& brick = s->bricks[corner.brick];
  const uint32_t local = s->nodes[corner.brick].vertices[corner.node];
  if (local == k_vertex_none) return k_vertex_none;
  if (brick.chunk == chunk) return brick.first + local;
  SkinMesh& back = s->back;
  uint16_t& index = s->outer[k_brick_nodes * outer_of(brick.at, s->chunks[chunk]) + corner.node];
  if (index != k_vertex_none || back.vertex_count == s->vertex_capacity) return index;
  const uint32_t from = back.first_vertex[brick.chunk] + brick.first + local;
  back.vertices[back.vertex_count] = back.vertices[from];
  back.anchors[back.vertex_count] = back.anchors[from];
  index = static_cast<uint16_t>(back.vertex_count++ - back.first_vertex[chunk]);
  return index;
}

void make_quad(SkinState* s, uint32_t chunk, uint32_t number, const uint32_t cell[3], uint32_t axis, bool inside) {
  const uint32_t one = (axis + 1) % 3, two = (axis + 2) % 3;
  SkinMesh& back = s->back;
  uint32_t at[4];
  if (cell[one] != 0 && cell[two] != 0) {  // all in this brick
    constexpr uint32_t k_nodes[3] = {1, k_brick_layer, k_brick_side};
    const uint32_t node = cell[0] + k_brick_side * cell[2] + k_brick_layer * cell[1];
    const uint32_t nodes[4] = {node, node - k_nodes[one], node - k_nodes[one] - k_nodes[two], node - k_nodes[two]};
    for (uint32_t c = 0; c < 4; ++c) {
      at[c] = s->nodes[number].vertices[nodes[c]];
      if (at[c] == k_vertex_none) return;
      at[c] += s->bricks[number].first;
    }
  } else {
    const uint32_t which[4] = {0, 1u << one, 1u << one | 1u << two, 1u << two};
    for (uint32_t c = 0; c < 4; ++c) {
      at[c] = index_of(s, chunk, below(*s, number, cell, which[c]));
      if (at[c] == k_vertex_none) return;
    }
  }
  const float below = 1e6f * s->spacing * k_below;
  bool hidden = s->desc.capped == 0;  // what lies wholly in colliders
  for (const uint32_t v : at) hidden = hidden && back.vertices[back.first_vertex[chunk] + v].over < below;
  if (hidden) return;
  if (!inside) {
    const uint32_t swap = at[1];
    at[1] = at[3];
    at[3] = swap;
  }
  if (s->index_capacity - back.index_count < 6) return;
  // Both triangles take the block of the quad's first vertex.
  constexpr uint32_t k_orders[2][6] = {{1, 2, 0, 2, 3, 0}, {0, 1, 2, 0, 2, 3}};
  for (const uint32_t c : k_orders[s->desc.first_vertex])
    back.indices[back.index_count++] = static_cast<uint16_t>(at[c]);
}

void make_triangles(SkinState* s, uint32_t chunk, uint32_t number) {
  SkinBlocks& blocks = *s->blocks;
  read_rows<0, 1>(*s, s->bricks[number], &BrickNodes::inside, blocks.rows[0]);
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t z = 0; z < 8; ++z) {
      const uint32_t row = blocks.rows[y][z];
      const uint32_t other[3] = {row >> 1, blocks.rows[y + 1][z], blocks.rows[y][z + 1]};
      for (uint32_t axis = 0; axis < 3; ++axis)
        for (uint32_t edges = (row ^ other[axis]) & 0xff; edges != 0; edges &= edges - 1) {
          const uint32_t cell[3] = {static_cast<uint32_t>(__builtin_ctz(edges)), y, z};
          make_quad(s, chunk, number, cell, axis, (row >> cell[0] & 1) != 0);
        }
    }
}

// The chunk's numbers, and whether its bytes differ from those before.
void end_chunk(SkinState* s, uint32_t chunk, bool copied) {
  SkinMesh &back = s->back, &front = s->front;
  sandglass_skin_chunk& now = back.chunks[chunk];
  const sandglass_skin_chunk& before = front.chunks[chunk];
  now = {};
  now.vertices = back.vertices + back.first_vertex[chunk];
  now.indices = back.indices + back.first_index[chunk];
  now.vertex_count = back.vertex_count - back.first_vertex[chunk];
  now.index_count = back.index_count - back.first_index[chunk];
  now.version = before.version;
  if (copied) {
    memcpy(now.low, before.low, sizeof now.low);
    memcpy(now.high, before.high, sizeof now.high);
    return;
  }
  for (uint32_t m = 0; m < 3; ++m) {
    float low = 3e38f, high = -3e38f;
    for (uint32_t v = 0; v < now.vertex_count; ++v) {
      const float x = now.vertices[v].position[m];
      low = x < low ? x : low;
      high = x > high ? x : high;
    }
    now.low[m] = now.vertex_count != 0 ? low : 0;
    now.high[m] = now.vertex_count != 0 ? high : 0;
  }
  const bool same =
      now.vertex_count == before.vertex_count && now.index_count == before.index_count &&
      (now.vertex_count == 0 || (memcmp(now.vertices, before.vertices, now.vertex_count * sizeof *now.vertices) == 0 &&
                                 memcmp(now.indices, before.indices, now.index_count * sizeof *now.indices) == 0));
  if (!same) now.version = k_chunk_changed;
}

}  // namespace

void skin_begin_mesh(SkinState* s) {
  SkinMesh& back = s->back;
  back.vertex_count = back.index_count = 0;
  for (uint32_t c = 0; c < s->chunk_capacity; ++c) {
    back.first_vertex[c] = back.first_index[c] = 0;
    if (s->chunks[c].bricks != 0) continue;
    back.chunks[c] = {};
    back.chunks[c].version = s->front.chunks[c].index_count != 0 ? s->version + 1 : s->front.chunks[c].version;
  }
  s->cursor = 0;
  s->layer = 0;  // the next brick of the chunk
}

bool skin_mesh(SkinState* s) {
  SkinMesh& back = s->back;
  for (uint32_t done = 0; done < k_skin_unit_mesh;) {
    if (s->cursor >= s->chunk_count) {
      s->cursor = 0;
      return true;
    }
    const uint32_t c = s->chunk_order[s->cursor];
    const SkinChunk& chunk = s->chunks[c];
    const sandglass_skin_chunk& before = s->front.chunks[c];
    if (s->layer == 0) {
      back.first_vertex[c] = back.vertex_count;
      back.first_index[c] = back.index_count;
      if (s->valid && is_as_before(*s, chunk) && before.vertex_count <= s->vertex_capacity - back.vertex_count &&
          before.index_count <= s->index_capacity - back.index_count) {
        const uint32_t old = s->front.first_vertex[c];
        memcpy(back.vertices + back.vertex_count, s->front.vertices + old, before.vertex_count * sizeof *back.vertices);
        memcpy(back.anchors + back.vertex_count, s->front.anchors + old, before.vertex_count * sizeof *back.anchors);
        memcpy(back.indices + back.index_count, s->front.indices + s->front.first_index[c],
               before.index_count * sizeof *back.indices);
        back.vertex_count += before.vertex_count;
        back.index_count += before.index_count;
        end_chunk(s, c, true);
        ++s->cursor;
        ++done;
        continue;
      }
    }
    // First the vertices of its bricks, then the triangles.
    for (; s->layer < 2 * k_chunk_volume && done < k_skin_unit_mesh; ++s->layer) {
      if (s->layer == k_chunk_volume) memset(s->outer, 0xff, k_outer_bricks * k_brick_nodes * sizeof *s->outer);
      const uint32_t number = brick_of_chunk(*s, chunk, s->layer % k_chunk_volume);
      if (number == k_brick_none) continue;
      if (s->layer >= k_chunk_volume) {
        if (s->bricks[number].count == 0) continue;
        make_triangles(s, c, number);
        ++done;
      } else if ((s->bricks[number].stale & k_stale_mesh) != 0) {
        make_vertices(s, number, c);
        ++done;
      } else {
        copy_vertices(s, number, c);
      }
    }
    if (s->layer < 2 * k_chunk_volume) return false;
    end_chunk(s, c, false);
    s->layer = 0;
    ++s->cursor;
  }
  return false;
}

}  // namespace sandglass

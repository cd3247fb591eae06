// The mesh: surface nets (Gibson 1998). A cell between eight nodes that the surface passes has one vertex, an edge
// between two nodes that it crosses has one quad, of the four cells about it.
//
// A brick that has changed makes its vertices anew; those of others are copied from the mesh before. A chunk in which
// nothing has changed is copied whole. A chunk's triangles need vertices of the bricks below it along each axis: it
// holds copies of them, so that it is drawn by itself. Chunks are made in the order of their places, so those bricks
// are done.
#include <cstring>

#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_below =
    -1.0f / 16;  // nodes over a collider of a vertex that is hidden: that of one that is lifted, rounded

// Bits of the rows of a brick's nodes, and of as many nodes before and after it on every side.
template <uint32_t before, uint32_t after>
void read_rows(const SkinBricks& bricks, const Brick& brick, uint8_t (BrickNodes::*field)[k_brick_layer],
               uint16_t* rows) {
  constexpr uint32_t k_first = k_brick_side - before, k_end = 2 * k_brick_side + after;
  constexpr uint8_t k_nothing[k_brick_layer] = {};
  const uint8_t* from[3] = {k_nothing, k_nothing, k_nothing};
  for (uint32_t y = k_first; y < k_end; ++y)
    for (uint32_t z = k_first; z < k_end; ++z) {
      const uint32_t* three = brick.around + around_index(0, brick_along(y), brick_along(z));
      const uint32_t row = row_index(node_along(y), node_along(z));
      if (z == k_first || node_along(z) == 0)
        for (uint32_t x = 0; x < 3; ++x) from[x] = three[x] == k_none ? k_nothing : bricks.nodes[three[x]].*field;
      const uint32_t bits =
          uint32_t{from[0][row]} | uint32_t{from[1][row]} << k_brick_side | uint32_t{from[2][row]} << 2 * k_brick_side;
      *rows++ = static_cast<uint16_t>(bits >> k_first & ((1u << (k_end - k_first)) - 1));
    }
}

// The cells of which no node that counts has changed since their vertices were made: bits of a row.
void find_kept(const SkinBricks& bricks, const Brick& brick, uint8_t kept[k_brick_layer]) {
  constexpr uint32_t k_side = k_brick_side + 3;  // from the node before a cell to the second one after it
  uint16_t rows[k_side * k_side];
  read_rows<1, 2>(bricks, brick, &BrickNodes::changed, rows);
  for (uint16_t& row : rows) row = static_cast<uint16_t>(row | row >> 1 | row >> 2 | row >> 3);
  for (uint32_t step = 1; step <= k_side; step += k_side - 1)
    for (uint32_t i = 0; i + 3 * step < k_side * k_side; ++i)
      rows[i] = static_cast<uint16_t>(rows[i] | rows[i + step] | rows[i + 2 * step] | rows[i + 3 * step]);
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) kept[row_index(y, z)] = static_cast<uint8_t>(~rows[k_side * y + z]);
}

constexpr uint32_t k_row = (1u << k_brick_side) - 1;  // bits of all nodes of one

// The cells of a row through which the surface passes.
uint32_t crossed(const SkinBlocks& b, uint32_t y, uint32_t z) {
  const uint32_t any = b.rows[y][z] | b.rows[y + 1][z] | b.rows[y][z + 1] | b.rows[y + 1][z + 1];
  const uint32_t all = b.rows[y][z] & b.rows[y + 1][z] & b.rows[y][z + 1] & b.rows[y + 1][z + 1];
  return (any | any >> 1) & ~(all & all >> 1) & k_row;
}

// ---- bricks of a chunk

constexpr uint32_t k_chunk_volume = k_chunk_bricks * k_chunk_bricks * k_chunk_bricks;
constexpr uint32_t k_outer_side = k_chunk_bricks + 1;  // of a chunk and the bricks below it along each axis

// A brick of a chunk by its place in there; -1: below it.
uint32_t brick_of_chunk(const SkinBricks& bricks, const SkinChunk& chunk, int32_t x, int32_t y, int32_t z) {
  constexpr auto k_side = static_cast<int32_t>(k_chunk_bricks);
  const int32_t at[3] = {k_side * chunk.at[0] + x, k_side * chunk.at[1] + y, k_side * chunk.at[2] + z};
  return brick_find(bricks, at);
}

// Adds the vertices of a brick, cell by cell. Where nothing about a cell has changed, it takes the vertex of the mesh
// before.
struct CellVertices {
  SkinMeshes* meshes;
  const SkinState& s;
  const Brick& brick;
  BrickNodes& nodes;
  uint32_t old;  // the brick's first vertex, in the mesh before
  bool had, read;
  uint8_t kept[k_brick_layer];

  // False: there is none.
  bool add(const uint32_t cell[3]) {
    SkinMesh &back = meshes->back, &front = meshes->front;
    SkinBlocks& blocks = *meshes->blocks;
    sandglass_skin_vertex& vertex = back.vertices[back.vertex_count];
    uint32_t& anchor = back.anchors[back.vertex_count];
    const uint32_t before = blocks.before[node_index(cell[0], cell[1], cell[2])];
    anchor = k_none;
    if (had && before != k_vertex_none) {
      anchor = front.anchors[old + before];
      const bool same_nodes = (kept[row_index(cell[1], cell[2])] >> cell[0] & 1) != 0;
      if (same_nodes && (anchor == k_none || s.sand.particles[anchor].moved != s.sand.cycle)) {
        vertex = front.vertices[old + before];
        return true;
      }
    }
    if (!read) vertex_read_blocks(s, brick, &blocks);
    read = true;
    return vertex_make(s, brick, blocks, cell, &vertex, &anchor);
  }
};

void make_vertices(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s, uint32_t number, uint32_t chunk) {
  Brick& brick = bricks->records[number];
  BrickNodes& nodes = bricks->nodes[number];
  SkinMesh& back = meshes->back;
  SkinBlocks& blocks = *meshes->blocks;
  CellVertices vertices = {meshes,           s,     brick, nodes, meshes->front.first_vertex[chunk] + brick.first,
                           brick.count != 0, false, {}};
  memcpy(blocks.before, nodes.vertices, sizeof nodes.vertices);
  memset(nodes.vertices, 0xff, sizeof nodes.vertices);
  brick.first = back.vertex_count - back.first_vertex[chunk];
  brick.count = 0;
  read_rows<0, 1>(*bricks, brick, &BrickNodes::inside, blocks.rows[0]);
  uint32_t any = 0;
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) any |= crossed(blocks, y, z);
  if (any == 0) return;
  find_kept(*bricks, brick, vertices.kept);
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z)
      for (uint32_t cells = crossed(blocks, y, z); cells != 0; cells &= cells - 1) {
        if (back.vertex_count == meshes->vertex_capacity) return;
        const uint32_t cell[3] = {static_cast<uint32_t>(__builtin_ctz(cells)), y, z};
        if (!vertices.add(cell)) continue;
        nodes.vertices[node_index(cell[0], y, z)] = static_cast<uint16_t>(brick.count++);
        ++back.vertex_count;
      }
}

// Copies a brick's vertices from the mesh before.
void copy_vertices(SkinMeshes* meshes, SkinBricks* bricks, uint32_t number, uint32_t chunk) {
  Brick& brick = bricks->records[number];
  SkinMesh &back = meshes->back, &front = meshes->front;
  const uint32_t old = front.first_vertex[chunk] + brick.first, room = meshes->vertex_capacity - back.vertex_count;
  brick.first = back.vertex_count - back.first_vertex[chunk];
  if (brick.count > room) {
    memset(bricks->nodes[number].vertices, 0xff, sizeof bricks->nodes[number].vertices);
    brick.count = 0;
  }
  memcpy(back.vertices + back.vertex_count, front.vertices + old, brick.count * sizeof *back.vertices);
  memcpy(back.anchors + back.vertex_count, front.anchors + old, brick.count * sizeof *back.anchors);
  back.vertex_count += brick.count;
}

// Whether nothing of a chunk, nor of the bricks whose vertices it copies, has changed.
bool is_as_before(const SkinBricks& bricks, const SkinChunk& chunk) {
  constexpr auto k_side = static_cast<int32_t>(k_chunk_bricks);
  for (int32_t y = -1; y < k_side; ++y)
    for (int32_t z = -1; z < k_side; ++z)
      for (int32_t x = -1; x < k_side; ++x) {
        const uint32_t number = brick_of_chunk(bricks, chunk, x, y, z);
        if (number != k_none && (bricks.records[number].stale & k_stale_mesh) != 0) return false;
      }
  return true;
}

// ---- triangles

struct Corner {
  uint32_t brick, node;
};

// The cell before one, along the axes of `which` (bits of x, y, z).
Corner cell_before(const SkinBricks& bricks, uint32_t number, const uint32_t cell[3], uint32_t which) {
  uint32_t around = k_brick_itself, local[3];
  for (uint32_t m = 0; m < 3; ++m) {
    const uint32_t back = which >> m & 1;
    if (cell[m] < back) around -= k_around_step[m];
    local[m] = node_along(cell[m] - back);
  }
  return {bricks.records[number].around[around], node_index(local[0], local[1], local[2])};
}

// The number of an outer brick of a chunk: first come those below the chunk along x, then along y, then along z.
uint32_t outer_of(const int32_t brick[3], const SkinChunk& chunk) {
  uint32_t at[3];
  for (uint32_t m = 0; m < 3; ++m)
    at[m] = static_cast<uint32_t>(brick[m] - static_cast<int32_t>(k_chunk_bricks) * chunk.at[m] + 1);
  constexpr uint32_t k_first_y = k_outer_side * k_outer_side, k_first_z = k_first_y + k_chunk_bricks * k_outer_side;
  if (at[0] == 0) return at[1] + k_outer_side * at[2];
  if (at[1] == 0) return k_first_y + at[0] - 1 + k_chunk_bricks * at[2];
  return k_first_z + at[0] - 1 + k_chunk_bricks * (at[1] - 1);
}

// The index in the chunk of a cell's vertex, or k_vertex_none.
uint32_t index_of(SkinMeshes* meshes, const SkinBricks& bricks, uint32_t chunk, const Corner& corner) {
  if (corner.brick == k_none) return k_vertex_none;
  const Brick& brick = bricks.records[corner.brick];
  const uint32_t local = bricks.nodes[corner.brick].vertices[corner.node];
  if (local == k_vertex_none) return k_vertex_none;
  if (brick.chunk == chunk) return brick.first + local;
  SkinMesh& back = meshes->back;
  uint16_t* of_brick = meshes->outer + k_brick_nodes * outer_of(brick.at, bricks.chunks.records[chunk]);
  uint16_t& index = of_brick[corner.node];
  if (index != k_vertex_none || back.vertex_count == meshes->vertex_capacity) return index;
  const uint32_t from = back.first_vertex[brick.chunk] + brick.first + local;
  back.vertices[back.vertex_count] = back.vertices[from];
  back.anchors[back.vertex_count] = back.anchors[from];
  index = static_cast<uint16_t>(back.vertex_count++ - back.first_vertex[chunk]);
  return index;
}

// The vertices of the four cells about the edge that begins at a node and goes along `axis`. False: one is missing.
bool find_corners(SkinMeshes* meshes, const SkinBricks& bricks, uint32_t chunk, uint32_t number, const uint32_t cell[3],
                  uint32_t axis, uint32_t at[4]) {
  const uint32_t second = (axis + 1) % 3, third = (axis + 2) % 3;
  if (cell[second] != 0 && cell[third] != 0) {  // all in this brick
    const uint32_t node = node_index(cell[0], cell[1], cell[2]), step[2] = {k_node_step[second], k_node_step[third]};
    const uint32_t nodes[4] = {node, node - step[0], node - step[0] - step[1], node - step[1]};
    for (uint32_t c = 0; c < 4; ++c) {
      at[c] = bricks.nodes[number].vertices[nodes[c]];
      if (at[c] == k_vertex_none) return false;
      at[c] += bricks.records[number].first;
    }
    return true;
  }
  const uint32_t which[4] = {0, 1u << second, 1u << second | 1u << third, 1u << third};
  for (uint32_t c = 0; c < 4; ++c) {
    at[c] = index_of(meshes, bricks, chunk, cell_before(bricks, number, cell, which[c]));
    if (at[c] == k_vertex_none) return false;
  }
  return true;
}

// The two triangles about such an edge. `inside`: its first node is.
void make_quad(SkinMeshes* meshes, const SkinState& s, uint32_t chunk, uint32_t number, const uint32_t cell[3],
               uint32_t axis, bool inside) {
  SkinMesh& back = meshes->back;
  uint32_t at[4];
  if (!find_corners(meshes, s.bricks, chunk, number, cell, axis, at)) return;
  const float below = 1e6f * s.lattice.spacing * k_below;
  bool hidden = s.desc.capped == 0;  // what lies wholly in colliders
  for (const uint32_t v : at) hidden = hidden && back.vertices[back.first_vertex[chunk] + v].over < below;
  if (hidden) return;
  if (!inside) {
    const uint32_t swap = at[1];
    at[1] = at[3];
    at[3] = swap;
  }
  if (meshes->index_capacity - back.index_count < 6) return;
  // Both triangles take the block of the quad's first vertex.
  constexpr uint32_t k_orders[2][6] = {{1, 2, 0, 2, 3, 0}, {0, 1, 2, 0, 2, 3}};
  for (const uint32_t c : k_orders[s.desc.first_vertex])
    back.indices[back.index_count++] = static_cast<uint16_t>(at[c]);
}

void make_triangles(SkinMeshes* meshes, const SkinState& s, uint32_t chunk, uint32_t number) {
  SkinBlocks& blocks = *meshes->blocks;
  read_rows<0, 1>(s.bricks, s.bricks.records[number], &BrickNodes::inside, blocks.rows[0]);
  for (uint32_t y = 0; y < k_brick_side; ++y)
    for (uint32_t z = 0; z < k_brick_side; ++z) {
      const uint32_t row = blocks.rows[y][z];
      const uint32_t other[3] = {row >> 1, blocks.rows[y + 1][z], blocks.rows[y][z + 1]};
      for (uint32_t axis = 0; axis < 3; ++axis)
        for (uint32_t edges = (row ^ other[axis]) & k_row; edges != 0; edges &= edges - 1) {
          const uint32_t cell[3] = {static_cast<uint32_t>(__builtin_ctz(edges)), y, z};
          make_quad(meshes, s, chunk, number, cell, axis, (row >> cell[0] & 1) != 0);
        }
    }
}

// ---- chunks

// The chunk's numbers, and whether its bytes differ from those before.
void end_chunk(SkinMeshes* meshes, uint32_t chunk, bool copied) {
  SkinMesh &back = meshes->back, &front = meshes->front;
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

// Copies a whole chunk, if nothing of it has changed and there is room.
bool copy_chunk(SkinMeshes* meshes, const SkinState& s, uint32_t chunk) {
  SkinMesh &back = meshes->back, &front = meshes->front;
  const sandglass_skin_chunk& before = front.chunks[chunk];
  if (!s.valid || !is_as_before(s.bricks, s.bricks.chunks.records[chunk]) ||
      before.vertex_count > meshes->vertex_capacity - back.vertex_count ||
      before.index_count > meshes->index_capacity - back.index_count)
    return false;
  const uint32_t vertex = front.first_vertex[chunk], index = front.first_index[chunk];
  memcpy(back.vertices + back.vertex_count, front.vertices + vertex, before.vertex_count * sizeof *back.vertices);
  memcpy(back.anchors + back.vertex_count, front.anchors + vertex, before.vertex_count * sizeof *back.anchors);
  memcpy(back.indices + back.index_count, front.indices + index, before.index_count * sizeof *back.indices);
  back.vertex_count += before.vertex_count;
  back.index_count += before.index_count;
  end_chunk(meshes, chunk, true);
  return true;
}

// One step of a chunk: the vertices of a brick, or once all have theirs, its triangles. True: it cost something.
bool make_step(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s, uint32_t chunk, uint32_t step) {
  const uint32_t i = step % k_chunk_volume;
  const auto along = [i](uint32_t shift) { return static_cast<int32_t>(i >> shift & (k_chunk_bricks - 1)); };
  const uint32_t number =
      brick_of_chunk(*bricks, bricks->chunks.records[chunk], along(0), along(2 * k_chunk_shift), along(k_chunk_shift));
  if (number == k_none) return false;
  if (step >= k_chunk_volume) {
    if (bricks->records[number].count == 0) return false;
    make_triangles(meshes, s, chunk, number);
  } else if ((bricks->records[number].stale & k_stale_mesh) != 0) {
    make_vertices(meshes, bricks, s, number, chunk);
  } else {
    copy_vertices(meshes, bricks, number, chunk);
    return false;
  }
  return true;
}

}  // namespace

void skin_begin_mesh(SkinMeshes* meshes, const SkinState& s) {
  SkinMesh &back = meshes->back, &front = meshes->front;
  back.vertex_count = back.index_count = 0;
  for (uint32_t c = 0; c < s.bricks.chunks.capacity; ++c) {
    back.first_vertex[c] = back.first_index[c] = 0;
    if (s.bricks.chunks.records[c].bricks != 0) continue;
    back.chunks[c] = {};
    back.chunks[c].version = front.chunks[c].index_count != 0 ? s.shown.version + 1 : front.chunks[c].version;
  }
  meshes->chunk = meshes->step = 0;
}

bool skin_mesh(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s) {
  constexpr uint32_t k_steps = 2 * k_chunk_volume;
  SkinMesh& back = meshes->back;
  for (uint32_t done = 0; done < k_skin_unit_mesh;) {
    if (meshes->chunk >= bricks->chunks.count) return true;
    const uint32_t chunk = bricks->chunks.order[meshes->chunk];
    if (meshes->step == 0) {
      back.first_vertex[chunk] = back.vertex_count;
      back.first_index[chunk] = back.index_count;
      if (copy_chunk(meshes, s, chunk)) {
        ++meshes->chunk;
        ++done;
        continue;
      }
    }
    for (; meshes->step < k_steps && done < k_skin_unit_mesh; ++meshes->step) {
      if (meshes->step == k_chunk_volume)
        memset(meshes->outer, 0xff, k_outer_bricks * k_brick_nodes * sizeof *meshes->outer);
      if (make_step(meshes, bricks, s, chunk, meshes->step)) ++done;
    }
    if (meshes->step < k_steps) return false;
    end_chunk(meshes, chunk, false);
    meshes->step = 0;
    ++meshes->chunk;
  }
  return false;
}

}  // namespace sandglass

// The neighbours on a triangle mesh, for paths along the surface. Half-edge h = 3t + k runs from corner k of triangle t
// to its next corner. The half-edges on one edge form a ring, in any number and direction, so a mesh need not be
// manifold.
#pragma once

#include "runtime/frame/layout.h"

namespace sandglass {

struct GeodesicMesh {
  const sandglass_mesh* mesh;
  uint32_t* mate;          // next half-edge on the same edge; itself on a boundary
  uint32_t* corner_first;  // vertex v owns corners[corner_first[v] .. corner_first[v+1])
  uint32_t* corners;       // half-edges that start at the vertex
  uint8_t* bends;          // a shortest path may turn at this vertex
  uint32_t* table;         // edge lookup while building
  uint32_t table_bits;
};

GeodesicMesh lay_out_geodesic_mesh(Layout* layout, const sandglass_mesh* mesh);
void build_geodesic_mesh(const GeodesicMesh& g);

inline uint32_t next_half_edge(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline uint32_t previous_half_edge(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
inline uint32_t start_of(const GeodesicMesh& g, uint32_t h) { return g.mesh->indices[h]; }
inline uint32_t end_of(const GeodesicMesh& g, uint32_t h) { return g.mesh->indices[next_half_edge(h)]; }
inline const float* vertex_position(const GeodesicMesh& g, uint32_t v) { return g.mesh->vertices + 3ull * v; }

}  // namespace sandglass

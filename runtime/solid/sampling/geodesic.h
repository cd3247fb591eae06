// Exact shortest-path distances (3.14) along a triangle mesh, from one point to the candidates within a radius of it.
//
// A shortest path is straight once the triangles that it crosses are unfolded into a plane, except where it turns at a
// vertex. So the search sends windows across edges. A window is a stretch of an edge, the unfolded place of the source
// behind it, and the length of the path before that source. A window that crosses a triangle reaches the candidates in
// it, its far vertex, and windows on its two far edges. Vertices where paths turn become sources too, nearest first, so
// each is a source once. (Mitchell, Mount, Papadimitriou 1987, in the form of Chen and Han; windows that a vertex
// dominates are dropped after Xin and Wang 2009.)
//
// Every length found is that of a real path, so a distance is never too small. On manifold meshes it is never too large
// either: the stack of windows has room for every triangle that a shortest path can cross. An edge of three or more
// triangles forks a window; between two vertices a path goes straight over one such edge at most, or windows would
// multiply without end. Nothing is refused here; the arguments were checked before.
#pragma once

#include "runtime/solid/sampling/candidates.h"
#include "runtime/solid/sampling/geodesic_mesh.h"

namespace sandglass {

struct Window {
  double from, to;      // stretch of the half-edge, metres from its start
  double x, y;          // the unfolded source: along the half-edge, and behind it (y >= 0)
  double sigma;         // length of the path up to the source, metres
  uint32_t half_edge;   // of the triangle that is entered
  uint32_t depth : 31;  // triangles crossed
  uint32_t forked : 1;  // one of the edges crossed has three or more triangles
};

// The candidates that are asked for, in one list a triangle.
struct NearSet {
  uint32_t count;
  uint32_t* record;
  uint32_t* next;
  double* distance;
};

struct Geodesic {
  GeodesicMesh surface;
  NearSet near;
  const Candidate* records;
  uint32_t* near_head;  // of each triangle; k_no_index: none
  double* distance;     // of each vertex; k_far: not reached
  uint32_t* heap;       // vertices, nearest on top
  uint32_t* heap_place;
  uint32_t* touched;
  uint32_t heap_count, touched_count;
  Window* stack;
  uint64_t stack_capacity;
  uint32_t stack_count;
  double radius;
};

Geodesic lay_out_geodesic(Layout* layout, const sandglass_mesh* mesh, uint64_t candidates);
void build_geodesic(Geodesic* g, const Candidate* records);

void begin_near(Geodesic* g);
void add_near(Geodesic* g, uint32_t record);
// Fills near.distance. Where no path shorter than `radius` was found it is k_far, or at least `radius`.
void measure_near(Geodesic* g, const float source[3], uint32_t triangle, double radius);

}  // namespace sandglass

// The two prepared inside tests behind sandglass_mesh_inside. Each lays its block out with one function, used for the
// size and for the creation.
#pragma once

#include "runtime/frame/layout.h"

namespace sandglass {

// Parity: triangles in integer coordinates. A grid across the ray's axis lists for each column the triangles that
// overlap it.
struct Parity {
  float bounds_min[3], bounds_max[3];
  double origin[3], steps_per_metre;
  int ray_axis, u_axis, v_axis;
  uint32_t shift;  // column = coordinate >> shift
  uint32_t columns_u, columns_v;
  uint32_t references;
  int32_t* triangles;      // 9 integers each: u v w of three corners
  uint32_t* column_first;  // one more than there are columns
  uint32_t* column_list;
};

struct WindingNode {
  double centre[3];
  double radius;     // negative: an empty node
  double dipole[3];  // sum of area * normal
  double moment[9];  // sum of area * normal (x) (centroid - centre)
  double area;
};

// Winding: triangles in Morton order, eight in a leaf, under a complete binary tree without pointers: the children of
// node n are 2n and 2n + 1.
struct Winding {
  uint32_t triangle_count;
  uint32_t leaf_count;  // a power of two
  float* triangles;     // 9 floats each
  uint64_t* order;
  WindingNode* nodes;  // 1 is the root
};

Parity measure_parity(const sandglass_mesh& mesh, const float bounds_min[3], const float bounds_max[3]);
void lay_out_parity(Layout* layout, const sandglass_mesh& mesh, Parity* parity);
void build_parity(const sandglass_mesh& mesh, Parity* parity);
bool parity_inside(const Parity& parity, const float point[3]);

Winding measure_winding(const sandglass_mesh& mesh);
void lay_out_winding(Layout* layout, Winding* winding);
void build_winding(const sandglass_mesh& mesh, const float bounds_min[3], const float bounds_max[3], Winding* winding);
double winding_number(const Winding& winding, const float point[3]);

// The signed solid angle of a triangle (9 floats) as seen from a point: (3.27), corrected; see sandglass/sampling.h.
double solid_angle(const float triangle[9], const double point[3]);

}  // namespace sandglass

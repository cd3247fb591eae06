// Triangle meshes as plain arrays: what they hold, how they are cleaned, and what cleaning finds. Errors are sentences
// in the result, not exceptions.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/sampling.h"

namespace sandglass::host {

struct Mesh {
  std::vector<float> vertices;    // x y z of each vertex
  std::vector<uint32_t> indices;  // three per triangle, counter-clockwise seen from outside

  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size() / 3); }
  uint32_t triangle_count() const { return static_cast<uint32_t>(indices.size() / 3); }
  sandglass_mesh view() const { return {vertices.data(), vertex_count(), indices.data(), triangle_count()}; }
};

// What cleaning did, and how the edges meet. In a closed, consistently oriented surface every edge belongs to two
// triangles, which run along it in opposite directions.
struct MeshReport {
  uint32_t merged_vertices = 0;       // had the position of another vertex
  uint32_t degenerate_triangles = 0;  // had two equal corners; dropped
  uint32_t boundary_edges = 0;        // belong to one triangle
  uint32_t non_manifold_edges = 0;    // belong to three or more triangles
  uint32_t inconsistent_edges = 0;    // belong to two triangles that run the same way
  uint32_t odd_edges = 0;             // belong to an odd number of triangles
  uint32_t unbalanced_edges = 0;      // triangles run along them more often one way than the other
  uint32_t parts = 0;                 // sets of triangles that hang together by edges
  uint32_t turned_parts = 0;          // were inside out; turned

  // Without odd edges every line crosses the surface an even number of times, so parity tells inside from outside.
  bool watertight() const { return odd_edges == 0; }
  // Where all neighbours agree, winding numbers tell too, and parts may overlap.
  bool oriented() const { return unbalanced_edges == 0; }
  bool manifold() const { return boundary_edges == 0 && non_manifold_edges == 0 && inconsistent_edges == 0; }
};

// How to tell its inside: by winding numbers, so that closed parts may overlap, or by parity where the triangles of a
// closed surface do not agree on its outside.
sandglass_inside_rule inside_rule(const MeshReport& report);

// One line about a mesh's faults; empty if there are none.
std::string describe_faults(const MeshReport& report);

struct MeshResult {
  Mesh mesh;
  MeshReport report;
  std::string error;                 // empty: the mesh is good to use
  std::vector<std::string> remarks;  // what a user should know of the file, each to stand behind its name

  explicit operator bool() const { return error.empty(); }
};

// Checks raw arrays, keeps the vertices that triangles use and merges those of equal position, drops triangles with two
// equal corners, turns closed parts that are inside out, and counts edges. `name` is what an error sentence calls the
// mesh. It refuses a mesh without (remaining) triangles, corners that are not finite, and indices out of range.
MeshResult clean_mesh(const std::vector<float>& vertices, const std::vector<uint32_t>& indices,
                      const std::string& name);

// parts.cpp: counts edges and parts, turns the parts that are inside out, and counts those.
void turn_outward(Mesh* mesh, MeshReport* report);

// What a file without units leaves open: how many metres its unit has, and which axis is up.
struct MeshUnits {
  double metres = 1.0;
  bool z_up = false;
};
struct MeshFile {
  std::string path;  // empty: none
  MeshUnits units;
  MeshFile(std::string file = "", MeshUnits of = {}) : path(std::move(file)), units(of) {}
};

// Reads a file of any format in readers/, told by its content; applies all transforms of the file; cleans. It refuses,
// with one sentence, a file that is missing, empty, cut off, of another format or wrong, and whatever clean_mesh refuses.
MeshResult load_mesh(const MeshFile& file);

// The same for a command: a Failure says what is wrong, and what a user should know is printed to stderr.
MeshResult load_mesh_for_command(const MeshFile& file);

// The enclosed volume in m^3, by the divergence theorem. It is negative for a mesh turned inside out.
double signed_volume(const Mesh& mesh);

// The least box around it.
struct MeshBox {
  std::array<float, 3> low, high;

  double size(size_t axis) const { return static_cast<double>(high[axis]) - static_cast<double>(low[axis]); }
  double longest_side() const { return std::max({size(0), size(1), size(2)}); }
};
MeshBox box_of(const Mesh& mesh);

// The same surface with no edge longer than `longest`: the longest edge of a triangle is halved until none is.
// Triangles that share an edge share its middle.
Mesh with_short_edges(const Mesh& mesh, double longest);

}  // namespace sandglass::host

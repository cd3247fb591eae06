// Triangle meshes as plain arrays: what they hold, how they are cleaned, and what cleaning finds. Errors are sentences
// in the result, not exceptions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

struct Mesh {
  std::vector<float> vertices;    // x y z of each vertex
  std::vector<uint32_t> indices;  // three per triangle, counter-clockwise seen from outside

  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size() / 3); }
  uint32_t triangle_count() const { return static_cast<uint32_t>(indices.size() / 3); }
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

  // Without odd edges every line crosses the surface an even number of times, so parity tells inside from outside.
  bool watertight() const { return odd_edges == 0; }
  bool manifold() const { return boundary_edges == 0 && non_manifold_edges == 0 && inconsistent_edges == 0; }
};

// One line about a mesh's faults; empty if there are none.
std::string describe_faults(const MeshReport& report);

struct MeshResult {
  Mesh mesh;
  MeshReport report;
  std::string error;  // empty: the mesh is good to use

  explicit operator bool() const { return error.empty(); }
};

// Checks raw arrays, merges vertices of equal position, drops triangles with two equal corners, and counts edges.
// `name` is what an error sentence calls the mesh. It refuses a mesh without vertices or (remaining) triangles,
// coordinates that are not finite, and indices out of range.
MeshResult clean_mesh(const std::vector<float>& vertices, const std::vector<uint32_t>& indices,
                      const std::string& name);

// Reads any format that Assimp knows, applies all transforms of the file, then cleans. It refuses, with one sentence, a
// file that is missing, empty, not a mesh or cut off, and whatever clean_mesh refuses. A build without Assimp refuses
// every file.
MeshResult load_mesh(const std::string& path);

// The enclosed volume in m^3, by the divergence theorem. It is negative for a mesh turned inside out.
double signed_volume(const Mesh& mesh);

// The same surface with no edge longer than `longest`: the longest edge of a triangle is halved until none is.
// Triangles that share an edge share its middle.
Mesh with_short_edges(const Mesh& mesh, double longest);

}  // namespace sandglass::host

// Triangle meshes on a workstation, as plain arrays: what they are made of, how they are cleaned, what is known of
// them. Errors are sentences in the result, not exceptions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

struct Mesh {
  std::vector<float> vertices;    // x y z
  std::vector<uint32_t> indices;  // three a triangle, counter-clockwise seen from outside

  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size() / 3); }
  uint32_t triangle_count() const { return static_cast<uint32_t>(indices.size() / 3); }
};

// What cleaning did, and how the edges meet. An undirected edge of a closed, consistently oriented surface belongs to
// two triangles that run through it in opposite directions.
struct MeshReport {
  uint32_t merged_vertices = 0;       // duplicates of another vertex
  uint32_t degenerate_triangles = 0;  // two equal corners: dropped
  uint32_t flat_triangles = 0;        // three corners in line: kept, because neighbours close against them
  uint32_t boundary_edges = 0;        // one triangle
  uint32_t non_manifold_edges = 0;    // three or more triangles
  uint32_t inconsistent_edges = 0;    // two triangles that run the same way
  uint32_t odd_edges = 0;             // an odd number of triangles

  // Every ray crosses the surface an even number of times, so parity tells inside from outside.
  bool watertight() const { return odd_edges == 0; }
  bool manifold() const { return boundary_edges == 0 && non_manifold_edges == 0 && inconsistent_edges == 0; }
};

// One line on a mesh's faults; empty if there are none.
std::string describe_faults(const MeshReport& report);

struct MeshResult {
  Mesh mesh;
  MeshReport report;
  std::string error;  // empty: the mesh is good to use

  explicit operator bool() const { return error.empty(); }
};

// Checks raw arrays, merges vertices of equal position, drops triangles with two equal corners, and counts. `name` is
// what an error sentence calls the mesh. Refused: no vertices, no (remaining) triangles, coordinates not finite,
// indices out of range.
MeshResult clean_mesh(const std::vector<float>& vertices, const std::vector<uint32_t>& indices,
                      const std::string& name);

// Reads any format that Assimp knows, with all transforms of the file applied, then cleans. Refused with one sentence:
// a file that is missing, empty, not a mesh, cut off, or whatever clean_mesh refuses; and everything in a build without
// Assimp.
MeshResult load_mesh(const std::string& path);

// The volume enclosed, m^3, by the divergence theorem: negative for a mesh turned inside out.
double signed_volume(const Mesh& mesh);

}  // namespace sandglass::host

// The readers of mesh files. Each takes the bytes of a file and gives its triangles as they stand there, before
// clean_mesh. They open no file themselves, and throw nothing: the page's module is made of the same code.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "models/mesh/mesh.h"

namespace sandglass::host {

// What a file says: in metres and y up where it names its unit and axes, as it stands where it does not. Places are
// double, since those of a survey are too large for float.
struct FileMesh {
  std::vector<double> vertices;            // x y z of each vertex
  std::vector<uint32_t> indices;           // three per triangle
  std::map<std::string, size_t> left_out;  // what has no surface, in the plural, and how many there were
};

// At most so many vertices, and so many corners of triangles, are read.
constexpr size_t k_items_of_file = size_t{1} << 25;

// Gives the content of a file that stands beside the one being read, or false where there is none.
using FileBeside = std::function<bool(const std::string& name, std::string* content)>;

// Each returns nothing, or what is wrong, as a sentence to stand behind "it ".
std::string read_gltf(std::string_view file, const FileBeside& beside, FileMesh* mesh);  // glTF 2.0, .glb and .gltf
std::string read_obj(std::string_view file, FileMesh* mesh);                             // Wavefront
std::string read_ply(std::string_view file, FileMesh* mesh);                             // text and both binary ones
std::string read_stl(std::string_view file, FileMesh* mesh);                             // text and binary
std::string read_off(std::string_view file, FileMesh* mesh);                             // text

// What a file is, by its content.
struct MeshFormat {
  enum Kind { none, gltf, obj, ply, stl, off, fbx, collada } kind = none;
  std::string is_instead;  // for none: "is a Blender file"
};
MeshFormat mesh_format(std::string_view file);
bool is_stl(std::string_view file);

// By the reader of that format; FBX and Collada have none here.
std::string read_mesh(MeshFormat::Kind kind, std::string_view file, const FileBeside& beside, FileMesh* mesh);

// Cleaned, in metres and y up. What is too far from its origin for floats is moved there. Remarks say so, and name what
// was not read, parts that were inside out, and a size that is rarely meant.
MeshResult finished_mesh(FileMesh file, const MeshUnits& units, const std::string& name);

// Adds a polygon of at least three corners as triangles. It may be concave; it is cut in the plane of its mean normal.
void add_polygon(const std::vector<uint32_t>& corners, FileMesh* mesh);

// "ends after 6 of 12 faces. Copy or export it again."
std::string ends_after(size_t there, size_t told, const char* what);

}  // namespace sandglass::host

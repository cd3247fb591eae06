// The readers of mesh files. Each takes the bytes of a file and gives its triangles as they stand there, before
// clean_mesh. They open no file themselves, and throw nothing: the page's module is made of the same code.
// A format is k_NAME in readers/NAME.cpp, with its place in the list of format.cpp.
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

struct MeshSource {
  std::string_view file;  // its bytes
  FileBeside beside = [](const std::string&, std::string*) { return false; };
  std::string path = {};  // empty: no file holds the bytes
};

// `sure`: by a mark that no other format has.
enum class Likeness { none, some, sure };

struct MeshFormat {
  const char *name, *endings;
  bool is_offered;  // as one that a refused mesh may be exported as
  // `text`: up to 4096 bytes, from the first word on.
  Likeness (*likeness)(std::string_view file, std::string_view text);
  // Returns nothing, or what is wrong, as a sentence to stand behind "it ".
  std::string (*read)(const MeshSource& source, FileMesh* mesh);
};
const std::vector<const MeshFormat*>& mesh_formats();

// What a file is, by its content.
struct MeshKind {
  const MeshFormat* format;  // null: none of these
  std::string is_instead;    // then: "is a Blender file"
};
MeshKind mesh_kind(std::string_view file);

// By the reader of its format; returns what that returns.
std::string read_mesh(const MeshSource& source, FileMesh* mesh);

// "glTF, OBJ, PLY or STL"
std::string offered_formats();

// Cleaned, in metres and y up. What is too far from its origin for floats is moved there. Remarks say so, and name what
// was not read, parts that were inside out, and a size that is rarely meant.
MeshResult finished_mesh(FileMesh file, const MeshUnits& units, const std::string& name);

// Adds a polygon of at least three corners as triangles. It may be concave; it is cut in the plane of its mean normal.
void add_polygon(const std::vector<uint32_t>& corners, FileMesh* mesh);

// "ends after 6 of 12 faces. Copy or export it again."
std::string ends_after(size_t there, size_t given, const char* what);

}  // namespace sandglass::host

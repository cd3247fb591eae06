// Names on the command line: the nearest one to a mistyped word, lists of them, and the mesh that a name stands for.
#pragma once

#include <string>
#include <vector>

#include "models/mesh/mesh.h"

namespace sandglass::host {

// The name that `word` was probably meant to be; empty where none is near. Near means: few letters are wrong, missing,
// too many or swapped, or `word` begins the name.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

// " Did you mean "threads"?", or nothing.
std::string suggestion(const std::string& word, const std::vector<std::string>& names);

// "a, b or c"
std::string list_of(const std::vector<std::string>& names, const std::string& last);

// A generated mesh (models/mesh/generated.h), or the mesh of a file. A Failure names what cannot be read.
MeshResult named_mesh(const std::string& name_or_file);

inline std::string in_quotes(const std::string& text) { return '"' + text + '"'; }

}  // namespace sandglass::host

// Files that ship with the program: in the source tree, or installed beside it.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

// Where those of a kind ("scenes", "shadows", "lights", "kept_rooms") may be.
std::vector<std::string> shipped_folders(const std::string& kind);
// The path of one; empty where it is not there.
std::string shipped_file(const std::string& kind, const std::string& name);

}  // namespace sandglass::host

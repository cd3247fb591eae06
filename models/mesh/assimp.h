// FBX and Collada, by Assimp: files with units, whose figures are animated and nested in ways that no page describes.
#pragma once

#include <string>

#include "models/mesh/readers.h"

namespace sandglass::host {

// In metres and y up, as the file says. Returns what is wrong, to stand behind "it ", or nothing. Assimp crashes on some
// damaged files and never returns from others, so it runs in a process of its own, for a bounded time.
std::string read_by_assimp(const std::string& path, uint64_t file_bytes, FileMesh* mesh);

}  // namespace sandglass::host

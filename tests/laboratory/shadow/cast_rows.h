// How far the shadows of sandglass/cast.h are from rays: on floors, walls and below a table, of one light and of rooms, and
// from frame to frame.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/rooms/panorama.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct CastMeshFile {
  std::string name;
  Mesh mesh;
  bool closed = false;
};

struct CastRowsOptions {
  std::vector<CastMeshFile> meshes;
  std::vector<RadianceMap> rooms;    // empty: without ambient rows
  std::vector<unsigned char> baked;  // the file of the chair's baked shadow, for comparison
  uint64_t seed = 0;                 // how the lights are turned
  bool quick = false;                // half of the lights
};

// `progress` gets what is done and the whole, and returns false to stop; what is complete so far is returned.
std::vector<Verdict> verify_casts(const CastRowsOptions& options, ThreadPool& pool,
                                  const std::function<bool(size_t done, size_t all)>& progress);

}  // namespace sandglass::host

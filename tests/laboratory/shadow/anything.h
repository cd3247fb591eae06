// Shadows on what stands on a table: books, a cup, a bowl, a slope, a board, beside rays.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/sand/granular_verdicts.h"
#include "tests/laboratory/shadow/cast_rows.h"

namespace sandglass::host {

// A book, a thick one, a cup, a bowl, a slope, a board; each stands on y = 0.
std::vector<Mesh> table_meshes();

struct AnythingOptions {
  std::vector<CastMeshFile> meshes;   // what casts, all together
  std::vector<CastMeshFile> further;  // each by itself
  uint64_t seed = 0;
  bool quick = false;  // one azimuth of four, a third of the places
};

// Steps of `go_on`, which is called after each; false stops.
size_t anything_steps(const AnythingOptions& options);
std::vector<Verdict> verify_anything(const AnythingOptions& options, ThreadPool& pool,
                                     const std::function<bool()>& go_on);

}  // namespace sandglass::host

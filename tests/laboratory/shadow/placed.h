// A thing put into a place that was scanned: a chair on a table of books, cups and a slope, beside its path traced truth.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct PlacedOptions {
  std::vector<Mesh> table;  // what stands there: books, a thick one, a cup, a bowl, a slope, a board
  uint64_t seed = 0;        // of the truth's noise
  bool quick = false;       // fewer paths
  std::string picture;      // JPEG file that gets composite, truth, and the floor's texture; may be empty
};

constexpr size_t k_placed_poses = 5;

// `go_on` is called after each pose; false stops, without rows.
std::vector<Verdict> verify_placed(const PlacedOptions& options, ThreadPool& pool, const std::function<bool()>& go_on);

}  // namespace sandglass::host

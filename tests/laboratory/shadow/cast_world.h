// Casts in the world of an app: beside a scan of the room, in real shade, among things that are far, at the end of a
// table.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/geometry/vec3.h"
#include "models/mesh/mesh.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// A generated mesh of that height with its foot at a place.
Mesh standing(const char* name, double height, Vec3 at);

constexpr uint32_t k_cast_worlds = 4;

// `go_on` is called after each of k_cast_worlds; false stops.
std::vector<Verdict> verify_cast_worlds(uint64_t seed, bool quick, ThreadPool& pool,
                                        const std::function<bool()>& go_on);

}  // namespace sandglass::host

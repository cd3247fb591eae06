// Real surfaces that get the shadow of something virtual, over a camera's image: a table and a wall at once, behind a real
// bucket. As runtime/shadow/README.md has it, beside rays.
#pragma once

#include <functional>
#include <vector>

#include "models/rooms/panorama.h"
#include "models/work/thread_pool.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// `go_on` is called before each room; false ends.
std::vector<Verdict> verify_receivers(const std::vector<RadianceMap>& rooms, ThreadPool& pool,
                                      const std::function<bool()>& go_on);

}  // namespace sandglass::host

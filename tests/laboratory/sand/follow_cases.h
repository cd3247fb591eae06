// Scenes in which drawn grains are compared with their particles, and the claims about them: pours, hourglasses, a
// slope, the demonstration's knot, and heaps that are stirred, tilted and woken.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// The names of the groups of scenes, in the order in which they run.
std::vector<std::string> follow_groups();

// `groups`: empty for all. `seed` turns what is filled and poured about the vertical, and draws its grains; with 0 the
// scenes are as they ship. For `progress` see granular_verdicts: in units of about a tenth of a second.
std::vector<Verdict> follow_verdicts(const std::vector<std::string>& groups, uint64_t seed, sandglass_isa isa,
                                     const std::function<bool(uint64_t, uint64_t)>& progress);

}  // namespace sandglass::host

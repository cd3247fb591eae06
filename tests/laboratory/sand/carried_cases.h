// What holds sand is moved while the budget is short: whether the sand stays in it, still flows, and is thrown by nothing.
// A frame costs the instructions of its work units on a phone's core (models/phones), so results are the same everywhere.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

std::vector<std::string> carried_groups();

// `quick`: three scenes at 60 Hz. `seed` moves the start of every way by less than a frame. `table`, optional, receives a
// line for every scene and budget. For `progress` see granular_verdicts: in runs.
std::vector<Verdict> carried_verdicts(const VerdictChoice& choice, std::string* table,
                                      const std::function<bool(uint64_t, uint64_t)>& progress);

}  // namespace sandglass::host

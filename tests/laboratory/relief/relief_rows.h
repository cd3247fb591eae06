// How well a relief knows a table, against its truth, and carries sand: rows of `sandglass_lab verify relief`.
#pragma once

#include <functional>
#include <vector>

#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// Of so many seeds of noise. `go_on` is asked before each recording; when it returns false, the rows so far come back.
std::vector<Verdict> relief_verdicts(uint32_t seeds, const std::function<bool()>& go_on);
// How often that is.
uint64_t relief_recordings(uint32_t seeds);

}  // namespace sandglass::host

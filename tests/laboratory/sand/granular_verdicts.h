// The accuracy claims of granular material as a table: what is true, what was measured, and how far apart they may be.
// Some rows are negative controls: wrong settings that must fail. All rows use one parameter set, the library's
// defaults. Where a hard case needs finer settings, its row names them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"
#include "tests/laboratory/sand/flow_cases.h"

namespace sandglass::host {

// One row. The result may differ from the truth by the limit; a row without a limit (infinite) is reported and always
// passes. Control rows pass when a wrong setting fails the claim as it must.
struct Verdict {
  std::string group, name, unit;
  double truth = 0.0, result = 0.0, limit = 0.0;
  bool pass = false, control = false;
};

struct VerdictChoice {
  std::vector<std::string> groups;  // empty: all
  bool quick = false;               // of these, those of a second or two
  sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC;
  uint64_t seed = 0;  // of what is poured
};

// The names of the groups, in the order in which they run.
std::vector<std::string> verdict_groups();
// Of these, those of a second or two.
std::vector<std::string> quick_verdict_groups();

// `progress(done, total)` in units of about a frame of a thousand particles, after every frame; when it returns false,
// what is complete so far is returned.
std::vector<Verdict> granular_verdicts(const VerdictChoice& choice,
                                       const std::function<bool(uint64_t, uint64_t)>& progress);

}  // namespace sandglass::host

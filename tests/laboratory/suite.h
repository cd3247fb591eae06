// What every suite of `sandglass_lab` may use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/program/command_line.h"
#include "models/work/progress.h"

namespace sandglass::host {

using Options = std::vector<CommandOption>;

// Shows a progress bar while `measure` runs; what is passed on to it returns false after Ctrl-C.
template <class Measure>
auto with_progress(const std::string& what, const Measure& measure) {
  Progress progress(what, 1);
  return measure([&](uint64_t done, uint64_t total) {
    progress.total(total);
    return progress.goes_on(done);
  });
}

// The same for `all` steps: what is passed on takes nothing.
template <class Measure>
auto with_steps(const std::string& what, uint64_t all, const Measure& measure) {
  return with_progress(what, [&](const auto& go_on) {
    uint64_t done = 0;
    return measure([&] { return go_on(++done, all); });
  });
}

// The kernels of sand that this picks.
std::string kernels_of(sandglass_isa isa);

}  // namespace sandglass::host

// Independent pieces of long work on some threads, with progress and Ctrl-C.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace sandglass::host {

// Runs `task` for 0 .. count - 1, in any order, until one fails, whose exception comes out, or until Ctrl-C: what was
// begun is finished, and interrupted() says so. `what`: see Progress; `threads`: the
// calling one counts.
void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task);

}  // namespace sandglass::host

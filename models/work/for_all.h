// Independent pieces of long work on some threads, with progress and Ctrl-C.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace sandglass::host {

// Runs `task` for 0 to count - 1, in any order. Ends early when a task throws, and throws that exception; and on
// Ctrl-C, when interrupted() is true. What was begun is finished. `what`: see Progress; `threads`: the calling one
// counts.
void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task);

}  // namespace sandglass::host

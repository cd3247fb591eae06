// Runs independent pieces of long work on several threads, with progress and Ctrl-C.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace sandglass::host {

// Runs `task` for 0 to count - 1, in any order. It ends early when a task throws, and then throws that exception. It
// also ends early on Ctrl-C; then interrupted() is true. Tasks that have begun are finished. For `what` see Progress.
// `threads` includes the calling thread.
void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task);

}  // namespace sandglass::host

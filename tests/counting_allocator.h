// Counts calls of malloc and the other allocation functions in programs that link counting_allocator.cpp. Under a
// sanitizer, whose own allocator must stay, nothing is counted.
#pragma once

#include <cstdint>

namespace sandglass::host {

void start_counting_allocations();
// Returns the calls by all threads, of free too, since start_counting_allocations.
uint64_t stop_counting_allocations();

}  // namespace sandglass::host

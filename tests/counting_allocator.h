// Counts calls of malloc and its kin in programs that link counting_allocator.cpp. Under a sanitizer, whose own
// allocator must stay, nothing is counted.
#pragma once

#include <cstdint>

namespace sandglass::host {

void start_counting_allocations();
// Calls by any thread, of free too, since start_counting_allocations.
uint64_t stop_counting_allocations();

}  // namespace sandglass::host

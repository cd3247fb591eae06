// How many frames a budget case runs. An optimised native build runs one million, which is the condition to pass.
// Emulated, sanitised and unoptimised builds set SANDGLASS_GOVERNOR_FRAMES lower (see CMakeLists.txt); every case
// prints how many it ran.
#pragma once

#include <cstdint>

#ifndef SANDGLASS_GOVERNOR_FRAMES
#define SANDGLASS_GOVERNOR_FRAMES 1000000
#endif

namespace sandglass::governor_test {

constexpr uint64_t k_case_frames = SANDGLASS_GOVERNOR_FRAMES;

}  // namespace sandglass::governor_test

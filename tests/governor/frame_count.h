// How many frames a budget case runs: one million, the project's pass condition, where the build is optimised and
// native. Emulated, sanitised and unoptimised builds set SANDGLASS_GOVERNOR_FRAMES lower (see CMakeLists.txt), and
// every case says so.
#pragma once

#include <cstdint>

#ifndef SANDGLASS_GOVERNOR_FRAMES
#define SANDGLASS_GOVERNOR_FRAMES 1000000
#endif

namespace sandglass::governor_test {

constexpr uint64_t k_case_frames = SANDGLASS_GOVERNOR_FRAMES;

}  // namespace sandglass::governor_test

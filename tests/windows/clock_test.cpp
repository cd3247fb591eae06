// The clock of Windows, beside that of the C++ library.
#include <gtest/gtest.h>

#include <chrono>

#include "sandglass/sandglass.h"

TEST(Clock, CountsNanosecondsAndNeverGoesBackward) {
  const sandglass_clock clock = sandglass_clock_system();
  const auto start = std::chrono::steady_clock::now();
  const uint64_t first = clock.now_ns(clock.user);
  uint64_t last = first, steps = 0;
  double elapsed = 0;
  while (elapsed < 0.2) {
    const uint64_t now = clock.now_ns(clock.user);
    ASSERT_GE(now, last);
    steps += now > last;
    last = now;
    elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  EXPECT_NEAR(1e-9 * static_cast<double>(last - first), elapsed, 0.02);
  EXPECT_GT(steps, 1000u) << "a step is shorter than 0.2 ms";
}

// The clock of Windows: nanoseconds that never go backward, beside those of the C++ library.
#include <gtest/gtest.h>

#include <chrono>

#include "platform/clock.h"

namespace sandglass {
namespace {

TEST(Clock, CountsNanosecondsAndNeverGoesBackward) {
  const sandglass_clock clock = sandglass_clock_system(), of_thread = clock_thread_cpu();
  const auto start = std::chrono::steady_clock::now();
  const uint64_t first = clock.now_ns(clock.user), used_first = of_thread.now_ns(of_thread.user);
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
  EXPECT_GT(steps, 1000u) << "a reading is finer than 0.2 ms";
  const double used = 1e-9 * static_cast<double>(of_thread.now_ns(of_thread.user) - used_first);
  EXPECT_GT(used, 0.0);
  EXPECT_LT(used, elapsed + 0.05);
}

}  // namespace
}  // namespace sandglass

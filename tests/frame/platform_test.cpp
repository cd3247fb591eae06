// The platform layer: clocks advance as they should, CPU features agree with what the operating system says, and the
// floating-point environment is exact inside a frame and untouched outside.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include "platform/check.h"
#include "platform/clock.h"
#include "platform/cpu_features.h"
#include "platform/floating_point.h"
#include "platform/virtual_clock.h"

namespace sandglass {
namespace {

uint64_t read(const sandglass_clock& clock) { return clock.now_ns(clock.user); }

TEST(Clock, SystemClockNeverGoesBackwardAndMoves) {
  const sandglass_clock clock = sandglass_clock_system();
  const uint64_t start = read(clock);
  uint64_t last = start;
  for (int i = 0; i < 100000; ++i) {
    const uint64_t now = read(clock);
    ASSERT_GE(now, last);
    last = now;
  }
  EXPECT_GT(last, start);
}

TEST(Clock, ThreadClockCountsWork) {
  const sandglass_clock clock = clock_thread_cpu();
  const uint64_t start = read(clock);
  volatile uint64_t work = 0;
  for (int i = 0; i < 2000000; ++i) work = work + static_cast<uint64_t>(i);
  EXPECT_GT(read(clock), start);
}

#if defined(__linux__) && !defined(__aarch64__)
TEST(CpuFeatures, AgreeWithTheKernelsList) {
  std::ifstream file("/proc/cpuinfo");
  std::set<std::string> flags;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("flags", 0) != 0) continue;
    std::istringstream words(line.substr(line.find(':') + 1));
    flags.insert(std::istream_iterator<std::string>(words), {});
    break;
  }
  if (flags.empty()) GTEST_SKIP() << "the operating system's kernel lists no flags here";
  const CpuFeatures f = cpu_features();
  EXPECT_EQ(f.avx2, flags.count("avx2") == 1);
  EXPECT_EQ(f.fma, flags.count("fma") == 1);
  EXPECT_EQ(f.avx512f, flags.count("avx512f") == 1);
  EXPECT_EQ(f.avx512bw, flags.count("avx512bw") == 1);
  EXPECT_EQ(f.avx512dq, flags.count("avx512dq") == 1);
  EXPECT_EQ(f.avx512vl, flags.count("avx512vl") == 1);
  EXPECT_EQ(f.avx512vnni, flags.count("avx512_vnni") == 1);
}
#endif

// Arithmetic behind function pointers that the compiler cannot see through, as in a stage's table.
float divide(float a, float b) { return a / b; }
float (*volatile divide_hidden)(float, float) = divide;

constexpr float k_denormal = 1e-40f;

// The worst control register that an app can have. Every bit that switches to flushing or to another rounding is set.
FloatingPointControl hostile_control() {
#if defined(__aarch64__)
  return (3u << 22) | (1u << 24) | (1u << 25);
#else
  return 0x1f80u | (3u << 13) | (1u << 15) | (1u << 6);
#endif
}

TEST(FloatingPoint, DenormalsSurviveInsideAndTheAppsModeComesBack) {
  const FloatingPointControl original = floating_point_control();
  floating_point_restore(hostile_control());
  const float flushed = divide_hidden(k_denormal, 2.0f);
  const float truncated = divide_hidden(2.0f, 3.0f);
  const FloatingPointControl hostile = floating_point_control();

  const FloatingPointControl saved = floating_point_enter();
  const float kept = divide_hidden(k_denormal, 2.0f);
  const float rounded = divide_hidden(2.0f, 3.0f);
  floating_point_restore(saved);
  const FloatingPointControl after = floating_point_control();
  floating_point_restore(original);

  EXPECT_EQ(flushed, 0.0f);  // the app's mode really flushes
  EXPECT_LT(truncated, 0.66666667f);
  EXPECT_EQ(kept, 5e-41f);
  EXPECT_EQ(rounded, 0.66666667f);
  EXPECT_EQ(after, hostile);
}

TEST(FloatingPoint, TrapEnablesAreTheCallersOwn) {
  const FloatingPointControl original = floating_point_control();
  floating_point_enter();
  const FloatingPointControl inside = floating_point_control();
  floating_point_restore(original);
  EXPECT_EQ(inside, original & ~k_floating_point_inexact_modes);
}

TEST(CheckDeathTest, MisuseTraps) {
  ::testing::FLAGS_gtest_death_test_style = "fast";
  SANDGLASS_CHECK(1 + 1 == 2);
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "no death tests in an emulator";
  EXPECT_DEATH(SANDGLASS_CHECK(1 + 1 == 3), "");
}

}  // namespace
}  // namespace sandglass

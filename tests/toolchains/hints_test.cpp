// The Android sample and the system's hints, on stand-ins for a phone with none of these functions (API 24), for one
// with performance hints and a thermal headroom to poll (33), and for one that pushes forecasts and tells of its CPU (36).
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <thread>

#include "android/sample/performance.h"
#include "sample/sand.h"
#include "stand_ins/libandroid.h"

namespace {

constexpr int64_t k_budget_ns = sample::k_budget_ns;
constexpr bool k_hints = ANDROID_LEVEL >= 33, k_pushes = ANDROID_LEVEL >= 36;

// The calls of sand.cpp, at 10 Hz.
struct Hints : testing::Test {
  Hints() {
    the_phone = Phone();
    performance.emplace(sample::k_budget_ns);
    EXPECT_TRUE(sand.create(performance->headroom(0.0)));
    sand.pour(sand.origin());
  }
  sandglass_time_report frames(int count) {
    sandglass_time_report time = {};
    for (int i = 0; i < count; ++i) {
      time = sand.frame(0.1f, performance->headroom(now += 0.1), nullptr, nullptr).time;
      performance->report(time.target_ns, time.elapsed_ns);
    }
    return time;
  }
  std::optional<sample::Performance> performance;
  sample::Sand sand;
  double now = 1.0;
};

TEST_F(Hints, ASessionHasTheBudgetAsItsTargetAndFollowsIt) {
  EXPECT_EQ(the_phone.sessions, k_hints);
  EXPECT_EQ(the_phone.thread, k_hints ? gettid() : 0);
  EXPECT_EQ(the_phone.target_ns, k_hints ? k_budget_ns : 0);
  for (int i = 1; i < 30; ++i) {
    the_phone.hot = i < 15 ? 0.0f : 0.9f;
    const sandglass_time_report time = frames(1);
    EXPECT_EQ(the_phone.reports, k_hints ? i : 0);
    EXPECT_EQ(the_phone.actual_ns, k_hints ? static_cast<int64_t>(time.elapsed_ns) : 0);
    EXPECT_EQ(the_phone.target_ns, k_hints ? static_cast<int64_t>(time.target_ns) : 0);
  }
  EXPECT_NEAR(static_cast<double>(frames(1).target_ns), (k_hints ? 0.5 : 1.0) * k_budget_ns, 1e3);
  performance.reset();
  EXPECT_EQ(the_phone.sessions + the_phone.managers, 0);
  EXPECT_EQ(the_phone.listener, nullptr);
}

TEST_F(Hints, ThePolledForecastIsAskedForOnceASecond) {
  frames(50);
  EXPECT_NEAR(the_phone.polls, k_hints ? 6 : 0, 1);
  for (const float hot : {1.2f, NAN}) {  // what is not known is not cool
    the_phone.hot = hot;
    EXPECT_EQ(frames(11).target_ns, k_hints ? k_budget_ns / 4 : k_budget_ns);
    EXPECT_EQ(sand.rests(), k_hints);
  }
  the_phone.hot = 0.3f;
  EXPECT_EQ(frames(11).target_ns, k_budget_ns);
  EXPECT_FALSE(sand.rests());
}

TEST_F(Hints, APushedForecastReachesTheNextFrame) {
  ASSERT_EQ(the_phone.listener != nullptr, k_pushes);
  if (!k_pushes) return;
  const auto after = [&](float headroom, float forecast) {
    std::thread([=] { the_phone.listener(the_phone.data, headroom, forecast, 10, nullptr, 0); }).join();
    return frames(1).target_ns;
  };
  EXPECT_EQ(after(0.8f, 1.0f), k_budget_ns / 4);
  EXPECT_EQ(after(NAN, NAN), k_budget_ns / 4) << "what is not known is not cool";
  EXPECT_EQ(after(0.5f, NAN), k_budget_ns);
  EXPECT_EQ(after(1.0f, 0.8f), k_budget_ns / 4) << "the worse of the two";
  EXPECT_EQ(frames(11).target_ns, k_budget_ns) << "polling goes on: the phone is cool";
}

TEST_F(Hints, ABusyCpuTakesHalfOfTheBudgetAtMost) {
  for (const float free : {100.0f, 5.0f, 0.0f}) {
    the_phone.cpu_free = free;
    const double share = k_pushes ? std::min(1.0, 0.5 + 0.05 * static_cast<double>(free)) : 1.0;
    EXPECT_NEAR(static_cast<double>(frames(25).target_ns), share * k_budget_ns, 1e3);
  }
}

}  // namespace

// The Android sample and the system's hints, on phones of four ages: with none of these functions (API 24), with a thermal
// headroom to poll (31), with performance hints (33), and with a CPU headroom (36).
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "android/sample/performance.h"
#include "sample/sand.h"

namespace {

constexpr int64_t k_budget_ns = sample::k_budget_ns;

// What the phone answers, and what it was asked.
struct Phone {
  int level = 24;
  float hot = 0.0f, cpu_free = 100.0f;
  int sessions = 0, managers = 0, polls = 0, reports = 0;  // the first two: open ones
  int32_t thread = 0;
  int64_t target_ns = 0, actual_ns = 0;
};
Phone the_phone;

// A function of libandroid.so, and the oldest system that has it.
struct Function {
  const char* name;
  int level;
  void* address;
};
template <class Body>
void* address(Body body) {
  return reinterpret_cast<void*>(+body);
}
const Function k_functions[] = {{"AThermal_acquireManager", 30, address([]() -> void* {
                                   ++the_phone.managers;
                                   return &the_phone;
                                 })},
                                {"AThermal_releaseManager", 30, address([](void*) { --the_phone.managers; })},
                                {"AThermal_getThermalHeadroom", 31, address([](void*, int) {
                                   ++the_phone.polls;
                                   return the_phone.hot;
                                 })},
                                {"APerformanceHint_getManager", 33, address([]() -> void* { return &the_phone; })},
                                {"APerformanceHint_createSession", 33,
                                 address([](void*, const int32_t* threads, size_t size, int64_t target_ns) -> void* {
                                   if (size != 1 || target_ns <= 0) return nullptr;
                                   the_phone.thread = *threads;
                                   the_phone.target_ns = target_ns;
                                   ++the_phone.sessions;
                                   return &the_phone;
                                 })},
                                {"APerformanceHint_updateTargetWorkDuration", 33, address([](void*, int64_t target_ns) {
                                   the_phone.target_ns = target_ns;
                                   return 0;
                                 })},
                                {"APerformanceHint_reportActualWorkDuration", 33, address([](void*, int64_t actual_ns) {
                                   ++the_phone.reports;
                                   the_phone.actual_ns = actual_ns;
                                   return 0;
                                 })},
                                {"APerformanceHint_closeSession", 33, address([](void*) { --the_phone.sessions; })},
                                {"ASystemHealth_getCpuHeadroom", 36, address([](const void*, float* free) {
                                   *free = the_phone.cpu_free;
                                   return 0;
                                 })},
                                {"ASystemHealth_getCpuHeadroomMinIntervalMillis", 36, address([](int64_t* ms) {
                                   *ms = 2000;
                                   return 0;
                                 })}};
void* look_up(const char* name) {
  for (const Function& function : k_functions)
    if (std::string(name) == function.name) return the_phone.level >= function.level ? function.address : nullptr;
  ADD_FAILURE() << name;
  return nullptr;
}

// The calls of sand.cpp, at 10 Hz.
struct Hints : testing::TestWithParam<int> {
  Hints() {
    the_phone = Phone();
    the_phone.level = GetParam();
    performance.emplace(sample::k_budget_ns, look_up);
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
  const bool polls = GetParam() >= 31, hints = GetParam() >= 33;
  std::optional<sample::Performance> performance;
  sample::Sand sand;
  double now = 1.0;
};
INSTANTIATE_TEST_SUITE_P(Levels, Hints, testing::Values(24, 31, 33, 36));

TEST_P(Hints, ASessionHasTheBudgetAsItsTargetAndFollowsIt) {
  EXPECT_EQ(the_phone.sessions, hints);
  EXPECT_EQ(the_phone.thread, hints ? gettid() : 0);
  EXPECT_EQ(the_phone.target_ns, hints ? k_budget_ns : 0);
  for (int i = 1; i < 30; ++i) {
    the_phone.hot = i < 15 ? 0.0f : 0.9f;
    const sandglass_time_report time = frames(1);
    EXPECT_EQ(the_phone.reports, hints ? i : 0);
    EXPECT_EQ(the_phone.actual_ns, hints ? static_cast<int64_t>(time.elapsed_ns) : 0);
    EXPECT_EQ(the_phone.target_ns, hints ? static_cast<int64_t>(time.target_ns) : 0);
  }
  EXPECT_NEAR(static_cast<double>(frames(1).target_ns), (polls ? 0.5 : 1.0) * k_budget_ns, 1e3);
  performance.reset();
  EXPECT_EQ(the_phone.sessions + the_phone.managers, 0);
}

TEST_P(Hints, ThePolledForecastIsAskedForOnceASecond) {
  frames(50);
  EXPECT_NEAR(the_phone.polls, polls ? 6 : 0, 1);
  for (const float hot : {1.2f, NAN}) {  // what is not known is not cool
    the_phone.hot = hot;
    EXPECT_EQ(frames(11).target_ns, polls ? k_budget_ns / 4 : k_budget_ns);
    EXPECT_EQ(sand.rests(), polls);
  }
  the_phone.hot = 0.3f;
  EXPECT_EQ(frames(11).target_ns, k_budget_ns);
  EXPECT_FALSE(sand.rests());
}

TEST_P(Hints, ABusyCpuTakesHalfOfTheBudgetAtMost) {
  for (const float free : {100.0f, 5.0f, 0.0f}) {
    the_phone.cpu_free = free;
    const double share = GetParam() >= 36 ? std::min(1.0, 0.5 + 0.05 * static_cast<double>(free)) : 1.0;
    EXPECT_NEAR(static_cast<double>(frames(25).target_ns), share * k_budget_ns, 1e3);
  }
}

}  // namespace

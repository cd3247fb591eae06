// Android's performance hints, thermal headroom and CPU headroom. All are newer than the oldest system that the sample
// runs on, so they are looked up when the app starts. Where they are missing, the headroom is 1 and no hint is given.
#pragma once

#include <dlfcn.h>
#include <stdint.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace sample {

inline void* in_libandroid(const char* name) {
  static void* const library = dlopen("libandroid.so", RTLD_NOW);
  return library == nullptr ? nullptr : dlsym(library, name);
}

// Make it on the thread of the library's frame: the session is of that thread. An app with a pool adds its threads' ids.
class Performance {
 public:
  explicit Performance(uint64_t budget_ns, void* (*look_up)(const char* name) = in_libandroid)
      : look_up_(look_up), target_(budget_ns) {
    auto* const acquire = find<void*()>("AThermal_acquireManager");      // API 30
    auto* const manager = find<void*()>("APerformanceHint_getManager");  // API 33
    auto* const interval = find<int(int64_t*)>("ASystemHealth_getCpuHeadroomMinIntervalMillis");
    if (acquire != nullptr) thermal_ = acquire();
    if (void* const hints = manager != nullptr ? manager() : nullptr; hints != nullptr) {
      const int32_t thread = gettid();
      auto* const create = find<void*(void*, const int32_t*, size_t, int64_t)>("APerformanceHint_createSession");
      session_ = create(hints, &thread, 1, static_cast<int64_t>(budget_ns));
    }
    int64_t ms = 0;
    if (interval == nullptr || interval(&ms) != 0) cpu_headroom_ = nullptr;
    cpu_interval_ = std::max(1.0, 1e-3 * static_cast<double>(ms));
  }

  ~Performance() {
    if (session_ != nullptr) find<void(void*)>("APerformanceHint_closeSession")(session_);
    if (thermal_ != nullptr) find<void(void*)>("AThermal_releaseManager")(thermal_);
  }

  // The share of the budget that the device can keep up, for frame_input.thermal_headroom. The system may be asked once a
  // second. NaN, which means unknown, leaves a share as it is.
  float headroom(double now_seconds) {
    if (thermal_ != nullptr && thermal_headroom_ != nullptr && now_seconds - asked_ >= 1.0) {
      asked_ = now_seconds;
      // The forecast in five seconds, 1 where throttling becomes severe. Up to 0.7 the share is 1; it falls to a quarter.
      const float hot = thermal_headroom_(thermal_, 5);
      if (!std::isnan(hot)) cool_ = std::clamp(1.0f - (hot - 0.7f) * 2.5f, 0.25f, 1.0f);
    }
    if (cpu_headroom_ != nullptr && now_seconds - cpu_asked_ >= cpu_interval_) {
      cpu_asked_ = now_seconds;
      float free = NAN;  // of 100; at 0 the system has no more to give, and what else the app does waits for the sand
      if (cpu_headroom_(nullptr, &free) == 0 && !std::isnan(free)) cpu_ = std::clamp(0.5f + free / 20, 0.5f, 1.0f);
    }
    return std::min(cool_, cpu_);
  }

  // After every frame: time.target_ns and time.elapsed_ns of its report.
  void report(uint64_t target_ns, uint64_t actual_ns) {
    if (session_ == nullptr || target_ns == 0 || actual_ns == 0) return;
    if (target_ns != target_) update_target_(session_, static_cast<int64_t>(target_ns));
    target_ = target_ns;
    report_actual_(session_, static_cast<int64_t>(actual_ns));
  }

 private:
  template <class Function>
  Function* find(const char* name) {
    return reinterpret_cast<Function*>(look_up_(name));
  }

  void* (*look_up_)(const char* name);
  float (*thermal_headroom_)(void*, int) = find<float(void*, int)>("AThermal_getThermalHeadroom");             // API 31
  int (*cpu_headroom_)(const void*, float*) = find<int(const void*, float*)>("ASystemHealth_getCpuHeadroom");  // API 36
  int (*update_target_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_updateTargetWorkDuration");
  int (*report_actual_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_reportActualWorkDuration");
  void *thermal_ = nullptr, *session_ = nullptr;
  double asked_ = -1.0, cpu_asked_ = -60.0, cpu_interval_ = 1.0;
  float cool_ = 1.0f, cpu_ = 1.0f;
  uint64_t target_;
};

}  // namespace sample

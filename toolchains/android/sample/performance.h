// Android's performance hints, thermal headroom and CPU headroom. All are newer than the oldest system that the sample
// runs on, so they are looked up when the app starts. Where they are missing, the headroom is 1 and no hint is given.
#pragma once

#include <dlfcn.h>
#include <stdint.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sample {

template <class Function>
Function* find(const char* name) {
  static void* const library = dlopen("libandroid.so", RTLD_NOW);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

// Make it on the thread of the library's frame: the session is of that thread. An app with a pool adds its threads' ids.
class Performance {
 public:
  explicit Performance(uint64_t budget_ns) : target_(budget_ns) {
    auto* const acquire = find<void*()>("AThermal_acquireManager");                 // API 30
    auto* const manager = find<void*()>("APerformanceHint_getManager");             // API 33
    auto* const listen = find<Listen>("AThermal_registerThermalHeadroomListener");  // API 36
    auto* const interval = find<int(int64_t*)>("ASystemHealth_getCpuHeadroomMinIntervalMillis");
    if (acquire != nullptr) thermal_ = acquire();
    if (void* const hints = manager != nullptr ? manager() : nullptr; hints != nullptr) {
      const int32_t thread = gettid();
      auto* const create = find<void*(void*, const int32_t*, size_t, int64_t)>("APerformanceHint_createSession");
      session_ = create(hints, &thread, 1, static_cast<int64_t>(budget_ns));
    }
    if (thermal_ != nullptr && listen != nullptr) listens_ = listen(thermal_, &pushed, this) == 0;
    int64_t ms = 0;
    if (interval == nullptr || interval(&ms) != 0) cpu_headroom_ = nullptr;
    cpu_interval_ = std::max(1.0, 1e-3 * static_cast<double>(ms));
  }

  ~Performance() {
    if (session_ != nullptr) find<void(void*)>("APerformanceHint_closeSession")(session_);
    if (listens_) find<Listen>("AThermal_unregisterThermalHeadroomListener")(thermal_, &pushed, this);
    if (thermal_ != nullptr) find<void(void*)>("AThermal_releaseManager")(thermal_);
  }

  // The share of the budget that the device can keep up, for frame_input.thermal_headroom. A pushed forecast counts at
  // once. It comes only where the phone crosses a threshold, so the app also asks, as often as it may: once a second.
  float headroom(double now_seconds) {
    const float news = pushed_.exchange(NAN);
    const bool ask = thermal_ != nullptr && thermal_headroom_ != nullptr && now_seconds - asked_ >= 1.0;
    if (!std::isnan(news) || ask) {
      asked_ = now_seconds;
      warm(std::isnan(news) ? thermal_headroom_(thermal_, 5) : news);  // forecast, seconds
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
  using Pushed = void(void* self, float now, float forecast, int seconds, const void* thresholds, size_t count);
  using Listen = int(void* manager, Pushed*, void* self);

  // On a thread of the system. The worse of the two counts; NaN, which means unknown, does not.
  static void pushed(void* self, float now, float forecast, int, const void*, size_t) {
    static_cast<Performance*>(self)->pushed_ = std::fmax(now, forecast);
  }

  // Android's number is 1 where throttling becomes severe. Up to 0.7 the share is 1; it falls to a quarter at 1. NaN,
  // which means unknown, leaves it as it is.
  void warm(float hot) {
    if (!std::isnan(hot)) cool_ = std::clamp(1.0f - (hot - 0.7f) * 2.5f, 0.25f, 1.0f);
  }

  float (*thermal_headroom_)(void*, int) = find<float(void*, int)>("AThermal_getThermalHeadroom");             // API 31
  int (*cpu_headroom_)(const void*, float*) = find<int(const void*, float*)>("ASystemHealth_getCpuHeadroom");  // API 36
  int (*update_target_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_updateTargetWorkDuration");
  int (*report_actual_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_reportActualWorkDuration");
  void *thermal_ = nullptr, *session_ = nullptr;
  bool listens_ = false;
  double asked_ = -1.0, cpu_asked_ = -60.0, cpu_interval_ = 1.0;
  float cool_ = 1.0f, cpu_ = 1.0f;
  std::atomic<float> pushed_ = NAN;  // what no frame has taken yet
  uint64_t target_;
};

}  // namespace sample

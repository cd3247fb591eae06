// Android's thermal headroom and its performance hints. Both are newer than the oldest system that the sample runs on,
// so they are looked up when the app starts. Where they are missing, the headroom is 1 and no hint is given.
#pragma once

#include <dlfcn.h>
#include <stdint.h>
#include <unistd.h>

#include <algorithm>

namespace sample {

template <class Function>
Function* find(const char* name) {
  static void* const library = dlopen("libandroid.so", RTLD_NOW);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

class Performance {
 public:
  explicit Performance(int64_t frame_ns) {
    auto* const acquire = find<void*()>("AThermal_acquireManager");
    auto* const manager = find<void*()>("APerformanceHint_getManager");  // API 33
    auto* const create = find<void*(void*, const int32_t*, size_t, int64_t)>("APerformanceHint_createSession");
    if (acquire != nullptr) thermal_ = acquire();
    void* const hints = manager != nullptr && create != nullptr ? manager() : nullptr;
    const int32_t thread = gettid();
    if (hints != nullptr) session_ = create(hints, &thread, 1, frame_ns);
  }

  // The share of the budget that the device can keep up. Android's number is 1 where throttling becomes severe; an app
  // may ask for it once a second. Up to 0.7 the share is 1; it falls to a quarter at 1. NaN (unknown) is passed on: the
  // library takes it for 1.
  float headroom(double now_seconds) {
    if (thermal_ == nullptr || thermal_headroom_ == nullptr || now_seconds - asked_ < 1.0) return headroom_;
    asked_ = now_seconds;
    const float hot = thermal_headroom_(thermal_, 5);  // forecast, seconds
    return headroom_ = std::clamp(1.0f - (hot - 0.7f) * 2.5f, 0.25f, 1.0f);
  }

  void report(uint64_t target_ns, uint64_t actual_ns) {
    if (session_ == nullptr || target_ns == 0 || actual_ns == 0) return;
    if (target_ns != target_) update_target_(session_, static_cast<int64_t>(target_ns));
    target_ = target_ns;
    report_actual_(session_, static_cast<int64_t>(actual_ns));
  }

 private:
  float (*thermal_headroom_)(void*, int) = find<float(void*, int)>("AThermal_getThermalHeadroom");  // API 31
  int (*update_target_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_updateTargetWorkDuration");
  int (*report_actual_)(void*, int64_t) = find<int(void*, int64_t)>("APerformanceHint_reportActualWorkDuration");
  void *thermal_ = nullptr, *session_ = nullptr;
  double asked_ = -1.0;
  float headroom_ = 1.0f;
  uint64_t target_ = 0;
};

}  // namespace sample

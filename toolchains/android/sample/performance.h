// Android's thermal headroom and its performance hints. Both are newer than the oldest system that the sample runs on,
// so they are looked up when the app starts. Where they are missing, the headroom is 1 and no hint is given.
#pragma once

#include <dlfcn.h>
#include <stdint.h>
#include <unistd.h>

namespace sample {

class Performance {
 public:
  explicit Performance(int64_t frame_ns) {
    void* library = dlopen("libandroid.so", RTLD_NOW);
    if (library == nullptr) return;
    const auto find = [library](const char* name) { return dlsym(library, name); };
    acquire_thermal_ = reinterpret_cast<void* (*)()>(find("AThermal_acquireManager"));
    thermal_headroom_ = reinterpret_cast<float (*)(void*, int)>(find("AThermal_getThermalHeadroom"));  // API 31
    if (acquire_thermal_ != nullptr) thermal_ = acquire_thermal_();
    const auto manager = reinterpret_cast<void* (*)()>(find("APerformanceHint_getManager"));  // API 33
    const auto create =
        reinterpret_cast<void* (*)(void*, const int32_t*, size_t, int64_t)>(find("APerformanceHint_createSession"));
    update_target_ = reinterpret_cast<int (*)(void*, int64_t)>(find("APerformanceHint_updateTargetWorkDuration"));
    report_actual_ = reinterpret_cast<int (*)(void*, int64_t)>(find("APerformanceHint_reportActualWorkDuration"));
    if (manager == nullptr || create == nullptr || update_target_ == nullptr || report_actual_ == nullptr) return;
    void* of_device = manager();
    const int32_t thread = gettid();
    if (of_device != nullptr) session_ = create(of_device, &thread, 1, frame_ns);
  }

  // The share of the budget that the device can keep up. Android's number is 1 where throttling becomes severe; an app
  // may ask for it once a second. Up to 0.7 the share is 1; it falls to a quarter at 1. NaN (unknown) is passed on: the
  // library takes it for 1.
  float headroom(double now_seconds) {
    if (thermal_ == nullptr || thermal_headroom_ == nullptr) return 1.0f;
    if (now_seconds - asked_ >= 1.0) {
      asked_ = now_seconds;
      const float hot = thermal_headroom_(thermal_, 5);  // forecast, seconds
      const float share = 1.0f - (hot - 0.7f) * 2.5f;
      headroom_ = share > 1.0f ? 1.0f : (share < 0.25f ? 0.25f : share);
    }
    return headroom_;
  }

  void report(uint64_t target_ns, uint64_t actual_ns) {
    if (session_ == nullptr || target_ns == 0 || actual_ns == 0) return;
    if (target_ns != target_) update_target_(session_, static_cast<int64_t>(target_ns));
    target_ = target_ns;
    report_actual_(session_, static_cast<int64_t>(actual_ns));
  }

 private:
  void* (*acquire_thermal_)() = nullptr;
  float (*thermal_headroom_)(void*, int) = nullptr;
  int (*update_target_)(void*, int64_t) = nullptr;
  int (*report_actual_)(void*, int64_t) = nullptr;
  void* thermal_ = nullptr;
  void* session_ = nullptr;
  double asked_ = -1.0;
  float headroom_ = 1.0f;
  uint64_t target_ = 0;
};

}  // namespace sample

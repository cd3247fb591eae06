#pragma once
// What the stand-in for libandroid.so answers, and what it was asked.
#include <stddef.h>
#include <stdint.h>

struct AThermalHeadroomThreshold;
typedef void (*AThermal_HeadroomCallback)(void* data, float headroom, float forecast, int forecast_seconds,
                                          const AThermalHeadroomThreshold* thresholds, size_t count);

struct Phone {
  float hot = 0.0f, cpu_free = 100.0f;
  int sessions = 0, managers = 0, polls = 0, reports = 0;  // the first two: open ones
  int32_t thread = 0;
  int64_t target_ns = 0, actual_ns = 0;
  AThermal_HeadroomCallback listener = nullptr;
  void* data = nullptr;
};
extern Phone the_phone;

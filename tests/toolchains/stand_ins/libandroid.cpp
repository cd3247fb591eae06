// A libandroid.so: of the functions that the Android sample looks up, those that a system of ANDROID_LEVEL has.
#include <errno.h>

#include "libandroid.h"

Phone the_phone;

extern "C" {
#if ANDROID_LEVEL >= 33
using AThermalManager = Phone;
using APerformanceHintManager = Phone;
using APerformanceHintSession = Phone;
AThermalManager* AThermal_acquireManager() {  // API 30
  ++the_phone.managers;
  return &the_phone;
}
void AThermal_releaseManager(AThermalManager*) { --the_phone.managers; }
float AThermal_getThermalHeadroom(AThermalManager*, int) {  // API 31
  ++the_phone.polls;
  return the_phone.hot;
}
APerformanceHintManager* APerformanceHint_getManager() { return &the_phone; }
APerformanceHintSession* APerformanceHint_createSession(APerformanceHintManager*, const int32_t* threads, size_t size,
                                                        int64_t target_ns) {
  if (size != 1 || target_ns <= 0) return nullptr;
  the_phone.thread = *threads;
  the_phone.target_ns = target_ns;
  ++the_phone.sessions;
  return &the_phone;
}
int APerformanceHint_updateTargetWorkDuration(APerformanceHintSession*, int64_t target_ns) {
  if (target_ns <= 0) return EINVAL;
  the_phone.target_ns = target_ns;
  return 0;
}
int APerformanceHint_reportActualWorkDuration(APerformanceHintSession*, int64_t actual_ns) {
  if (actual_ns <= 0) return EINVAL;
  ++the_phone.reports;
  the_phone.actual_ns = actual_ns;
  return 0;
}
void APerformanceHint_closeSession(APerformanceHintSession*) { --the_phone.sessions; }
#endif
#if ANDROID_LEVEL >= 36
int AThermal_registerThermalHeadroomListener(AThermalManager*, AThermal_HeadroomCallback callback, void* data) {
  the_phone.listener = callback;
  the_phone.data = data;
  return 0;
}
int AThermal_unregisterThermalHeadroomListener(AThermalManager*, AThermal_HeadroomCallback callback, void* data) {
  if (the_phone.listener != callback || the_phone.data != data) return EINVAL;
  the_phone.listener = nullptr;
  return 0;
}
struct ACpuHeadroomParams;
int ASystemHealth_getCpuHeadroom(const ACpuHeadroomParams*, float* free) {
  *free = the_phone.cpu_free;
  return 0;
}
int ASystemHealth_getCpuHeadroomMinIntervalMillis(int64_t* ms) {
  *ms = 2000;
  return 0;
}
#endif
}

#pragma once
#include <stdint.h>
typedef int clockid_t;
#define CLOCK_UPTIME_RAW 8
#define CLOCK_THREAD_CPUTIME_ID 16
#ifdef __cplusplus
extern "C"
#endif
    uint64_t
    clock_gettime_nsec_np(clockid_t clock);

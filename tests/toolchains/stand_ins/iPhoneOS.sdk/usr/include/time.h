#pragma once
#include <stdint.h>
#include_next <time.h>
#define CLOCK_UPTIME_RAW 8
#undef CLOCK_THREAD_CPUTIME_ID
#define CLOCK_THREAD_CPUTIME_ID 16
#ifdef __cplusplus
extern "C"
#endif
    uint64_t
    clock_gettime_nsec_np(clockid_t clock);

#pragma once
#include <stdint.h>
typedef int clockid_t;
struct timespec {
  long tv_sec;
  long tv_nsec;
};
#define CLOCK_MONOTONIC 1
#define CLOCK_THREAD_CPUTIME_ID 3
#ifdef __cplusplus
extern "C"
#endif
    int
    clock_gettime(clockid_t clock, struct timespec* time);

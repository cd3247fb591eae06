/* As far as xnnpack.h needs it. */
#pragma once
typedef struct pthreadpool* pthreadpool_t;

/* The part that xnnpack.h needs. */
#pragma once
typedef struct pthreadpool* pthreadpool_t;

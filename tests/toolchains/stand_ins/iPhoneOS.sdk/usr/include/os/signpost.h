#pragma once
// The system's macros expand to calls that check the format at compile time; these check it as printf's.
#include <os/log.h>
#include <stdint.h>
typedef uint64_t os_signpost_id_t;
#define OS_SIGNPOST_ID_EXCLUSIVE ((os_signpost_id_t)0xEEEEB0B5B2B2EEEEull)
#ifdef __cplusplus
extern "C"
#endif
    void
    stand_in_os_signpost(os_log_t log, os_signpost_id_t id, const char* literal_name, const char* format, ...);
#define os_signpost_interval_begin(log, id, name, ...) stand_in_os_signpost(log, id, "" name "", "" __VA_ARGS__)
#define os_signpost_interval_end(log, id, name) stand_in_os_signpost(log, id, "" name "", "")

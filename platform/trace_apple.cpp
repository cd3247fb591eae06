// Signposts: intervals that are called "unit" and have the work unit's name as their message, because a signpost's own
// name must be a literal. Units never nest, so the exclusive identifier is enough. The log object is the hook's `user`,
// which saves a global.
#include <os/log.h>
#include <os/signpost.h>

#include "sandglass/sandglass.h"

namespace sandglass {
namespace {

void begin_interval(void* user, const char* name) {
  os_signpost_interval_begin(static_cast<os_log_t>(user), OS_SIGNPOST_ID_EXCLUSIVE, "unit", "%{public}s", name);
}
void end_interval(void* user, const char*) {
  os_signpost_interval_end(static_cast<os_log_t>(user), OS_SIGNPOST_ID_EXCLUSIVE, "unit");
}

}  // namespace
}  // namespace sandglass

sandglass_trace sandglass_trace_system(void) {
  return {sandglass::begin_interval, sandglass::end_interval, os_log_create("sandglass", "frame")};
}

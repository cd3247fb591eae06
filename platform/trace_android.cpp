// ATrace: a section costs a load and a branch while nobody records. In a file of its own, so that an app which does not
// ask for it need not link libandroid.
#include <android/trace.h>

#include "sandglass/sandglass.h"

namespace sandglass {
namespace {

void begin_section(void*, const char* name) { ATrace_beginSection(name); }
void end_section(void*, const char*) { ATrace_endSection(); }

}  // namespace
}  // namespace sandglass

sandglass_trace sandglass_trace_system(void) { return {sandglass::begin_section, sandglass::end_section, nullptr}; }

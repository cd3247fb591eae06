// Sections of ATrace, which cost a load and a branch while nobody records. They have a file of their own, so that an
// app which does not use them need not link libandroid.
#include <android/trace.h>

#include "sandglass/sandglass.h"

namespace sandglass {
namespace {

void begin_section(void*, const char* name) { ATrace_beginSection(name); }
void end_section(void*, const char*) { ATrace_endSection(); }

}  // namespace
}  // namespace sandglass

sandglass_trace sandglass_trace_system(void) { return {sandglass::begin_section, sandglass::end_section, nullptr}; }

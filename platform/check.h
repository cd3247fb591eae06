// SANDGLASS_CHECK(condition): misuse by the calling code traps here, in every build. Checks are a compare and a branch
// at the edges (a frame, a stage, a unit), never inside a kernel's loop, so there is nothing to gain by switching them
// off; and they print nothing, because the library brings no stdio. The debugger or the crash report names the line.
#pragma once

#define SANDGLASS_CHECK(condition) ((condition) ? (void)0 : __builtin_trap())

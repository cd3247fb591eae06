// SANDGLASS_CHECK(condition) traps where code inside the library is used wrongly, in every build. A check costs a
// compare and a branch, once a frame, a stage or a work unit and never inside a kernel's loop, so switching it off
// would gain nothing. It prints nothing, because the library does not link stdio. The debugger or the crash report
// names the line.
#pragma once

#define SANDGLASS_CHECK(condition) ((condition) ? (void)0 : __builtin_trap())

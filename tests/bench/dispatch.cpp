// Prints in one line what a CPU model offers and which tables of kernels are chosen for it; dispatch.sh compares the
// line. The argument `sdot` is the control: it executes one dot-product instruction, which must end in SIGILL where the
// model has none.
#include <cstdio>
#include <cstring>

#include "kernels/int8.h"
#include "kernels/kernels.h"
#include "platform/cpu_features.h"

int main(int count, char** arguments) {
  if (count > 1 && std::strcmp(arguments[1], "sdot") == 0) {
    __asm__ volatile(".arch armv8.2-a+dotprod\n sdot v0.4s, v1.16b, v2.16b" ::: "v0");
    return std::puts("sdot executed") < 0;
  }
  const sandglass::CpuFeatures cpu = sandglass::cpu_features();
  std::printf("neon %d dotprod %d i8mm %d table %s int8 %s\n", cpu.neon, cpu.dotprod, cpu.i8mm,
              sandglass_isa_name(sandglass::select_kernels(SANDGLASS_ISA_AUTOMATIC)->isa),
              sandglass_isa_name(sandglass::select_int8_kernels(SANDGLASS_ISA_AUTOMATIC)->isa));
}

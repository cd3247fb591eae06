// 64-bit ARM under Linux and Android: the kernel's auxiliary vector lists what user space may use. On old kernels,
// reading the ID registers instead would trap.
#if defined(__aarch64__) && defined(__linux__)

#include "platform/cpu_features.h"

#include <sys/auxv.h>

namespace sandglass {
namespace {

// Numbers of the kernel's ABI (linux/auxvec.h, asm/hwcap.h). They stand here because old C libraries lack the newer
// names.
constexpr unsigned long k_auxiliary_hwcap = 16;
constexpr unsigned long k_auxiliary_hwcap2 = 26;
constexpr unsigned long k_hwcap_asimd = 1ul << 1;
constexpr unsigned long k_hwcap_asimddp = 1ul << 20;
constexpr unsigned long k_hwcap2_i8mm = 1ul << 13;

}  // namespace

CpuFeatures cpu_features() {
  const unsigned long hwcap = getauxval(k_auxiliary_hwcap);
  const unsigned long hwcap2 = getauxval(k_auxiliary_hwcap2);
  CpuFeatures features;
  features.neon = (hwcap & k_hwcap_asimd) != 0;
  features.dotprod = (hwcap & k_hwcap_asimddp) != 0;
  features.i8mm = (hwcap2 & k_hwcap2_i8mm) != 0;
  return features;
}

}  // namespace sandglass

#endif

// Picks a table of kernels: the fastest that both this build and this CPU have, or the one asked for. Products of bytes
// are of no use to these kernels, so NEON_DOTPROD and NEON_I8MM get the NEON table where the CPU has those
// instructions.
#include "kernels/kernels.h"
#include "platform/cpu_features.h"

namespace sandglass {

namespace simd_scalar {
extern const Kernels k_table;
}
#if defined(SANDGLASS_HAVE_AVX2)
namespace simd_avx2 {
extern const Kernels k_table;
}
#endif
#if defined(SANDGLASS_HAVE_AVX512)
namespace simd_avx512 {
extern const Kernels k_table;
}
#endif
#if defined(SANDGLASS_HAVE_NEON)
namespace simd_neon {
extern const Kernels k_table;
}
#endif

const Kernels* select_kernels(sandglass_isa isa) {
  if (isa == SANDGLASS_ISA_SCALAR) return &simd_scalar::k_table;  // without asking the CPU, which is slow
  const CpuFeatures cpu = cpu_features();
  (void)cpu;
  const bool automatic = isa == SANDGLASS_ISA_AUTOMATIC;
#if defined(SANDGLASS_HAVE_AVX512)
  if ((automatic || isa == SANDGLASS_ISA_AVX512) && cpu.avx512f && cpu.avx512bw && cpu.avx512dq && cpu.avx512vl)
    return &simd_avx512::k_table;
#endif
#if defined(SANDGLASS_HAVE_AVX2)
  if ((automatic || isa == SANDGLASS_ISA_AVX2) && cpu.avx2) return &simd_avx2::k_table;
#endif
#if defined(SANDGLASS_HAVE_NEON)
  const bool asked = isa == SANDGLASS_ISA_NEON || (isa == SANDGLASS_ISA_NEON_DOTPROD && cpu.dotprod) ||
                     (isa == SANDGLASS_ISA_NEON_I8MM && cpu.i8mm);
  if ((automatic || asked) && cpu.neon) return &simd_neon::k_table;
#endif
  return automatic ? &simd_scalar::k_table : nullptr;
}

}  // namespace sandglass

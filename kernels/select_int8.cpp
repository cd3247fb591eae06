// Picks a table of int8 kernels: the fastest that both this build and this CPU have, or the one asked for. AVX512 means
// AVX-512 with VNNI; a CPU that has the one without the other runs the AVX2 table.
#include "kernels/int8.h"
#include "platform/cpu_features.h"

namespace sandglass {

#define SANDGLASS_INT8_TABLE(name)    \
  namespace int8_##name {             \
    extern const Int8Kernels k_table; \
  }
SANDGLASS_INT8_TABLE(scalar)
#if defined(SANDGLASS_HAVE_AVX512)
SANDGLASS_INT8_TABLE(avx2)
SANDGLASS_INT8_TABLE(avx512)
#endif
#if defined(SANDGLASS_HAVE_NEON)
SANDGLASS_INT8_TABLE(neon)
SANDGLASS_INT8_TABLE(neon_dotprod)
SANDGLASS_INT8_TABLE(neon_i8mm)
#endif
#undef SANDGLASS_INT8_TABLE

const Int8Kernels* select_int8_kernels(sandglass_isa isa) {
  const CpuFeatures cpu = cpu_features();
  (void)cpu;
  const bool automatic = isa == SANDGLASS_ISA_AUTOMATIC;
#if defined(SANDGLASS_HAVE_AVX512)
  if ((automatic || isa == SANDGLASS_ISA_AVX512) && cpu.avx512f && cpu.avx512bw && cpu.avx512dq && cpu.avx512vl &&
      cpu.avx512vnni)
    return &int8_avx512::k_table;
  if ((automatic || isa == SANDGLASS_ISA_AVX2) && cpu.avx2) return &int8_avx2::k_table;
#endif
#if defined(SANDGLASS_HAVE_NEON)
  if ((automatic || isa == SANDGLASS_ISA_NEON_I8MM) && cpu.i8mm) return &int8_neon_i8mm::k_table;
  if ((automatic || isa == SANDGLASS_ISA_NEON_DOTPROD) && cpu.dotprod) return &int8_neon_dotprod::k_table;
  if ((automatic || isa == SANDGLASS_ISA_NEON) && cpu.neon) return &int8_neon::k_table;
#endif
  return automatic || isa == SANDGLASS_ISA_SCALAR ? &int8_scalar::k_table : nullptr;
}

}  // namespace sandglass

// Picks a table of kernels: the fastest that both this build and this CPU have, or the one asked for. Products of bytes
// are of no use to these kernels, so NEON_DOTPROD and NEON_I8MM get the NEON table where the CPU has those
// instructions.
#include "kernels/kernels.h"
#include "platform/cpu_features.h"

namespace sandglass {

#define SANDGLASS_TABLES_OF(set)                                            \
  namespace simd_##set {                                                    \
    extern const Kernels k_table, k_sand_table, k_pile_table, k_cast_table; \
  }
SANDGLASS_TABLES_OF(scalar)
#if defined(SANDGLASS_HAVE_AVX512)
SANDGLASS_TABLES_OF(avx2)
SANDGLASS_TABLES_OF(avx512)
#define SANDGLASS_TABLES(table) \
  { &simd_scalar::table, nullptr, &simd_avx2::table, &simd_avx512::table, nullptr }
#elif defined(SANDGLASS_HAVE_NEON)
SANDGLASS_TABLES_OF(neon)
#define SANDGLASS_TABLES(table) \
  { &simd_scalar::table, &simd_neon::table, nullptr, nullptr, nullptr }
#elif defined(SANDGLASS_HAVE_WASM)
SANDGLASS_TABLES_OF(wasm)
#define SANDGLASS_TABLES(table) \
  { &simd_scalar::table, nullptr, nullptr, nullptr, &simd_wasm::table }
#else
#define SANDGLASS_TABLES(table) \
  { &simd_scalar::table, nullptr, nullptr, nullptr, nullptr }
#endif
#undef SANDGLASS_TABLES_OF

namespace {

// The tables of one user for SCALAR, NEON, AVX2, AVX512 and WASM, in this order; null where this build lacks one.
struct Tables {
  const Kernels* of[5];
};

// Named constants, so that each has a section of its own and the linker drops those that an app does not use.
constexpr Tables k_all = {SANDGLASS_TABLES(k_table)};
constexpr Tables k_of_sand = {SANDGLASS_TABLES(k_sand_table)};
constexpr Tables k_of_piles = {SANDGLASS_TABLES(k_pile_table)};
constexpr Tables k_of_casts = {SANDGLASS_TABLES(k_cast_table)};

const Kernels* select(const Tables& tables, sandglass_isa isa) {
  if (isa == SANDGLASS_ISA_SCALAR) return tables.of[0];  // without asking the CPU, which is slow
  const CpuFeatures cpu = cpu_features();
  const bool automatic = isa == SANDGLASS_ISA_AUTOMATIC;
  const Kernels *neon = tables.of[1], *avx2 = tables.of[2], *avx512 = tables.of[3], *wasm = tables.of[4];
  if (avx512 != nullptr && (automatic || isa == SANDGLASS_ISA_AVX512) && cpu.avx512f && cpu.avx512bw && cpu.avx512dq &&
      cpu.avx512vl)
    return avx512;
  if (avx2 != nullptr && (automatic || isa == SANDGLASS_ISA_AVX2) && cpu.avx2) return avx2;
  const bool asked = isa == SANDGLASS_ISA_NEON || (isa == SANDGLASS_ISA_NEON_DOTPROD && cpu.dotprod) ||
                     (isa == SANDGLASS_ISA_NEON_I8MM && cpu.i8mm);
  if (neon != nullptr && (automatic || asked) && cpu.neon) return neon;
  if (wasm != nullptr && (automatic || isa == SANDGLASS_ISA_WASM) && cpu.wasm) return wasm;
  return automatic ? tables.of[0] : nullptr;
}

}  // namespace

const Kernels* select_kernels(sandglass_isa isa) { return select(k_all, isa); }
const Kernels* select_sand_kernels(sandglass_isa isa) { return select(k_of_sand, isa); }
const Kernels* select_pile_kernels(sandglass_isa isa) { return select(k_of_piles, isa); }
const Kernels* select_cast_kernels(sandglass_isa isa) { return select(k_of_casts, isa); }

}  // namespace sandglass

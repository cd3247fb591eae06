// Picks a table of int8 kernels: the fastest that both this build and this CPU have, or the one asked for. AVX512 here
// means AVX-512 with VNNI. AUTOMATIC gives a CPU without VNNI the AVX2 table.
#include "kernels/int8.h"
#include "platform/cpu_features.h"

namespace sandglass {

#define SANDGLASS_INT8_TABLE(name)                                   \
  namespace int8_##name {                                            \
    extern const Int8Kernels k_table, k_shadow_table, k_light_table; \
  }
SANDGLASS_INT8_TABLE(scalar)
#if defined(SANDGLASS_HAVE_AVX512)
SANDGLASS_INT8_TABLE(avx2)
SANDGLASS_INT8_TABLE(avx512)
#define SANDGLASS_INT8_TABLES(table) \
  { &int8_scalar::table, nullptr, &int8_avx2::table, &int8_avx512::table, nullptr, nullptr, nullptr }
#elif defined(SANDGLASS_HAVE_NEON)
SANDGLASS_INT8_TABLE(neon)
SANDGLASS_INT8_TABLE(neon_dotprod)
SANDGLASS_INT8_TABLE(neon_i8mm)
#define SANDGLASS_INT8_TABLES(table)                                                                             \
  {                                                                                                              \
    &int8_scalar::table, &int8_neon::table, nullptr, nullptr, &int8_neon_dotprod::table, &int8_neon_i8mm::table, \
        nullptr                                                                                                  \
  }
#elif defined(SANDGLASS_HAVE_WASM)
SANDGLASS_INT8_TABLE(wasm)
#define SANDGLASS_INT8_TABLES(table) \
  { &int8_scalar::table, nullptr, nullptr, nullptr, nullptr, nullptr, &int8_wasm::table }
#else
#define SANDGLASS_INT8_TABLES(table) \
  { &int8_scalar::table, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr }
#endif
#undef SANDGLASS_INT8_TABLE

namespace {

// One pointer for each sandglass_isa from SCALAR on, in its order; null where this build lacks the table.
struct Tables {
  const Int8Kernels* of[7];
};

// Named constants, so that each has a section of its own and the linker drops those that an app does not use.
constexpr Tables k_all = {SANDGLASS_INT8_TABLES(k_table)};
constexpr Tables k_of_shadows = {SANDGLASS_INT8_TABLES(k_shadow_table)};
constexpr Tables k_of_light = {SANDGLASS_INT8_TABLES(k_light_table)};

const Int8Kernels* select(const Tables& tables, sandglass_isa isa) {
  if (isa == SANDGLASS_ISA_SCALAR) return tables.of[0];  // without asking the CPU, which is slow
  const CpuFeatures cpu = cpu_features();
  const bool runs[7] = {
      true,        cpu.neon, cpu.avx2, cpu.avx512f && cpu.avx512bw && cpu.avx512dq && cpu.avx512vl && cpu.avx512vnni,
      cpu.dotprod, cpu.i8mm, cpu.wasm};
  // The fastest first.
  constexpr sandglass_isa k_order[7] = {SANDGLASS_ISA_AVX512,       SANDGLASS_ISA_AVX2, SANDGLASS_ISA_NEON_I8MM,
                                        SANDGLASS_ISA_NEON_DOTPROD, SANDGLASS_ISA_NEON, SANDGLASS_ISA_WASM,
                                        SANDGLASS_ISA_SCALAR};
  for (const sandglass_isa candidate : k_order) {
    const Int8Kernels* table = tables.of[candidate - SANDGLASS_ISA_SCALAR];
    if (table != nullptr && runs[candidate - SANDGLASS_ISA_SCALAR] &&
        (isa == SANDGLASS_ISA_AUTOMATIC || isa == candidate))
      return table;
  }
  return nullptr;
}

}  // namespace

const Int8Kernels* select_int8_kernels(sandglass_isa isa) { return select(k_all, isa); }
const Int8Kernels* select_shadow_kernels(sandglass_isa isa) { return select(k_of_shadows, isa); }
const Int8Kernels* select_light_kernels(sandglass_isa isa) { return select(k_of_light, isa); }

}  // namespace sandglass

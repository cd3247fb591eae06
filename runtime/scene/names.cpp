// The version, and the names of statuses, instruction sets, quality levels and stages.
#include "kernels/kernels.h"
#include "runtime/sand/solver.h"
#include "sandglass/sandglass.h"

uint32_t sandglass_version() { return SANDGLASS_VERSION; }

const char* sandglass_status_name(sandglass_status status) {
  switch (status) {
    case SANDGLASS_OK:
      return "SANDGLASS_OK";
    case SANDGLASS_ERROR_INVALID_ARGUMENT:
      return "SANDGLASS_ERROR_INVALID_ARGUMENT.";
    case SANDGLASS_ERROR_MEMORY_TOO_SMALL:
      return "SANDGLASS_ERROR_MEMORY_TOO_SMALL.";
    case SANDGLASS_ERROR_MEMORY_ALIGNMENT:
      return "SANDGLASS_ERROR_MEMORY_ALIGNMENT.";
    case SANDGLASS_ERROR_CAPACITY:
      return "SANDGLASS_ERROR_CAPACITY";
    case SANDGLASS_ERROR_UNSUPPORTED:
      return "SANDGLASS_ERROR_UNSUPPORTED.";
    case SANDGLASS_ERROR_REPLAY:
      return "SANDGLASS_ERROR_REPLAY";
    default:
      return "unknown status";
  }
}

const char* sandglass_isa_name(sandglass_isa isa) {
  switch (isa) {
    case SANDGLASS_ISA_AUTOMATIC:
      return "automatic";
    case SANDGLASS_ISA_SCALAR:
      return "scalar";
    case SANDGLASS_ISA_NEON:
      return "neon";
    case SANDGLASS_ISA_AVX2:
      return "avx2";
    case SANDGLASS_ISA_AVX512:
      return "avx512";
    case SANDGLASS_ISA_NEON_DOTPROD:
      return "neon_dotprod";
    case SANDGLASS_ISA_NEON_I8MM:
      return "neon_i8mm";
    case SANDGLASS_ISA_WASM:
      return "wasm";
    default:
      return nullptr;
  }
}

int32_t sandglass_isa_available(sandglass_isa isa) { return sandglass::select_sand_kernels(isa) != nullptr ? 1 : 0; }

const char* sandglass_stage_name(uint32_t stage) {
  constexpr const char* k_names[] = {"granular",
#define STAGE(name, title, share, units) title,
#include "runtime/frame/capabilities.inc"
                                     "refine", "output"};
  static_assert(sizeof k_names / sizeof *k_names == SANDGLASS_STAGE_COUNT);
  return stage < SANDGLASS_STAGE_COUNT ? k_names[stage] : nullptr;
}

const char* sandglass_level_name(uint32_t level) {
  return level < SANDGLASS_LEVEL_COUNT ? sandglass::k_ladder[level].reported.name : nullptr;
}

const sandglass_level* sandglass_level_describe(uint32_t level) {
  return level < SANDGLASS_LEVEL_COUNT ? &sandglass::k_ladder[level].reported : nullptr;
}

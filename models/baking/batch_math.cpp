// Picks the fastest instruction set that this CPU has.
#include "models/baking/batch_math.h"

namespace sandglass::host {

namespace batch_baseline {
extern const BatchMath k_batch_math;
}
#if defined(SANDGLASS_BATCH_X86)
namespace batch_avx2 {
extern const BatchMath k_batch_math;
}
namespace batch_avx512 {
extern const BatchMath k_batch_math;
}
#endif

uint64_t batch_scratch(uint32_t width, uint32_t layers, uint32_t samples) {
  return uint64_t{width} * samples * (layers + 3) + samples;
}

const BatchMath& batch_math() {
#if defined(SANDGLASS_BATCH_X86)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return batch_avx512::k_batch_math;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return batch_avx2::k_batch_math;
#endif
  return batch_baseline::k_batch_math;
}

}  // namespace sandglass::host

// WebAssembly: a module that holds 128-bit SIMD does not load where a browser lacks it, so what was compiled in runs.
#include "platform/cpu_features.h"

namespace sandglass {

CpuFeatures cpu_features() {
  CpuFeatures features;
#if defined(__wasm_simd128__)
  features.wasm = true;
#endif
  return features;
}

}  // namespace sandglass

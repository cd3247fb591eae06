// What this processor and this operating system can run. It is asked when kernels are chosen, which is when something
// is created and never in a frame. A flag means "may be used": the instructions exist and the system saves the
// registers that they need. The flags of other architectures are false.
#pragma once

namespace sandglass {

struct CpuFeatures {
  bool avx2 = false;
  bool fma = false;
  bool avx512f = false;
  bool avx512bw = false;
  bool avx512dq = false;
  bool avx512vl = false;
  bool avx512vnni = false;
  bool neon = false;     // Advanced SIMD
  bool dotprod = false;  // SDOT, UDOT
  bool i8mm = false;     // SMMLA, UMMLA, USMMLA
  bool wasm = false;     // 128-bit SIMD of WebAssembly
};

CpuFeatures cpu_features();

}  // namespace sandglass

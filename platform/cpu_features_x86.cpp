// x86: CPUID says what the processor has, XGETBV which registers the operating system saves. Both must agree: where the
// system does not save the wide registers, their instructions are illegal.
#if defined(__x86_64__) || defined(__i386__)

#include "platform/cpu_features.h"

#include <cpuid.h>
#include <stdint.h>

namespace sandglass {
namespace {

// Bits of XCR0. AVX: the SSE and the AVX registers. AVX-512: also the masks, the upper halves of ZMM0-15, and ZMM16-31.
constexpr uint64_t k_state_avx = (1u << 1) | (1u << 2);
constexpr uint64_t k_state_avx512 = k_state_avx | (1u << 5) | (1u << 6) | (1u << 7);

// Inline assembly because the _xgetbv intrinsic needs -mxsave for the whole file.
uint64_t read_xcr0() {
  uint32_t low = 0;
  uint32_t high = 0;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return (static_cast<uint64_t>(high) << 32) | low;
}

bool has_bit(uint32_t word, int bit) { return ((word >> bit) & 1u) != 0; }

}  // namespace

CpuFeatures cpu_features() {
  CpuFeatures features;
  uint32_t eax = 0;
  uint32_t ebx = 0;
  uint32_t ecx = 0;
  uint32_t edx = 0;
  if (__get_cpuid(1, &eax, &ebx, &ecx, &edx) == 0) return features;
  const bool has_fma = has_bit(ecx, 12);
  const bool has_osxsave = has_bit(ecx, 27);  // without it XGETBV is an illegal instruction
  if (!has_osxsave || !has_bit(ecx, 28)) return features;
  if (__get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx) == 0) return features;

  const uint64_t state = read_xcr0();
  if ((state & k_state_avx) == k_state_avx) {
    features.avx2 = has_bit(ebx, 5);
    features.fma = has_fma;
  }
  if ((state & k_state_avx512) == k_state_avx512) {
    features.avx512f = has_bit(ebx, 16);
    features.avx512dq = has_bit(ebx, 17);
    features.avx512bw = has_bit(ebx, 30);
    features.avx512vl = has_bit(ebx, 31);
    features.avx512vnni = has_bit(ecx, 11);
  }
  return features;
}

}  // namespace sandglass

#endif

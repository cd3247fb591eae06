// Measures the machine's peak with independent chains of vector multiply-adds, and its bandwidth with a sum over a
// large array. The best of several rounds counts. On x86 the arithmetic loop has a copy for each vector width, and the
// widest one that the processor supports runs.
#include "tests/laboratory/machine_peak.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

namespace sandglass::host {

namespace {

// Enough independent chains to hide a latency of 4 at 2 a cycle, and few enough for 16 registers.
constexpr int k_chains = 12;
constexpr int k_repeats = 200'000;
constexpr int k_rounds = 12;
constexpr size_t k_array_bytes = size_t{256} << 20;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Returns the lanes of a vector, so that the caller can count the work. `values` keeps the arithmetic from being
// optimised away.
#define SANDGLASS_MULTIPLY_ADD(name, bytes)                                           \
  int name(float* values) {                                                           \
    typedef float Wide __attribute__((vector_size(bytes)));                           \
    constexpr int lanes = bytes / static_cast<int>(sizeof(float));                    \
    Wide chain[k_chains];                                                             \
    for (int c = 0; c < k_chains; ++c) chain[c] = Wide{} + values[c];                 \
    for (int repeat = 0; repeat < k_repeats; ++repeat)                                \
      for (int c = 0; c < k_chains; ++c) chain[c] = chain[c] * 0.999f + 0.001f;       \
    for (int c = 0; c < k_chains; ++c) values[c] = chain[c][0] + chain[c][lanes - 1]; \
    return lanes;                                                                     \
  }
#if defined(__GNUC__) && !defined(__clang__)
#define SANDGLASS_FUSED optimize("O3", "fp-contract=fast"), noinline
#else
#define SANDGLASS_FUSED noinline
#endif
__attribute__((SANDGLASS_FUSED)) SANDGLASS_MULTIPLY_ADD(multiply_add_128, 16)
#if defined(__x86_64__)
    __attribute__((SANDGLASS_FUSED, target("avx2,fma"))) SANDGLASS_MULTIPLY_ADD(multiply_add_256, 32)
        __attribute__((SANDGLASS_FUSED, target("avx512f"))) SANDGLASS_MULTIPLY_ADD(multiply_add_512, 64)
#endif

            int multiply_add(float* values) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return multiply_add_512(values);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return multiply_add_256(values);
#endif
  return multiply_add_128(values);
}

// Returns how many multiply-adds of bytes it did. It is assembly, because compilers move the accumulators of the
// builtins about.
#if defined(__x86_64__)
__attribute__((noinline, target("avx512f"))) double dot_bytes_512() {
  typedef int Wide __attribute__((vector_size(64)));
  Wide chain[k_chains] = {}, a = {}, b = {};
  for (int repeat = 0; repeat < k_repeats; ++repeat)
    for (int c = 0; c < k_chains; ++c) __asm__ volatile("vpdpbusd %2, %1, %0" : "+v"(chain[c]) : "v"(a), "v"(b));
  return 64.0 * k_chains * k_repeats;
}
double dot_bytes() { return __builtin_cpu_supports("avx512vnni") ? dot_bytes_512() : 0.0; }
#else
double dot_bytes() { return 0.0; }
#endif

}  // namespace

MachinePeak measure_machine_peak() {
  MachinePeak peak;
  float values[k_chains];
  std::fill_n(values, k_chains, 1.0f);
  for (int round = 0; round < k_rounds; ++round) {
    const double from = seconds_now();
    const double macs = static_cast<double>(multiply_add(values)) * k_chains * k_repeats;
    peak.f32_gmac_per_s = std::max(peak.f32_gmac_per_s, macs / (seconds_now() - from) * 1e-9);
  }
  for (int round = 0; round < k_rounds; ++round) {
    const double from = seconds_now(), macs = dot_bytes();
    peak.int8_gmac_per_s = std::max(peak.int8_gmac_per_s, macs / (seconds_now() - from) * 1e-9);
  }
  std::vector<uint64_t> array(k_array_bytes / sizeof(uint64_t), 1);
  volatile uint64_t kept = 0;
  for (int round = 0; round < k_rounds; ++round) {
    const double from = seconds_now();
    uint64_t sums[8] = {};
    for (size_t i = 0; i < array.size(); i += 8)
      for (size_t lane = 0; lane < 8; ++lane) sums[lane] += array[i + lane];
    for (const uint64_t sum : sums) kept = kept + sum;
    peak.read_gb_per_s =
        std::max(peak.read_gb_per_s, static_cast<double>(k_array_bytes) / (seconds_now() - from) * 1e-9);
  }
  return peak;
}

}  // namespace sandglass::host

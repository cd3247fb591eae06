// The floating-point environment of a frame: round to nearest even, denormals kept. Engines and audio code often leave
// flush-to-zero on, and the same scene would then end in other bits. The frame call saves the app's control register,
// sets this mode and restores the register where it returns: ExactFloatingPoint, as long as it lives.
//
// Trap enables stay as the app (or a test) set them. The sticky exception flags are part of the register on x86 and
// come back as they were. On ARM they are in another register (FPSR), and those that the frame raised stay raised.
//
// A compiler does not know that arithmetic depends on this register. Keep it in a function that does no
// floating-point work itself, and do the work in a function that is not inlined (one called through a stage's table is
// not).
#pragma once

#include <stdint.h>

#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#endif

namespace sandglass {

using FloatingPointControl = uint64_t;

#if defined(__x86_64__) || defined(__i386__)

inline FloatingPointControl floating_point_control() { return _mm_getcsr(); }
inline void floating_point_restore(FloatingPointControl saved) { _mm_setcsr(static_cast<uint32_t>(saved)); }

// Bits of MXCSR: 13-14 rounding mode, 15 flush results to zero, 6 denormal inputs are zero.
constexpr FloatingPointControl k_floating_point_inexact_modes = (3u << 13) | (1u << 15) | (1u << 6);

#elif defined(__aarch64__)

inline FloatingPointControl floating_point_control() {
  uint64_t control = 0;
  __asm__ volatile("mrs %0, fpcr" : "=r"(control)::"memory");
  return control;
}
inline void floating_point_restore(FloatingPointControl saved) {
  __asm__ volatile("msr fpcr, %0" ::"r"(saved) : "memory");
}

// Bits of FPCR: 22-23 rounding mode, 24 flush to zero, 19 flush half precision, 25 default NaN; on newer cores also 0
// flush inputs, 1 alternate handling of denormals and NaN, 2 scalar operations keep upper elements.
constexpr FloatingPointControl k_floating_point_inexact_modes =
    (3u << 22) | (1u << 24) | (1u << 19) | (1u << 25) | (1u << 0) | (1u << 1) | (1u << 2);

#elif defined(__wasm__)

// WebAssembly has no such register: it always rounds to nearest even and keeps denormals.
inline FloatingPointControl floating_point_control() { return 0; }
inline void floating_point_restore(FloatingPointControl) {}
constexpr FloatingPointControl k_floating_point_inexact_modes = 0;

#else
#error "Sandglass knows the floating-point control register of x86 and 64-bit ARM only; add this processor's here."
#endif

inline FloatingPointControl floating_point_enter() {
  const FloatingPointControl saved = floating_point_control();
  floating_point_restore(saved & ~k_floating_point_inexact_modes);
  return saved;
}

struct ExactFloatingPoint {
  ExactFloatingPoint() = default;
  ExactFloatingPoint(const ExactFloatingPoint&) = delete;
  ~ExactFloatingPoint() { floating_point_restore(saved); }
  const FloatingPointControl saved = floating_point_enter();
};

}  // namespace sandglass

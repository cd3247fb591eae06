// Elementary functions without libm, because its results differ between C libraries and instruction sets: only + - * /
// and sqrt, which IEEE 754 fixes to the bit, in an order that the source fixes. Everything in double; set-up code, not
// kernels.
//
//   sin_cos_turns   angle in turns (1 = a full circle)    error below 3e-16 absolute
//   arc_tangent2    like atan2, in radians                error below 5e-16 absolute
//   cube_root       x >= 0                                error below 4e-16 relative
//   exponential     0 below -700, e^700 above 700         error below 1e-15 relative
//   logarithm       of x > 0, natural                     error below 1e-15 relative, or 1e-16 absolute
//   floor_index     largest integer not above x           exact for |x| < 2^62; beyond, and for NaN, 2^62 or -2^62
//
// tests/solid/math_test.cpp holds these bounds against libm.
#pragma once

#include <cstdint>
#include <cstring>

namespace sandglass {

constexpr double k_pi = 3.14159265358979323846;

inline double square_root(double x) { return __builtin_sqrt(x); }
inline double absolute(double x) { return __builtin_fabs(x); }
inline double square_of(const double v[3]) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// Written with a cast because the floor of baseline x86-64 is a library call.
// It bounds the number itself: to_whole would do so a second time, in every function of this file.
constexpr int64_t floor_index(double x) {
  constexpr double k_limit = 0x1p62;
  const double below = x < k_limit ? x : k_limit, bounded = below > -k_limit ? below : -k_limit;
  const int64_t i = static_cast<int64_t>(bounded);
  return i - (static_cast<double>(i) > bounded ? 1 : 0);
}

inline int64_t ceiling_index(double x) { return -floor_index(-x); }

struct SinCos {
  double sin, cos;
};

// Whole turns drop out exactly, then eighths of a turn remain around the nearest quarter; |x| <= pi/4 for the two
// series, whose first omitted terms are below 1e-19.
inline SinCos sin_cos_turns(double turns) {
  const double fraction = turns - static_cast<double>(floor_index(turns));
  const int64_t quarter = floor_index(4 * fraction + 0.5);
  const double x = 2 * k_pi * (fraction - 0.25 * static_cast<double>(quarter));
  const double y = x * x;
  double s = 1.0 / 355687428096000.0;  // 1/17!
  s = s * y - 1.0 / 1307674368000.0;
  s = s * y + 1.0 / 6227020800.0;
  s = s * y - 1.0 / 39916800.0;
  s = s * y + 1.0 / 362880.0;
  s = s * y - 1.0 / 5040.0;
  s = s * y + 1.0 / 120.0;
  s = s * y - 1.0 / 6.0;
  s = x + x * (s * y);
  double c = 1.0 / 20922789888000.0;  // 1/16!
  c = c * y - 1.0 / 87178291200.0;
  c = c * y + 1.0 / 479001600.0;
  c = c * y - 1.0 / 3628800.0;
  c = c * y + 1.0 / 40320.0;
  c = c * y - 1.0 / 720.0;
  c = c * y + 1.0 / 24.0;
  c = c * y - 0.5;
  c = 1 + c * y;
  switch (quarter & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

// atan z = atan k/8 + atan((z - k/8)/(1 + z k/8)) for the nearest k leaves an argument of at most 1/16.
inline double arc_tangent2(double y, double x) {
  constexpr double k_table[9] = {0x0.0p+0,
                                 0x1.fd5ba9aac2f6ep-4,
                                 0x1.f5b75f92c80ddp-3,
                                 0x1.6f61941e4def1p-2,
                                 0x1.dac670561bb4fp-2,
                                 0x1.1e00babdefeb4p-1,
                                 0x1.4978fa3269ee1p-1,
                                 0x1.700a7c5784634p-1,
                                 0x1.921fb54442d18p-1};
  const double u = absolute(x), v = absolute(y);
  const double big = u > v ? u : v, small = u > v ? v : u;
  if (!(big > 0)) return 0;
  const double z = small / big;
  const int64_t k = floor_index(8 * z + 0.5);
  const double c = 0.125 * static_cast<double>(k);
  const double t = (z - c) / (1 + z * c);
  const double q = t * t;
  double p = 1.0 / 13;
  p = p * q - 1.0 / 11;
  p = p * q + 1.0 / 9;
  p = p * q - 1.0 / 7;
  p = p * q + 1.0 / 5;
  p = p * q - 1.0 / 3;
  double angle = k_table[k] + (t + t * (p * q));
  if (v > u) angle = 0.5 * k_pi - angle;
  if (x < 0) angle = k_pi - angle;
  return y < 0 ? -angle : angle;
}

// A third of the exponent by integer division gives 5 % (the constant is Kahan's); each Newton step squares the error.
inline double cube_root(double x) {
  if (!(x > 0)) return 0;
  uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  bits = bits / 3 + 0x2A9F7893782DA1CEull;
  double r;
  std::memcpy(&r, &bits, sizeof r);
  for (int step = 0; step < 5; ++step) r = r - (r - x / (r * r)) * (1.0 / 3.0);
  return r;
}

// e^x = 2^k e^y with |y| <= ln 2 / 2; ln 2 in two parts, of which the first times k is exact.
constexpr double exponential(double x) {
  if (x < -700) return 0;
  if (!(x < 700)) x = 700;
  const int64_t k = floor_index(x * 1.4426950408889634 + 0.5);
  const double y = (x - static_cast<double>(k) * 0x1.62e42fefap-1) - static_cast<double>(k) * 0x1.cf79abc9e3b3ap-40;
  double p = 1.0 / 6227020800.0;  // 1/13!
  p = p * y + 1.0 / 479001600.0;
  p = p * y + 1.0 / 39916800.0;
  p = p * y + 1.0 / 3628800.0;
  p = p * y + 1.0 / 362880.0;
  p = p * y + 1.0 / 40320.0;
  p = p * y + 1.0 / 5040.0;
  p = p * y + 1.0 / 720.0;
  p = p * y + 1.0 / 120.0;
  p = p * y + 1.0 / 24.0;
  p = p * y + 1.0 / 6.0;
  p = p * y + 0.5;
  p = p * y + 1.0;
  p = p * y + 1.0;
  const uint64_t bits = static_cast<uint64_t>(1023 + k) << 52;
  return p * __builtin_bit_cast(double, bits);
}

// ln x = k ln 2 + ln m with m from 0.7 to 1.42; ln m = 2 artanh((m - 1) / (m + 1)), whose first omitted term is below
// 1e-19.
constexpr double logarithm(double x) {
  auto bits = __builtin_bit_cast(int64_t, x);
  int64_t k = (bits >> 52) - 1023;
  bits = (bits & 0x000fffffffffffff) | (static_cast<int64_t>(1023) << 52);
  auto m = __builtin_bit_cast(double, bits);
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++k;
  }
  const double s = (m - 1) / (m + 1), q = s * s;
  double p = 1.0 / 21;
  p = p * q + 1.0 / 19;
  p = p * q + 1.0 / 17;
  p = p * q + 1.0 / 15;
  p = p * q + 1.0 / 13;
  p = p * q + 1.0 / 11;
  p = p * q + 1.0 / 9;
  p = p * q + 1.0 / 7;
  p = p * q + 1.0 / 5;
  p = p * q + 1.0 / 3;
  const double exponent = static_cast<double>(k);
  return exponent * 0x1.62e42fefap-1 + (2 * s + (2 * s * (p * q) + exponent * 0x1.cf79abc9e3b3ap-40));
}

}  // namespace sandglass

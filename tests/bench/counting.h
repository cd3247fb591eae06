// What the counted workloads share. Each program includes this file once.
#pragma once

#include <cstdint>
#include <cstdio>

// The marks between which count_plugin counts, and the one at which it writes what it has counted and starts over.
extern "C" {
__attribute__((noinline)) void counting_laps() { __asm__ volatile(""); }
__attribute__((noinline)) void counting_begins() { __asm__ volatile(""); }
__attribute__((noinline)) void counting_ends() { __asm__ volatile(""); }
}

// Says why a program cannot count; its exit status.
inline int wrong(const char* why, const char* what = "") {
  std::fprintf(stderr, "%s%s\n", why, what);
  return 2;
}

// Random numbers from 0 to 1, the same on every machine.
struct CountingRandom {
  uint32_t state = 1;
  float operator()() {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  }
};

// Checks the rule of sandglass.h for structs that the library fills: apps built with older or newer headers have a
// smaller or larger struct, and nothing beyond its struct_size is written.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace sandglass::tests {

// `fill` lets the library fill a T* and returns whether the library accepted it. `can_refuse` says that the function
// has a status with which it can refuse.
template <class T, class Fill>
void expect_filled_within_its_size(Fill&& fill, bool can_refuse) {
  constexpr uint32_t k_whole = sizeof(T), k_longer = k_whole + 32;
  constexpr uint8_t k_pattern = 0xC5;
  struct Room {
    alignas(T) uint8_t bytes[k_longer];
  };
  const auto filled = [&](uint32_t struct_size, bool accepted) {
    Room room;
    std::memset(room.bytes, k_pattern, sizeof room.bytes);
    std::memcpy(room.bytes, &struct_size, sizeof struct_size);
    EXPECT_EQ(fill(reinterpret_cast<T*>(room.bytes)), accepted) << struct_size;
    return room;
  };
  const Room whole = filled(k_whole, true);
  for (uint32_t struct_size = 0; struct_size <= k_longer; ++struct_size) {
    const bool set = struct_size >= 8;
    const Room room = filled(struct_size, set || !can_refuse);
    uint32_t given_size;
    std::memcpy(&given_size, room.bytes, sizeof given_size);
    const uint32_t written = set ? std::min(struct_size, k_whole) : 0;
    ASSERT_EQ(given_size, set ? written : struct_size);
    uint32_t i = sizeof given_size;
    while (i < k_longer && room.bytes[i] == (i < written ? whole.bytes[i] : k_pattern)) ++i;
    ASSERT_EQ(i, k_longer) << "the first byte that differs; room " << struct_size;
  }
}

}  // namespace sandglass::tests

// What a reader of files must do with damaged ones.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace sandglass::tests {

// `take` says whether it takes bytes, which are a heap block of exactly their size. It takes `whole`, none of its
// beginnings, and nothing with a flipped bit: at every byte, or at so many places.
template <class Byte, class Take>
void expect_only_whole_taken(const std::vector<Byte>& whole, Take&& take, size_t places = SIZE_MAX) {
  const size_t last = whole.size() - 1;
  places = std::min(places, last);
  for (size_t i = 0; i <= places; ++i) {
    const size_t at = last * i / places;
    ASSERT_FALSE(take(std::vector<Byte>(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at)))) << at;
    for (const Byte bit : {Byte{1}, Byte{128}}) {
      std::vector<Byte> flipped = whole;
      flipped[at] ^= bit;
      ASSERT_FALSE(take(flipped)) << "byte " << at;
    }
  }
  EXPECT_TRUE(take(whole));
}

}  // namespace sandglass::tests

// What a reader of files must do with damaged ones.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "models/files/atomic_file.h"
#include "tests/refusal.h"

namespace sandglass::tests {

// Every truncation of `whole` is refused by name. Every file with one flipped bit is refused, or read: `read` checks
// what it has read.
template <class Read>
void expect_damage_refused(const std::string& whole, const std::string& path, Read&& read) {
  for (size_t n = 0; n < whole.size(); ++n) {
    host::write_file(path, std::string_view(whole).substr(0, n));
    SCOPED_TRACE(n);
    expect_refusal(path, read);
    for (const int bit : {1, 128}) {
      std::string flipped = whole;
      flipped[n] = static_cast<char>(flipped[n] ^ bit);
      host::write_file(path, flipped);
      (void)refusal_of(read);
    }
  }
}

}  // namespace sandglass::tests

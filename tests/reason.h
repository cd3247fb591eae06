// What a function of the library refuses, it explains in a sentence.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "sandglass/types.h"

namespace sandglass::tests {

// `call` must be refused with a sentence that contains `words`. It gets the place for the sentence.
template <class Call>
void expect_refused(const std::string& words, Call&& call, sandglass_status status = SANDGLASS_ERROR_INVALID_ARGUMENT) {
  const char* reason = nullptr;
  EXPECT_EQ(call(&reason), status) << words;
  ASSERT_NE(reason, nullptr) << words;
  EXPECT_NE(std::string(reason).find(words), std::string::npos) << reason;
}

}  // namespace sandglass::tests

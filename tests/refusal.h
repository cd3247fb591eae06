// What a piece of work is refused with: the sentence of its Failure, or nothing.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "models/files/failure.h"

namespace sandglass::tests {

template <class Work>
std::string refusal_of(Work&& work) {
  try {
    work();
  } catch (const host::Failure& failure) {
    return failure.what();
  }
  return "";
}

// `work` must be refused with a sentence that contains `words`.
template <class Work>
void expect_refusal(const std::string& words, Work&& work) {
  const std::string said = refusal_of(work);
  EXPECT_NE(said.find(words), std::string::npos) << "\"" << said << "\" is not about: " << words;
  EXPECT_NE(said, "") << words;
}

}  // namespace sandglass::tests

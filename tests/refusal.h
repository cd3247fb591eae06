// What a piece of work is refused with: the sentence of its Failure, or nothing.
#pragma once

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

}  // namespace sandglass::tests

// How the host side reports that it cannot go on: one sentence that says what is wrong, where, and what to do. The
// program prints it and exits with code 2.
#pragma once

#include <stdexcept>
#include <string>

namespace sandglass::host {

struct Failure : std::runtime_error {
  explicit Failure(const std::string& sentence) : std::runtime_error(sentence) {}
};

}  // namespace sandglass::host

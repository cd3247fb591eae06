// A check of an option: a number from low to high. CLI11's own Range compares so that NaN is in every range.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace sandglass::host {

inline CLI::Validator number_between(double low, double high) {
  const std::string range = CLI::detail::to_string(low) + " to " + CLI::detail::to_string(high);
  return CLI::Validator(
      [low, high, range](std::string& text) {
        double value = 0.0;
        const bool inside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return inside ? std::string() : "'" + text + "' is not a number from " + range;
      },
      "FLOAT in " + range);
}

}  // namespace sandglass::host

// What a test measured, for the pages: `./sg numbers` reads it from gtest's JSON as CASE:METRIC.
#pragma once

#include <cstdio>
#include <string>

#include "gtest/gtest.h"

namespace sandglass::test {

inline void measured(const std::string& name, const char* metric, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  testing::Test::RecordProperty(name + ":" + metric, text);
}

}  // namespace sandglass::test

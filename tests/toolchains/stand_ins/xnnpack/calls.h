// The calls that the stand-in got, and how it shall answer.
#pragma once

#include <cstddef>

namespace xnnpack_stand_in {

enum class Call { initialize, create, reshape, setup, run, remove };
struct Asked {
  Call call;
  const void* op;
};
constexpr size_t k_call_capacity = 1 << 16, k_workspace = 3000;  // bytes, for windows above 1x1
extern Asked g_asked[k_call_capacity];
extern size_t g_asked_count;
extern bool g_app_was_first;      // set before the first call of xnn_initialize
extern size_t g_create_failures;  // so many of the next creations fail

}  // namespace xnnpack_stand_in

// What was asked of the stand-in, and what it shall answer.
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
extern bool g_app_was_first;      // before the first call of xnn_initialize
extern size_t g_create_failures;  // of the next creations

}  // namespace xnnpack_stand_in

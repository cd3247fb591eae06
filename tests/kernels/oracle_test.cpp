// Every kernel is compared with a naive oracle in double, on every table that this machine can run. Every table is
// compared with the scalar one to the bit, for all tail lengths. kernels.inc expands into the list of tests, so a
// kernel without a check_<name> does not link. The oracles: *_oracle_test.cpp, by family.
#include <gtest/gtest.h>

#include "tests/kernels/oracles.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

// All tail lengths of the widest instruction set, and one cluster of many vectors.
void check_all_sizes(void (*check)(uint32_t)) {
  for (uint32_t n = 1; n <= 2 * k_lane_group + 1; ++n) {
    check(n);
    if (testing::Test::HasFatalFailure()) FAIL() << n << " items";
  }
  check(150);
}

#define SANDGLASS_KERNEL(user, name, Args, Result) \
  TEST(Oracle, name) { check_all_sizes(check_##name); }
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL

}  // namespace

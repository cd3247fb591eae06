// The pool runs every index exactly once in each call, even when workers come late.
#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "models/work/thread_pool.h"

namespace sandglass::host {
namespace {

TEST(ThreadPool, OneThreadNeedsNoPool) {
  ThreadPool pool(1);
  EXPECT_EQ(pool.hook().run, nullptr);
}

TEST(ThreadPool, RunsEveryIndexOnceInEveryCall) {
  constexpr uint32_t k_calls = 3000, k_count = 37;
  ThreadPool pool(4);
  const sandglass_parallel hook = pool.hook();
  std::vector<std::atomic<uint32_t>> hits(k_count);
  for (uint32_t call = 0; call < k_calls; ++call)
    hook.run(
        hook.user,
        [](void* context, uint32_t index) {
          (*static_cast<std::vector<std::atomic<uint32_t>>*>(context))[index].fetch_add(1);
        },
        &hits, call % (k_count + 1));
  // Index i is part of every call with more than i items. The 3000 calls cycle through counts of 0..37.
  for (uint32_t index = 0; index < k_count; ++index) {
    uint32_t expected = 0;
    for (uint32_t call = 0; call < k_calls; ++call) expected += index < call % (k_count + 1);
    EXPECT_EQ(hits[index].load(), expected);
  }
}

}  // namespace
}  // namespace sandglass::host

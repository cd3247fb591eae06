// The worker pool that the program hands to the library.
#pragma once

#include <cstdint>
#include <memory>

#include "sandglass/sandglass.h"

namespace sandglass::host {

class ThreadPool {
 public:
  explicit ThreadPool(uint32_t threads);  // the calling thread counts as one; 1 makes no thread
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  sandglass_parallel hook();  // run == NULL for one thread; valid as long as the pool lives

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

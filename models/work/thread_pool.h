// The one kind of thread pool in models/. The program also hands it to the library.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "sandglass/sandglass.h"

namespace sandglass::host {

class ThreadPool {
 public:
  explicit ThreadPool(uint32_t threads);  // includes the calling thread; 1 makes no new thread
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  // Runs task(0) to task(count - 1) in any order and returns when all are done. A task must not throw.
  void run(uint32_t count, const std::function<void(uint32_t)>& task);

  sandglass_parallel hook();  // run == NULL for one thread; valid as long as the pool lives

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

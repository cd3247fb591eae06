// The one kind of thread pool in models/, and long work on it. The program also hands the pool to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

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

// Runs `task` for 0 to count - 1, in any order. It ends early when a task throws, and then throws that exception. It
// also ends early on Ctrl-C; then interrupted() is true. Tasks that have begun are finished. For `what` see Progress.
// `threads` includes the calling thread.
void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task);

}  // namespace sandglass::host

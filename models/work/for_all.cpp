// See for_all.h.
#include "models/work/for_all.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "models/work/progress.h"

namespace sandglass::host {

void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task) {
  std::atomic<size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  size_t done = 0;
  Progress progress(what, count);
  const auto work = [&] {
    for (size_t i; (i = next.fetch_add(1)) < count && !interrupted();) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
        next.store(count);
      }
      const std::lock_guard lock(mutex);
      progress.done(++done);
    }
  };
  std::vector<std::thread> workers;
  for (uint32_t i = 1; i < threads; ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace sandglass::host

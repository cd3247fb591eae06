// See for_all.h.
#include "models/work/for_all.h"

#include <exception>
#include <mutex>

#include "models/work/progress.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

void for_all(size_t count, uint32_t threads, const std::string& what, const std::function<void(size_t)>& task) {
  std::mutex mutex;
  std::exception_ptr failure;
  size_t done = 0;
  Progress progress(what, count);
  const auto failed = [&] {
    const std::lock_guard lock(mutex);
    return failure != nullptr;
  };
  ThreadPool(threads).run(static_cast<uint32_t>(count), [&](uint32_t i) {
    if (interrupted() || failed()) return;
    try {
      task(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    progress.done(++done);
  });
  if (failure) std::rethrow_exception(failure);
}

}  // namespace sandglass::host

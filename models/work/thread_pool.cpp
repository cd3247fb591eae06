// The library asks for parallel work hundreds of times per frame, for some tens of microseconds each. So workers look
// for the next call for a while before they sleep. A call never waits for a worker that has not begun: the caller does
// the rest.
//
// pthreadpool does not serve here: it gives every worker a share and waits for all of them. With four threads on four
// cores that other programs use, too, a frame of 50 ms took six seconds with it. With this pool it takes 50 ms.
#include "models/work/thread_pool.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "models/work/progress.h"

namespace sandglass::host {

// A worker looks at the generation counter this often before it sleeps: about as long as a frame's serial parts take.
constexpr int k_looks = 4000;
constexpr int k_busy_looks = 64;  // this many of every 128 looks do not offer the core to others

// `generation` is odd while a call is open. A worker registers in `inside` and takes part only if it then still sees
// the call open. The caller closes the call and waits until nobody is inside. So a late worker can never touch the next
// call's fields.
struct ThreadPool::State {
  std::vector<std::thread> workers;
  std::mutex mutex;
  std::condition_variable wake;
  std::atomic<uint32_t> generation{0}, next{0}, inside{0}, asleep{0};
  std::atomic<bool> quit{false};
  sandglass_task_function task = nullptr;
  void* context = nullptr;
  uint32_t count = 0;

  void take_part() {
    for (uint32_t index; (index = next.fetch_add(1)) < count;) task(context, index);
  }

  void wait_for_change(uint32_t seen) {
    for (int look = 0; look < k_looks; ++look) {
      if (generation.load() != seen || quit.load()) return;
      if (look % (2 * k_busy_looks) >= k_busy_looks) std::this_thread::yield();
    }
    std::unique_lock lock(mutex);
    asleep.fetch_add(1);
    wake.wait(lock, [&] { return quit.load() || generation.load() != seen; });
    asleep.fetch_sub(1);
  }

  void work() {
    uint32_t seen = 0;
    while (!quit.load()) {
      wait_for_change(seen);
      inside.fetch_add(1);
      seen = generation.load();
      if (seen % 2 == 1) take_part();
      inside.fetch_sub(1);
    }
  }

  static void run(void* user, sandglass_task_function task, void* context, uint32_t count) {
    State* s = static_cast<State*>(user);
    s->task = task;
    s->context = context;
    s->count = count;
    s->next.store(0);
    s->generation.fetch_add(1);
    if (s->asleep.load() > 0) {
      // After this lock, a worker that is about to sleep has either seen the new generation or is already waiting.
      { const std::lock_guard lock(s->mutex); }
      s->wake.notify_all();
    }
    s->take_part();
    s->generation.fetch_add(1);
    while (s->inside.load() != 0) std::this_thread::yield();
  }
};

ThreadPool::ThreadPool(uint32_t threads) : state_(std::make_unique<State>()) {
  for (uint32_t i = 1; i < threads; ++i) state_->workers.emplace_back([state = state_.get()] { state->work(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->quit.store(true);
  }
  state_->wake.notify_all();
  for (std::thread& worker : state_->workers) worker.join();
}

void ThreadPool::run(uint32_t count, const std::function<void(uint32_t)>& task) {
  using Task = std::function<void(uint32_t)>;
  const auto call = [](void* context, uint32_t index) { (*static_cast<const Task*>(context))(index); };
  State::run(state_.get(), call, const_cast<Task*>(&task), count);
}

sandglass_parallel ThreadPool::hook() {
  if (state_->workers.empty()) return {nullptr, nullptr};
  return {State::run, state_.get()};
}

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
    const OneOfSeveral counted;
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

// The worker pool of the module with threads: a sandglass_parallel (types.h). sandglass.mjs starts the workers. Each is
// an instance of the same module on the same memory, with a stack of its own.
//
// As in models/work/thread_pool.cpp, workers look for the next call for a while before they sleep, and a call never
// waits for a worker that has not begun. The calling thread never sleeps: a browser's main thread must not.
#include <stddef.h>
#include <stdint.h>

#define EXPORTED(name) __attribute__((export_name(#name))) name

enum { k_looks = 4000 };  // at the counter before a worker sleeps: about as long as a frame's serial parts take

// `generation` is odd while a call is open. A worker registers in `inside` and takes part only if it then still sees the
// call open. The caller closes the call and waits until nobody is inside, so a late worker never sees the next fields.
static uint32_t generation, next, inside, asleep, items, helped;
static void (*work)(void* context, uint32_t index);
static void* work_context;

static uint32_t read(const uint32_t* word) { return __atomic_load_n(word, __ATOMIC_SEQ_CST); }
static uint32_t add(uint32_t* word, uint32_t more) { return __atomic_fetch_add(word, more, __ATOMIC_SEQ_CST); }

// Gives how many it did.
static uint32_t take_part(void) {
  uint32_t done = 0;
  for (uint32_t index; (index = add(&next, 1)) < items; ++done) work(work_context, index);
  return done;
}

// Between reading `asleep` here and sleeping there, nothing is lost: a worker falls asleep only if `generation` is as it
// last saw it.
void EXPORTED(sandglass_web_pool_run)(void* user, void (*task)(void*, uint32_t), void* context, uint32_t count) {
  (void)user;
  work = task;
  work_context = context;
  items = count;
  __atomic_store_n(&next, 0, __ATOMIC_SEQ_CST);
  add(&generation, 1);
  if (read(&asleep) != 0) __builtin_wasm_memory_atomic_notify((int32_t*)&generation, UINT32_MAX);
  take_part();
  add(&generation, 1);
  while (read(&inside) != 0) {
  }
}

// What workers did so far: for tests, which cannot see it in the results.
uint32_t EXPORTED(sandglass_web_pool_helped)(void) { return read(&helped); }

static void wait_for_change(uint32_t seen) {
  for (int look = 0; look < k_looks; ++look)
    if (read(&generation) != seen) return;
  add(&asleep, 1);
  while (read(&generation) == seen) __builtin_wasm_memory_atomic_wait32((int32_t*)&generation, (int32_t)seen, -1);
  add(&asleep, UINT32_MAX);
}

// What a worker does until it is ended.
void EXPORTED(sandglass_web_pool_work)(void) {
  for (uint32_t seen = 0;;) {
    wait_for_change(seen);
    add(&inside, 1);
    seen = read(&generation);
    if (seen % 2 == 1) add(&helped, take_part());
    add(&inside, UINT32_MAX);
  }
}

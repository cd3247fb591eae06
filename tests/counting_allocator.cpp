// The C library lets a program replace malloc and the other allocation functions. These count a call and pass it on to
// the library's own.
#include "tests/counting_allocator.h"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <new>

namespace {
std::atomic<bool> counting{false};
std::atomic<uint64_t> calls{0};
}  // namespace

namespace sandglass::host {
void start_counting_allocations() {
  calls = 0;
  counting = true;
}
uint64_t stop_counting_allocations() {
  counting = false;
  return calls.load();
}
}  // namespace sandglass::host

#if !SANDGLASS_SANITIZED
namespace {
void* counted(void* block) {
  if (counting.load(std::memory_order_relaxed)) calls.fetch_add(1, std::memory_order_relaxed);
  return block;
}
}  // namespace

extern "C" {
// The names under which glibc keeps its own versions for programs that replace the public ones.
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t items, size_t bytes);
void* __libc_realloc(void* old, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void* block);

void* malloc(size_t bytes) { return counted(__libc_malloc(bytes)); }
void* calloc(size_t items, size_t bytes) { return counted(__libc_calloc(items, bytes)); }
void* realloc(void* old, size_t bytes) { return counted(__libc_realloc(old, bytes)); }
void* memalign(size_t alignment, size_t bytes) { return counted(__libc_memalign(alignment, bytes)); }
void* aligned_alloc(size_t alignment, size_t bytes) { return counted(__libc_memalign(alignment, bytes)); }
int posix_memalign(void** block, size_t alignment, size_t bytes) {
  *block = counted(__libc_memalign(alignment, bytes));
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) { __libc_free(counted(block)); }
}

// The C++ operators call the functions above in every library known. They are replaced too, so that the count does not
// depend on that.
void* operator new(size_t bytes) { return counted(__libc_malloc(bytes)); }
void* operator new[](size_t bytes) { return counted(__libc_malloc(bytes)); }
void* operator new(size_t bytes, std::align_val_t a) { return counted(__libc_memalign(static_cast<size_t>(a), bytes)); }
void operator delete(void* block) noexcept { __libc_free(counted(block)); }
void operator delete[](void* block) noexcept { __libc_free(counted(block)); }
void operator delete(void* block, size_t) noexcept { __libc_free(counted(block)); }
void operator delete[](void* block, size_t) noexcept { __libc_free(counted(block)); }
void operator delete(void* block, std::align_val_t) noexcept { __libc_free(counted(block)); }
void operator delete(void* block, size_t, std::align_val_t) noexcept { __libc_free(counted(block)); }
#endif

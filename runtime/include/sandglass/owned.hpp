// What the owner types of sandglass.hpp are made of: a status with its sentence, a block that frees itself, a handle and
// the block it lives in.
#ifndef SANDGLASS_OWNED_HPP
#define SANDGLASS_OWNED_HPP

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass {
inline namespace cpp {

// A status code and its sentence. True when the call succeeded; `reason` is then null.
struct [[nodiscard]] Status {
  // SANDGLASS_OK, or what went wrong.
  sandglass_status code = SANDGLASS_OK;
  // A static sentence; null after success.
  const char* reason = nullptr;
  // True when the call succeeded.
  explicit operator bool() const { return code == SANDGLASS_OK; }
  // See sandglass_status_name.
  const char* name() const { return sandglass_status_name(code); }
};
// What a function of the C API that returns a status says.
template <class Function, class... Arguments>
Status call(Function function, Arguments... arguments) {
  Status status;
  status.code = function(arguments..., &status.reason);
  return status;
}

// A view of points or vectors, three floats each, in memory that the app keeps for the duration of the call. Made
// from a pointer and a number of points, or from any contiguous container of floats (a trailing incomplete point is
// left out).
struct Points {
  // x0 y0 z0 x1 ...
  const float* xyz = nullptr;
  // How many points there are.
  uint32_t count = 0;
  // No points.
  Points() = default;
  // `points` of them, from `first` on.
  Points(const float* first, uint32_t points) : xyz(first), count(points) {}
  // All of a container.
  template <class Container, class = decltype(static_cast<const float*>(std::declval<const Container&>().data()))>
  Points(const Container& floats) : xyz(floats.data()), count(static_cast<uint32_t>(floats.size() / 3)) {}
};

// A block aligned as the library wants it; empty when the heap has none.
struct ReleaseBlock {
  // Frees the block.
  void operator()(std::byte* block) const { ::operator delete (block, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT}); }
};
// A block that frees itself.
using Block = std::unique_ptr<std::byte[], ReleaseBlock>;
// A block of this size, or an empty one.
inline Block allocate_block(uint64_t bytes) {
  return Block(static_cast<std::byte*>(
      ::operator new (static_cast<std::size_t>(bytes), std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT}, std::nothrow)));
}
// What is returned for an empty one.
inline Status no_memory() {
  return {SANDGLASS_ERROR_MEMORY_TOO_SMALL, "the heap has no block of the size that is needed"};
}

// Whether the linked library fits these headers: what an app asks first. The owner types ask it, too, when they create.
inline Status check_version() {
  if (SANDGLASS_VERSION_FITS()) return {};
  return {SANDGLASS_ERROR_UNSUPPORTED, "the linked library is of another version than the headers: build with its own"};
}

// What is made in a block: the block, empty when the app lent it, and the handle into it. The handle stays valid
// when its owner is moved, because the block does not move. Movable, not copyable.
//
// Each owner type's create allocates its block, once and for all. It fails like the C function, or with MEMORY_TOO_SMALL
// when the heap has no such block. What was there is replaced on success and kept on failure.
template <class Handle>
class Owned {
 public:
  // Nothing yet.
  Owned() = default;
  // Takes both over.
  Owned(Owned&& other) noexcept : block_(std::move(other.block_)), handle_(std::exchange(other.handle_, nullptr)) {}
  // Takes both over.
  Owned& operator=(Owned&& other) noexcept {
    block_ = std::move(other.block_);
    handle_ = std::exchange(other.handle_, nullptr);
    return *this;
  }

  // True once create has succeeded.
  explicit operator bool() const { return handle_ != nullptr; }
  // The handle: for the C functions that have no short form here, and for sandglass_frame_input. Null when nothing was
  // made yet.
  Handle* get() const { return handle_; }

 protected:
  // Allocates a block and makes the thing in it: bytes_of and create_in take these arguments first.
  template <class Bytes, class Create, class... Arguments>
  Status create_of(Bytes bytes_of, Create create_in, Arguments... arguments) {
    uint64_t need = 0;
    if (const Status status = call(bytes_of, arguments..., &need); !status) return status;
    Block block = allocate_block(need);
    if (block == nullptr) return no_memory();
    const Status status = create_at(block.get(), need, create_in, arguments...);
    if (status) block_ = std::move(block);
    return status;
  }
  // The same in a block that the caller keeps.
  template <class Create, class... Arguments>
  Status create_at(void* block, uint64_t bytes, Create create_in, Arguments... arguments) {
    Handle* made = nullptr;
    Status status = check_version();
    if (status) status = call(create_in, arguments..., block, bytes, &made);
    if (!status) return status;
    block_.reset();
    handle_ = made;
    return status;
  }

 private:
  Block block_;
  Handle* handle_ = nullptr;
};

// A struct as one of the C functions fills it in: its defaults.
template <class Struct>
Struct filled(void (*fill)(Struct*)) {
  Struct made;
  fill(&made);
  return made;
}
// What one of the C functions reports, in a struct of the size of these headers.
template <class Struct, class Function, class... Arguments>
Struct reported(Function function, Arguments... arguments) {
  Struct now{};
  now.struct_size = sizeof now;
  function(arguments..., &now);
  return now;
}
// What is saved, as bytes: by a pair of C functions.
template <class Handle, class BytesOf, class Save>
Status saved(Handle* handle, BytesOf bytes_of, Save save, std::vector<std::byte>* data) {
  uint64_t written = 0;
  data->resize(static_cast<std::size_t>(bytes_of(handle)));
  const Status status = call(save, handle, data->data(), data->size(), &written);
  data->resize(static_cast<std::size_t>(written));
  return status;
}

}  // namespace cpp
}  // namespace sandglass

#endif  // SANDGLASS_OWNED_HPP

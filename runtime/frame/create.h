// How every handle is created: its description is checked, one walk over it counts bytes or lays out the app's block, the block is
// cleared, and the handle is built there. What one capability has of its own is its Maker, made anew for each call:
//   using Desc, Handle
//   sandglass_status check(const Desc&, const char** reason)             what it finds, it may keep for the next two
//   Handle* lay_out(const Desc&, Layout*)                                the one walk; null while counting
//   sandglass_status build(const Desc&, Handle*, const char** reason)    in a block of zeros, under exact floating point
#pragma once

#include "platform/floating_point.h"
#include "runtime/frame/layout.h"
#include "runtime/frame/refuse.h"

namespace sandglass {

// A maker of three functions, for what keeps nothing.
template <auto Check, auto LayOut, auto Build, class Signature = decltype(Build)>
struct MakerOf;
template <auto Check, auto LayOut, auto Build, class D, class H>
struct MakerOf<Check, LayOut, Build, sandglass_status (*)(const D&, H*, const char**)> {
  using Desc = D;
  using Handle = H;
  sandglass_status check(const D& desc, const char** reason) { return Check(desc, reason); }
  H* lay_out(const D& desc, Layout* layout) { return LayOut(desc, layout); }
  sandglass_status build(const D& desc, H* handle, const char** reason) { return Build(desc, handle, reason); }
};

template <class Maker>
sandglass_status check_desc(const typename Maker::Desc* desc, Maker* maker, const char** reason) {
  if (desc == nullptr) return refuse(reason, "desc is NULL: fill one by the _desc_default function of this name.");
  if (desc->struct_size != sizeof *desc)
    return refuse(reason,
                  "desc.struct_size is not this library's: fill desc by the _desc_default function of this name.");
  return maker->check(*desc, reason);
}

// Out of line, so that its layout does not lie on the stack beside that of build_in.
template <class Maker>
__attribute__((noinline)) uint64_t count_bytes(const typename Maker::Desc& desc, Maker* maker) {
  Layout layout;
  (void)maker->lay_out(desc, &layout);
  return layout.size;
}

template <class Maker>
__attribute__((noinline)) sandglass_status build_in(const typename Maker::Desc& desc, Maker* maker, void* block,
                                                    uint64_t bytes, typename Maker::Handle** handle,
                                                    const char** reason) {
  __builtin_memset(block, 0, bytes);
  Layout layout;
  layout.base = static_cast<uint8_t*>(block);
  typename Maker::Handle* made = maker->lay_out(desc, &layout);
  const ExactFloatingPoint exact;
  const sandglass_status status = maker->build(desc, made, reason);
  if (status == SANDGLASS_OK) *handle = made;
  return status;
}

template <class Maker>
__attribute__((always_inline)) inline sandglass_status bytes_of(const typename Maker::Desc* desc, uint64_t* bytes,
                                                                const char** reason) {
  Maker maker;
  if (const sandglass_status status = check_desc(desc, &maker, reason)) return status;
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass where to store the size.");
  *bytes = count_bytes(*desc, &maker);
  return accept(reason);
}

// no_handle: the sentence that refuses a handle of NULL. Always inline: a maker lies on the stack once.
template <class Maker>
__attribute__((always_inline)) inline sandglass_status create_in(const typename Maker::Desc* desc, void* block,
                                                                 uint64_t bytes, typename Maker::Handle** handle,
                                                                 const char* no_handle, const char** reason) {
  Maker maker;
  if (const sandglass_status status = check_desc(desc, &maker, reason)) return status;
  if (handle == nullptr) return refuse(reason, no_handle);
  const uint64_t need = count_bytes(*desc, &maker);
  if (const sandglass_status usable = check_block(block, bytes, need, reason)) return usable;
  return build_in(*desc, &maker, block, need, handle, reason);
}

}  // namespace sandglass

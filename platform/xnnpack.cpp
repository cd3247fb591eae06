#include "platform/xnnpack.h"

#include <cstring>

#include "platform/check.h"
#include "platform/xnnpack_create.h"

// The build defines what it found in XNNPACK's header:
//   SANDGLASS_XNNPACK_RESHAPES  the header is of the generation since 2023
//   SANDGLASS_XNNPACK_INT8      its name for convolutions of bytes with a multiplier for each output: qc8, or qs8_qc8w
//                               since 2023; not defined if it has none
#define SANDGLASS_JOIN_WORDS(a, b) a##b
#define SANDGLASS_JOIN(a, b) SANDGLASS_JOIN_WORDS(a, b)

namespace sandglass {

struct XnnpackOperator {
  xnn_operator_t handle;
  void* workspace;
  uint32_t width, height;
  bool bytes;
};

namespace {

static_assert(XNN_EXTRA_BYTES <= k_xnnpack_slack_bytes);
constexpr int8_t k_zero = -128;  // how a byte of 0 is stored

// ---------------------------------------------------------------------------------------------------- region

// Pieces in the order of their addresses, each behind its header. Free neighbours are joined when a search next comes
// to them. The first piece that fits is taken: there are only some hundreds, and all are taken when a network is
// created.
constexpr uint64_t k_grain = 128;  // alignment of every piece, more than XNNPACK asks for
struct Piece {
  uint64_t bytes;  // with the header
  bool taken;
};
static_assert(sizeof(Piece) <= k_grain);

alignas(k_grain) uint8_t g_region[k_xnnpack_region_bytes];
uint64_t g_used;
bool g_full;  // a request was refused since this was last cleared

Piece* piece_at(uint64_t offset) { return reinterpret_cast<Piece*>(g_region + offset); }
Piece* piece_of(void* pointer) { return reinterpret_cast<Piece*>(static_cast<uint8_t*>(pointer) - k_grain); }

void* take(uint64_t bytes) {
  if (bytes > k_xnnpack_region_bytes - k_grain) {
    g_full = true;
    return nullptr;
  }
  const uint64_t need = k_grain + (bytes + k_grain - 1) / k_grain * k_grain;
  if (piece_at(0)->bytes == 0) *piece_at(0) = {k_xnnpack_region_bytes, false};
  for (uint64_t at = 0; at < k_xnnpack_region_bytes; at += piece_at(at)->bytes) {
    Piece* piece = piece_at(at);
    if (piece->taken) continue;
    for (uint64_t next = at + piece->bytes; next < k_xnnpack_region_bytes && !piece_at(next)->taken;
         next = at + piece->bytes)
      piece->bytes += piece_at(next)->bytes;
    if (piece->bytes < need) continue;
    if (piece->bytes > need) *piece_at(at + need) = {piece->bytes - need, false};
    *piece = {need, true};
    g_used += need;
    return g_region + at + k_grain;
  }
  g_full = true;
  return nullptr;
}

void give(void* pointer) {
  if (pointer == nullptr) return;
  Piece* piece = piece_of(pointer);
  piece->taken = false;
  g_used -= piece->bytes;
}

void* allocate(void*, size_t bytes) { return take(bytes); }
void* allocate_aligned(void*, size_t alignment, size_t bytes) { return alignment <= k_grain ? take(bytes) : nullptr; }
void* reallocate(void*, void* pointer, size_t bytes) {
  if (pointer == nullptr) return take(bytes);
  const uint64_t had = piece_of(pointer)->bytes - k_grain;
  if (bytes <= had) return pointer;
  void* larger = take(bytes);
  if (larger == nullptr) return nullptr;
  memcpy(larger, pointer, had);
  give(pointer);
  return larger;
}
void deallocate(void*, void* pointer) { give(pointer); }

constexpr xnn_allocator k_allocator = {nullptr, allocate, reallocate, deallocate, allocate_aligned, deallocate};

// ---------------------------------------------------------------------------------------------------- both generations

#ifdef SANDGLASS_XNNPACK_RESHAPES

struct Workspace {
  size_t bytes = 0, alignment = 1;
};

template <class... Parameters>
xnn_status reshape(xnn_status (*function)(Parameters...), const XnnpackOperator& op, Workspace* workspace) {
  size_t out_height = 0, out_width = 0;
  constexpr size_t k_count = sizeof...(Parameters);
  static_assert(k_count >= 7 && k_count <= 9);
  if constexpr (k_count == 7) return function(op.handle, 1, op.height, op.width, &out_height, &out_width, nullptr);
  else if constexpr (k_count == 8)
    return function(op.handle, 1, op.height, op.width, &workspace->bytes, &out_height, &out_width, nullptr);
  else
    return function(op.handle, 1, op.height, op.width, &workspace->bytes, &workspace->alignment, &out_height,
                    &out_width, nullptr);
}

template <class Value, class... Parameters>
xnn_status set_up(xnn_status (*function)(Parameters...), const XnnpackOperator& op, const void* in, void* out) {
  const auto* from = static_cast<const Value*>(in);
  auto* to = static_cast<Value*>(out);
  if constexpr (sizeof...(Parameters) == 3) return function(op.handle, from, to);
  else return function(op.handle, op.workspace, from, to);
}

xnn_status reshape(const XnnpackOperator& op, Workspace* workspace) {
#ifdef SANDGLASS_XNNPACK_INT8
  if (op.bytes) return reshape(&SANDGLASS_JOIN(xnn_reshape_convolution2d_nhwc_, SANDGLASS_XNNPACK_INT8), op, workspace);
#endif
  return reshape(&xnn_reshape_convolution2d_nhwc_f32, op, workspace);
}

// Everything that depends on the image's size, once.
bool prepare(XnnpackOperator* op) {
  Workspace workspace;
  if (reshape(*op, &workspace) != xnn_status_success || workspace.alignment > k_grain) return false;
  if (workspace.bytes == 0) return true;
  op->workspace = take(workspace.bytes);
  return op->workspace != nullptr;
}

#else

template <class Value, class... Parameters>
xnn_status set_up(xnn_status (*function)(Parameters...), const XnnpackOperator& op, const void* in, void* out) {
  return function(op.handle, 1, op.height, op.width, static_cast<const Value*>(in), static_cast<Value*>(out), nullptr);
}

xnn_status set_up(const XnnpackOperator& op, const void* in, void* out);

// The first setup makes a table of addresses; later ones for the same size only move it. Nothing is read yet.
bool prepare(XnnpackOperator* op) { return set_up(*op, g_region, g_region) == xnn_status_success; }

#endif

xnn_status set_up(const XnnpackOperator& op, const void* in, void* out) {
#ifdef SANDGLASS_XNNPACK_INT8
  if (op.bytes)
    return set_up<int8_t>(&SANDGLASS_JOIN(xnn_setup_convolution2d_nhwc_, SANDGLASS_XNNPACK_INT8), op, in, out);
#endif
  return set_up<float>(&xnn_setup_convolution2d_nhwc_f32, op, in, out);
}

// ---------------------------------------------------------------------------------------------------- operators

XnnpackOperator* refuse(const char** reason) {
  if (reason != nullptr)
    *reason = g_full
                  ? "the region that XNNPACK draws on is full: release another estimator, or build with a greater "
                    "SANDGLASS_XNNPACK_REGION_MIB"
                  : "this XNNPACK does not have the operators of this back end for this CPU: choose another back end";
  return nullptr;
}

template <class Function, class... Arguments>
XnnpackOperator* create_operator(Function function, const XnnpackConvolution& s, bool bytes, const char** reason,
                                 Arguments... arguments) {
  g_full = false;
  auto* op = static_cast<XnnpackOperator*>(take(sizeof(XnnpackOperator)));
  if (op == nullptr) return refuse(reason);
  *op = {nullptr, nullptr, s.width, s.height, bytes};
  // Padding above, right, below and left; the window; its steps; its dilation; one group.
  const xnn_status status = xnnpack_create_operator(
      function, &op->handle, 0u, s.pad_columns, 0u, s.pad_columns, s.size, s.size, s.step, s.step, 1u, 1u, 1u,
      size_t{s.inputs}, size_t{s.outputs}, size_t{s.in_stride}, size_t{s.out_stride}, arguments...);
  if (status != xnn_status_success) op->handle = nullptr;
  else if (prepare(op)) return op;
  xnnpack_release(op);
  return refuse(reason);
}

}  // namespace

bool xnnpack_begin(const char** reason) {
  const auto fail = [&](const char* sentence) {
    if (reason != nullptr) *reason = sentence;
    return false;
  };
  if (xnn_initialize(&k_allocator) != xnn_status_success) return fail("XNNPACK does not run on this CPU");
  // Only a request shows whether XNNPACK draws on the region.
  xnn_operator_t probe = nullptr;
  const float one = 1.0f;
  const uint64_t before = g_used;
  if (xnnpack_create_operator(&xnn_create_convolution2d_nhwc_f32, &probe, 0u, 0u, 0u, 0u, 1u, 1u, 1u, 1u, 1u, 1u, 1u,
                              size_t{1}, size_t{1}, size_t{1}, size_t{1}, &one, &one, 0.0f, 1.0f,
                              0u) != xnn_status_success) {
    (void)refuse(reason);
    return false;
  }
  const bool ours = g_used > before;
  (void)xnn_delete_operator(probe);
  return ours ||
         fail(
             "the app initialised XNNPACK first, so that its memory has no bound here: create the estimator before, or "
             "choose the project's own back end");
}

XnnpackOperator* xnnpack_create(const XnnpackConvolution& shape, const float* weights, const float* bias, float low,
                                float high, const char** reason) {
  return create_operator(&xnn_create_convolution2d_nhwc_f32, shape, false, reason, weights, bias, low, high, 0u);
}

XnnpackOperator* xnnpack_create([[maybe_unused]] const XnnpackConvolution& shape,
                                [[maybe_unused]] const int8_t* weights, [[maybe_unused]] const int32_t* bias,
                                [[maybe_unused]] const float* multipliers, const char** reason) {
#ifdef SANDGLASS_XNNPACK_INT8
  return create_operator(&SANDGLASS_JOIN(xnn_create_convolution2d_nhwc_, SANDGLASS_XNNPACK_INT8), shape, true, reason,
                         k_zero, 1.0f, multipliers, weights, bias, k_zero, 1.0f, int8_t{-128}, int8_t{127}, 0u);
#else
  g_full = false;
  return refuse(reason);
#endif
}

void xnnpack_release(XnnpackOperator* op) {
  if (op == nullptr) return;
  if (op->handle != nullptr) (void)xnn_delete_operator(op->handle);
  give(op->workspace);
  give(op);
}

// The size is the one that was prepared, so neither call has a reason to fail.
void xnnpack_run(XnnpackOperator* op, const void* in, void* out) {
  SANDGLASS_CHECK(set_up(*op, in, out) == xnn_status_success);
  SANDGLASS_CHECK(xnn_run_operator(op->handle, nullptr) == xnn_status_success);
}

uint64_t xnnpack_region_used() { return g_used; }

}  // namespace sandglass

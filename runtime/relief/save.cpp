// Heights to bytes and back: all of them, or what the last version has changed. The bytes may come from anywhere.
#include <cstddef>
#include <cstring>

#include "runtime/frame/refuse.h"
#include "runtime/math/hash.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr uint32_t k_magic = 0x6c726773, k_version = 1;  // "sgrl"

// What stands before the heights of the box, row after row, two bytes each.
struct SavedRelief {
  uint32_t magic, version;
  uint64_t checksum;  // of all that follows
  uint32_t cells[2];
  float cell;
  ReliefBox box;
  uint32_t unused;
};
constexpr uint64_t k_checked_from = offsetof(SavedRelief, cells);

uint64_t checksum_of(const void* data, uint64_t bytes) {
  return hash_bytes(static_cast<const uint8_t*>(data) + k_checked_from, bytes - k_checked_from);
}

ReliefBox box_of(const ReliefState& relief, bool whole) {
  if (!whole) return relief.changed;
  return {{0, 0}, {relief.desc.cells[0], relief.desc.cells[1]}};
}
uint64_t bytes_of(const ReliefBox& box) {
  return sizeof(SavedRelief) + sizeof(int16_t) * uint64_t{box.high[0] - box.low[0]} * (box.high[1] - box.low[1]);
}

// Calls visit(cell, place of its height in the bytes) for each cell of a box.
template <class Visit>
void for_box(const ReliefState& relief, const ReliefBox& box, const Visit& visit) {
  uint64_t at = sizeof(SavedRelief);
  for (uint32_t z = box.low[1]; z < box.high[1]; ++z)
    for (uint32_t x = box.low[0]; x < box.high[0]; ++x, at += sizeof(int16_t)) visit(z * relief.desc.cells[0] + x, at);
}

// What is wrong with bytes that are as many as a head has at least, or null.
const char* fault_of(const ReliefState& relief, const SavedRelief& head, const uint8_t* data, uint64_t bytes) {
  if (head.magic != k_magic) return "the bytes are no saved relief.";
  if (head.version != k_version) return "the relief was saved by another version: look at the place again.";
  if (head.checksum != checksum_of(data, bytes)) return "the bytes were damaged since they were saved.";
  for (int k = 0; k < 2; ++k)
    if (head.cells[k] != relief.desc.cells[k] || head.box.low[k] > head.box.high[k] || head.box.high[k] > head.cells[k])
      return "the bytes are of a relief with other cells: create it with the same description.";
  if (head.cell != relief.desc.cell)
    return "the bytes are of a relief with other cells: create it with the same description.";
  if (bytes != bytes_of(head.box)) return "the bytes are not as many as were saved: pass all of them.";
  bool sound = true;
  for_box(relief, head.box, [&](uint32_t, uint64_t at) {
    int16_t height;
    memcpy(&height, data + at, sizeof height);
    sound = sound && height >= k_relief_lowest && height <= k_relief_highest;
  });
  return sound ? nullptr : "the bytes hold a height that no relief has.";
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

uint64_t sandglass_relief_save_bytes(const sandglass_relief* relief, uint32_t whole) {
  return relief == nullptr ? 0 : bytes_of(box_of(relief->relief, whole != 0));
}

sandglass_status sandglass_relief_save(const sandglass_relief* handle, uint32_t whole, void* data, uint64_t bytes,
                                       uint64_t* written, const char** reason) {
  if (handle == nullptr || data == nullptr || written == nullptr)
    return refuse(reason, "relief, data or written is NULL: pass the relief and where to write to.");
  const ReliefState& relief = handle->relief;
  SavedRelief head = {k_magic, k_version, 0, {}, relief.desc.cell, box_of(relief, whole != 0), 0};
  for (int k = 0; k < 2; ++k) head.cells[k] = relief.desc.cells[k];
  const uint64_t need = bytes_of(head.box);
  if (bytes < need)
    return refuse(reason, SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                  "bytes is less than the relief needs: ask sandglass_relief_save_bytes.");
  auto* to = static_cast<uint8_t*>(data);
  memcpy(to, &head, sizeof head);
  for_box(relief, head.box,
          [&](uint32_t cell, uint64_t at) { memcpy(to + at, &relief.cells.shown[cell], sizeof(int16_t)); });
  head.checksum = checksum_of(data, need);
  memcpy(to, &head, sizeof head);
  *written = need;
  return accept(reason);
}

sandglass_status sandglass_relief_restore(sandglass_relief* handle, const void* data, uint64_t bytes,
                                          const char** reason) {
  if (handle == nullptr || data == nullptr)
    return refuse(reason, "relief or data is NULL: pass the relief and the saved bytes.");
  const auto* from = static_cast<const uint8_t*>(data);
  SavedRelief head;
  if (bytes < sizeof head) return refuse(reason, "the bytes are fewer than any saved relief has.");
  memcpy(&head, data, sizeof head);
  ReliefState* relief = &handle->relief;
  if (const char* fault = fault_of(*relief, head, from, bytes)) return refuse(reason, fault);
  for_box(*relief, head.box, [&](uint32_t cell, uint64_t at) {
    int16_t height;
    memcpy(&height, from + at, sizeof height);
    relief_set_cell(relief, cell, height);
  });
  relief_end_change(relief);
  relief->changed = head.box;
  ++relief->version;
  return accept(reason);
}

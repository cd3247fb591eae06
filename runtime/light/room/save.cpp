// A room as bytes, and back. The parts follow the header and are not rounded: a restored room answers as the saved one
// did.
#include <cstddef>
#include <cstring>

#include "runtime/frame/refuse.h"
#include "runtime/light/room/room.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"

namespace sandglass {

namespace {

constexpr uint32_t k_magic = 0x6d726773;  // "sgrm"
constexpr uint32_t k_version = 6;

struct SavedRoom {
  uint32_t magic, version;
  uint64_t checksum;  // FNV-1a over what follows it
  double radius, yaw, scale;
  double centre[3];
  double light;
  float balance[3], gains[3];
  uint32_t images, exposure_known;
  uint32_t grown, far;
  uint64_t has_probe;  // then a SavedProbe follows
  RoomPart parts[k_room_parts];
  RoomLamp lamps[k_room_lamps];
};
struct SavedProbe {
  double confidence, scale, dark;
  double place[3];
  RoomFarLight far;
  RoomProbePart parts[k_room_parts];
};
constexpr uint64_t k_checked_from = 2 * sizeof(uint32_t) + sizeof(uint64_t);

bool sound(const SavedRoom& saved) {
  constexpr auto k_limit = static_cast<double>(SANDGLASS_COORDINATE_LIMIT);
  if (!within(saved.radius, 0.1, 1000.0) || !within(saved.yaw, 0.0, 1.0) || !within(saved.scale, 1e-6, 1e6) ||
      !within(saved.light, 1e-6, 1e6))
    return false;
  for (const double c : saved.centre)
    if (!within(c, -2 * k_limit, 2 * k_limit)) return false;
  if (saved.exposure_known > 1 || saved.has_probe > 1 || saved.far > 1 || saved.grown > 6) return false;
  const bool has_gains = saved.gains[0] != 0 || saved.gains[1] != 0 || saved.gains[2] != 0;
  if (!all_within(saved.balance, 3, 1e-4f, 1e4f) || (has_gains && !all_within(saved.gains, 3, 1e-4f, 1e4f)))
    return false;
  for (const RoomPart& part : saved.parts) {
    if (!all_within(part.radiance, 3, 0.0f, 1e7f) || !within(part.weight, 0.0f, 1e3f)) return false;
    if (part.up < -127 || part.aside < -127) return false;
    for (const int8_t x : part.from)
      if (x < -127) return false;
  }
  for (const RoomLamp& lamp : saved.lamps)
    if (!within(lamp.across, 0.0f, 4.0f) || !within(lamp.error, 0.0f, 8.0f) || !within(lamp.strength, 0.0f, 1e9f) ||
        lamp.images > 8 || lamp.clipped > 1)
      return false;
  return true;
}

bool sound(const SavedProbe& saved) {
  constexpr uint16_t k_half_of_one = 0x3c00;
  if (!within(saved.confidence, 0.0, 1.0) || !within(saved.scale, 0.0, 1e12) || !within(saved.dark, 0.0, 1.0))
    return false;
  for (const double p : saved.place)
    if (!within(p, -1e6, 1e6)) return false;
  for (int k = 0; k < 3; ++k)
    if (!within(saved.far.direction[k], -1.01, 1.01) || !within(saved.far.irradiance[k], 0.0, 1e6)) return false;
  if (!within(saved.far.row, 0.0, 1.0 * k_room_rows) || !within(saved.far.column, 0.0, 1.0 * k_room_columns))
    return false;
  for (const RoomProbePart& part : saved.parts)
    if (part.clipped > k_half_of_one) return false;
  return true;
}

bool has_probe(const Room& room) { return room.probe != nullptr && room.probe->confidence > 0; }
uint64_t bytes_of(bool probe) { return sizeof(SavedRoom) + (probe ? sizeof(SavedProbe) : 0); }

uint64_t checksum_of(const void* bytes, uint64_t count) {
  return hash_bytes(static_cast<const uint8_t*>(bytes) + k_checked_from, count - k_checked_from);
}

}  // namespace

}  // namespace sandglass

using namespace sandglass;

uint64_t sandglass_room_save_bytes(const sandglass_room* room) {
  return room == nullptr ? 0 : bytes_of(has_probe(room->room));
}

sandglass_status sandglass_room_save(const sandglass_room* handle, void* data, uint64_t bytes, uint64_t* written,
                                     const char** reason) {
  if (handle == nullptr || data == nullptr || written == nullptr)
    return refuse(reason, "room, data or written is NULL: pass the room and where to write to.");
  const uint64_t needed = bytes_of(has_probe(handle->room));
  if (bytes < needed)
    return refuse(reason, SANDGLASS_ERROR_MEMORY_TOO_SMALL,
                  "bytes is less than the room needs: ask sandglass_room_save_bytes.");
  const Room& room = handle->room;
  uint8_t* to = static_cast<uint8_t*>(data);
  // Field by field, because `data` may have any alignment.
  const auto put = [to](uint64_t at, const void* from, uint64_t count) { memcpy(to + at, from, count); };
  const uint32_t heads[2] = {k_magic, k_version},
                 flags[4] = {room.images, room.exposure_known ? 1u : 0u, room.grown, room.far ? 1u : 0u};
  put(0, heads, sizeof heads);
  put(offsetof(SavedRoom, radius), &room.radius, sizeof room.radius);
  put(offsetof(SavedRoom, yaw), &room.yaw, sizeof room.yaw);
  put(offsetof(SavedRoom, scale), &room.scale, sizeof room.scale);
  put(offsetof(SavedRoom, centre), room.centre, sizeof room.centre);
  put(offsetof(SavedRoom, light), &room.light, sizeof room.light);
  put(offsetof(SavedRoom, balance), room.balance, sizeof room.balance);
  put(offsetof(SavedRoom, gains), room.gains, sizeof room.gains);
  put(offsetof(SavedRoom, images), flags, sizeof flags);
  put(offsetof(SavedRoom, parts), room.parts, sizeof room.parts);
  put(offsetof(SavedRoom, lamps), room.lamps, sizeof room.lamps);
  const uint64_t probes = has_probe(room) ? 1 : 0;
  put(offsetof(SavedRoom, has_probe), &probes, sizeof probes);
  if (probes != 0) {
    const RoomProbe& probe = *room.probe;
    const double numbers[6] = {probe.confidence, probe.scale,    probe.dark,
                               probe.place[0],   probe.place[1], probe.place[2]};
    put(sizeof(SavedRoom), numbers, sizeof numbers);
    put(sizeof(SavedRoom) + offsetof(SavedProbe, far), &probe.far, sizeof probe.far);
    put(sizeof(SavedRoom) + offsetof(SavedProbe, parts), probe.parts, sizeof probe.parts);
  }
  const uint64_t checksum = checksum_of(data, needed);
  put(offsetof(SavedRoom, checksum), &checksum, sizeof checksum);
  *written = needed;
  return accept(reason);
}

sandglass_status sandglass_room_restore(sandglass_room* handle, const void* data, uint64_t bytes, const char** reason) {
  if (handle == nullptr || data == nullptr)
    return refuse(reason, "room or data is NULL: pass the room and the saved bytes.");
  uint32_t heads[2];
  if (bytes != bytes_of(false) && bytes != bytes_of(true))
    return refuse(reason, "the bytes are not as many as a saved room has: pass all of them.");
  memcpy(heads, data, sizeof heads);
  if (heads[0] != k_magic) return refuse(reason, "the bytes are no saved room.");
  if (heads[1] != k_version) return refuse(reason, "the room was saved by another version: look around again.");
  uint64_t checksum;
  memcpy(&checksum, static_cast<const uint8_t*>(data) + offsetof(SavedRoom, checksum), sizeof checksum);
  if (checksum != checksum_of(data, bytes))
    return refuse(reason, "the bytes were damaged since they were saved: look around again.");
  // A copy of its 14 KiB would take nearly all of the stack that a call may use. So it is checked where it lies.
  if (reinterpret_cast<uintptr_t>(data) % alignof(SavedRoom) != 0)
    return refuse(reason, "data is not aligned to 8 bytes: align it.");
  const SavedRoom& saved = *static_cast<const SavedRoom*>(data);
  const auto* probe = reinterpret_cast<const SavedProbe*>(static_cast<const uint8_t*>(data) + sizeof(SavedRoom));
  const bool with_probe = bytes == bytes_of(true);
  if (!sound(saved) || (saved.has_probe != 0) != with_probe || (with_probe && !sound(*probe)))
    return refuse(reason, "the bytes hold a number that no room has.");
  Room* room = &handle->room;
  room_reset(room);
  ++handle->version;
  room->radius = saved.radius;
  room->yaw = saved.yaw;
  room->scale = room->shown_scale = saved.scale;
  for (int k = 0; k < 3; ++k) room->centre[k] = saved.centre[k];
  room->images = saved.images;
  room->exposure_known = saved.exposure_known != 0;
  room->grown = static_cast<uint8_t>(saved.grown);
  room->far = saved.far != 0;
  room->light = room->light_before = saved.light;
  memcpy(room->balance, saved.balance, sizeof room->balance);
  memcpy(room->gains, saved.gains, sizeof room->gains);
  memcpy(room->parts, saved.parts, sizeof room->parts);
  memcpy(room->lamps, saved.lamps, sizeof room->lamps);
  if (!with_probe || room->probe == nullptr) return accept(reason);
  room->probe->confidence = probe->confidence;
  room->probe->scale = probe->scale;
  room->probe->dark = probe->dark;
  for (int k = 0; k < 3; ++k) room->probe->place[k] = probe->place[k];
  room->probe->far = probe->far;
  memcpy(room->probe->parts, probe->parts, sizeof room->probe->parts);
  return accept(reason);
}

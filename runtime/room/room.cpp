// The C API around a Room, and its part in a frame.
#include "runtime/room/room.h"

#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/core/filled_struct.h"
#include "runtime/core/finite.h"
#include "runtime/core/hash.h"
#include "runtime/core/layout.h"
#include "runtime/core/math.h"
#include "runtime/core/refuse.h"
#include "runtime/core/turn.h"
#include "sandglass/estimate.h"

namespace sandglass {

void room_reset(Room* room) {
  const double radius = room->radius, half_life = room->half_life;
  const uint64_t interval_ns = room->interval_ns;
  __builtin_memset(static_cast<void*>(room), 0, sizeof *room);
  room->radius = radius;
  room->half_life = half_life;
  room->interval_ns = interval_ns;
  room->scale = 1;
}

namespace {

static_assert(sizeof(sandglass_room) <= 16 * 1024);

sandglass_status check(const sandglass_room_desc* desc, const char** reason) {
  if (desc == nullptr) return refuse(reason, "desc is NULL: start from sandglass_room_desc_default");
  if (desc->struct_size != sizeof *desc)
    return refuse(reason, "desc.struct_size is not that of this library: start from sandglass_room_desc_default");
  if (!within(desc->radius, 0.1f, 1000.0f)) return refuse(reason, "desc.radius is not in 0.1..1000 metres");
  if (!within(desc->half_life, 1.0f, 1e6f)) return refuse(reason, "desc.half_life is not in 1..1e6 seconds");
  if (!within(desc->interval, 0.0f, 60.0f)) return refuse(reason, "desc.interval is not in 0..60 seconds");
  return accept(reason);
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const Room& room = static_cast<const sandglass_room*>(state)->room;
  if (room.phase == RoomPhase::idle) return false;
  *unit = {0, k_room_unit_parts, "room.image"};
  return true;
}

void run(void* state, uint32_t) { room_run_unit(&static_cast<sandglass_room*>(state)->room); }

uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const Room& room = static_cast<const sandglass_room*>(state)->room;
  if (room.phase == RoomPhase::idle) return 0;
  entries[0] = {0, uint64_t{room_units_left(room)} * k_room_unit_parts};
  return 1;
}

Stage begin_frame(sandglass_room* owner, const sandglass_camera_image* image, const char** refused) {
  bool taken = false;
  if (image != nullptr) {
    const char* reason = nullptr;
    if (sandglass_camera_check(image, &reason) != SANDGLASS_OK) *refused = reason;
    else taken = room_take_image(&owner->room, *image);
  }
  return {owner, next, run, forecast, k_room_kinds, taken ? room_units_left(owner->room) : 0, 1.0f};
}

// A frame that ends early, by a broken clock or a plan, leaves an image unfinished. It is dropped, because its planes
// belong to the app.
void end_frame(sandglass_room* owner) {
  Room* room = &owner->room;
  room->phase = RoomPhase::idle;
  room->cursor = 0;
}

// Out of line: each runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) bool take_whole(Room* room, const CameraImage& image) {
  if (!room_take_image(room, image)) return false;
  while (room->phase != RoomPhase::idle) room_run_unit(room);
  return true;
}

__attribute__((noinline)) void estimate_at(const Room& room, const float position[3],
                                           const sandglass_light_estimate* estimate, sandglass_room_light* light) {
  const double at[3] = {static_cast<double>(position[0]), static_cast<double>(position[1]),
                        static_cast<double>(position[2])};
  room_estimate(room, k_room_model, at, estimate, light);
}

__attribute__((noinline)) bool move(Room* room, const float rotation[4], const float translation[3]) {
  Rotation turn = {};
  if (!rotation_of(rotation, &turn) || !(turn.m[1][1] > 1 - 5e-7)) return false;
  double moved[3];
  rotate(turn, room->centre, moved);
  for (int k = 0; k < 3; ++k) room->centre[k] = moved[k] + static_cast<double>(translation[k]);
  // World azimuths run from +x to +z. (1, 0, 0) goes to the first column.
  const double yaw = room->yaw + arc_tangent2(turn.m[2][0], turn.m[0][0]) / (2 * k_pi);
  room->yaw = yaw - static_cast<double>(floor_index(yaw));
  return true;
}

uint64_t block_bytes() {
  Layout layout;
  (void)layout_region<sandglass_room>(&layout, "room", 1);
  return layout.size;
}

}  // namespace

extern const RoomFunctions k_room_functions = {begin_frame, end_frame};

}  // namespace sandglass

using namespace sandglass;

void sandglass_room_desc_default(sandglass_room_desc* desc) {
  if (desc == nullptr) return;
  *desc = {sizeof *desc, 3.0f, 180.0f, 0.1f};
}

sandglass_status sandglass_room_bytes(const sandglass_room_desc* desc, uint64_t* bytes, const char** reason) {
  if (bytes == nullptr) return refuse(reason, "bytes is NULL: pass where to store the number of bytes");
  const sandglass_status status = check(desc, reason);
  if (status != SANDGLASS_OK) return status;
  *bytes = block_bytes();
  return accept(reason);
}

sandglass_status sandglass_room_create(const sandglass_room_desc* desc, void* block, uint64_t bytes,
                                       sandglass_room** room, const char** reason) {
  if (room == nullptr) return refuse(reason, "room is NULL: pass where to store the room");
  sandglass_status status = check(desc, reason);
  if (status == SANDGLASS_OK) status = check_block(block, bytes, block_bytes(), reason);
  if (status != SANDGLASS_OK) return status;
  auto* owner = static_cast<sandglass_room*>(block);
  owner->functions = &k_room_functions;
  owner->room.radius = static_cast<double>(desc->radius);
  owner->room.half_life = static_cast<double>(desc->half_life);
  owner->room.interval_ns = to_whole<uint64_t>(static_cast<double>(desc->interval) * 1e9);
  room_reset(&owner->room);
  *room = owner;
  return accept(reason);
}

void sandglass_room_reset(sandglass_room* room) {
  if (room != nullptr) room_reset(&room->room);
}

sandglass_status sandglass_room_set_image(sandglass_room* room, const sandglass_camera_image* image, int32_t* taken,
                                          const char** reason) {
  if (taken != nullptr) *taken = 0;
  if (room == nullptr) return refuse(reason, "room is NULL: pass the room that sandglass_room_create made");
  const sandglass_status status = sandglass_camera_check(image, reason);
  if (status != SANDGLASS_OK) return status;
  const FloatingPointControl saved = floating_point_enter();
  const bool took = take_whole(&room->room, *image);
  floating_point_restore(saved);
  if (taken != nullptr) *taken = took ? 1 : 0;
  return accept(reason);
}

sandglass_status sandglass_room_move(sandglass_room* room, const float rotation[4], const float translation[3],
                                     const char** reason) {
  if (room == nullptr || rotation == nullptr || translation == nullptr)
    return refuse(reason, "room, rotation or translation is NULL: pass all three");
  if (!all_within(translation, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "translation is not finite or beyond 1000 m: keep the world near its origin");
  const FloatingPointControl saved = floating_point_enter();
  const bool moved = move(&room->room, rotation, translation);
  floating_point_restore(saved);
  return moved ? accept(reason)
               : refuse(reason,
                        "rotation is not one about the y axis: gravity stays where it is; turn the world about y");
}

sandglass_status sandglass_room_get(const sandglass_room* room, const float position[3],
                                    const sandglass_light_estimate* estimate, sandglass_room_light* light,
                                    const char** reason) {
  if (room == nullptr || position == nullptr || light == nullptr)
    return refuse(reason, "room, position or light is NULL: pass the room, a place and the struct to fill");
  if (!can_fill(light)) return refuse(reason, "light.struct_size is not set: set it to sizeof(sandglass_room_light)");
  if (!all_within(position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "position is not finite or beyond 1000 m: pass where the object stands");
  if (estimate != nullptr && (estimate->struct_size < sizeof *estimate || !all_finite(estimate->direction, 3) ||
                              !within(estimate->confidence, 0.0f, 1.0f) || !within(estimate->contrast, 0.0f, 1.0f)))
    return refuse(reason, "estimate is not one of sandglass_estimator_get: pass it as it was filled, or NULL");
  const FloatingPointControl saved = floating_point_enter();
  estimate_at(room->room, position, estimate, light);
  floating_point_restore(saved);
  return accept(reason);
}

uint64_t sandglass_room_hash(const sandglass_room* room) {
  if (room == nullptr) return 0;
  const Room& r = room->room;
  uint64_t hash = hash_bytes(r.parts, sizeof r.parts);
  hash = hash_with(hash, hash_bytes(r.centre, sizeof r.centre));
  const double numbers[2] = {r.yaw, r.scale};
  hash = hash_with(hash, hash_bytes(numbers, sizeof numbers));
  return hash_with(hash, r.images);
}

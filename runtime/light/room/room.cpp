// The C API around a Room, and its part in a frame.
#include "runtime/light/room/room.h"

#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/light/luminance.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/math/math.h"
#include "runtime/math/plane_axes.h"
#include "runtime/math/turn.h"
#include "sandglass/estimator.h"

namespace sandglass {

constexpr double k_long_ago = 1e9;      // seconds
constexpr float k_tells_from = 0.004f;  // of white: 13 steps of a byte

void room_reset(Room* room) {
  const double given_radius = room->given_radius, half_life = room->half_life;
  const uint64_t interval_ns = room->interval_ns;
  const uint32_t unit = room->unit;
  RoomProbe* const probe = room->probe;
  RoomTexel* const texels = room->texels;
  __builtin_memset(static_cast<void*>(room), 0, sizeof *room);
  room->given_radius = given_radius;
  room->radius = room_first_radius(*room);
  room->half_life = half_life;
  room->interval_ns = interval_ns;
  room->scale = room->shown_scale = room->light = room->light_before = 1;
  for (float& b : room->balance) b = 1;
  room->settled = k_long_ago;
  room->tells_from = k_tells_from;
  room->unit = unit + 1;
  room->probe = probe;
  room->texels = texels;
  if (probe != nullptr) __builtin_memset(static_cast<void*>(probe), 0, sizeof *probe);
  if (texels != nullptr) __builtin_memset(static_cast<void*>(texels), 0, sizeof *texels * k_cube_texels);
}

void room_leave(Room* room) {
  for (int k = 0; k < 3; ++k) room->centre[k] = static_cast<double>(room->view.image.position[k]);
  for (double& x : room->view.position) x = 0;
  room->light = room->light_before = 1;
  room->usual = room->doubted = room->shows = 0;
  room->farther = 0;
  room->settled = k_long_ago;
  room->radius = room_first_radius(*room);
  room->grown = 0;
  room->far = false;
  __builtin_memset(room->parts, 0, sizeof room->parts);
  __builtin_memset(room->white, 0, sizeof room->white);
  __builtin_memset(room->lamps, 0, sizeof room->lamps);
  if (room->texels != nullptr) __builtin_memset(room->texels, 0, sizeof *room->texels * k_cube_texels);
}

namespace {

static_assert(sizeof(sandglass_room) <= 16 * 1024);

sandglass_status check(const sandglass_room_desc& desc, const char** reason) {
  if (desc.radius != 0 && !within(desc.radius, 0.1f, 1000.0f))
    return refuse(reason, "desc.radius is neither 0 nor in 0.1..1000 metres.");
  if (!within(desc.half_life, 1.0f, 1e6f)) return refuse(reason, "desc.half_life is not in 1..1e6 seconds.");
  if (!within(desc.interval, 0.0f, 60.0f)) return refuse(reason, "desc.interval is not in 0..60 seconds.");
  if (desc.probe > 1 || desc.reflections > 1)
    return refuse(reason, "desc.probe or desc.reflections is neither 0 nor 1.");
  return accept(reason);
}

sandglass_status check_image(Room* room, const sandglass_camera_image* image, const char** reason) {
  const sandglass_status status = sandglass_camera_check(image, reason);
  if (status != SANDGLASS_OK || room_clock_is_sound(room, image->timestamp_ns)) return status;
  return refuse(reason, "camera image: time stamps grow by less than a millisecond: give nanoseconds.");
}

bool next(const void* state, uint32_t, WorkUnit* unit) {
  const Room& room = static_cast<const sandglass_room*>(state)->room;
  if (room.phase == RoomPhase::texels) *unit = {2, k_cube_unit_texels, "room.texels"};
  else if (room.phase != RoomPhase::idle) *unit = {0, k_room_unit_parts, "room.image"};
  else if (room_probe_units_left(room) > 0) *unit = {1, 1, "room.probe"};
  else return false;
  return true;
}

void run(void* state, uint32_t) {
  auto* handle = static_cast<sandglass_room*>(state);
  ++handle->version;
  Room* room = &handle->room;
  if (room->phase != RoomPhase::idle) room_run_unit(room);
  else room->probe->run(room);
}

uint32_t forecast(const void* state, uint32_t, Forecast* entries) {
  const Room& room = static_cast<const sandglass_room*>(state)->room;
  uint32_t count = 0;
  const uint32_t texels = room_texel_units_left(room);
  const uint32_t parts = room_units_left(room) - texels;
  if (parts > 0) entries[count++] = {0, uint64_t{parts} * k_room_unit_parts};
  if (texels > 0) entries[count++] = {2, uint64_t{texels} * k_cube_unit_texels};
  if (room_probe_units_left(room) > 0) entries[count++] = {1, room_probe_units_left(room)};
  return count;
}

bool under_way(const void* handle) {
  const Room& room = static_cast<const sandglass_room*>(handle)->room;
  return room.phase != RoomPhase::idle || room_probe_units_left(room) > 0;
}

uint32_t begin_frame(void* handle, const FrameView& view) {
  Room* room = &static_cast<sandglass_room*>(handle)->room;
  const sandglass_camera_image* image = view.input->camera;
  bool taken = false;
  if (image != nullptr) {
    const char* reason = nullptr;
    if (check_image(room, image, &reason) != SANDGLASS_OK) *view.refused = reason;
    else taken = room_take_image(room, *image);
  }
  return (taken ? room_units_left(*room) : 0) + room_probe_units_left(*room);
}

// A frame that ends early, by a broken clock or a plan, leaves an image unfinished. It is dropped, because its planes
// belong to the app.
void end_frame(void* member, sandglass_frame_report* report) {
  auto* handle = static_cast<sandglass_room*>(member);
  handle->room.phase = RoomPhase::idle;
  handle->room.cursor = 0;
  room_drop_probe_unit(&handle->room);
  report->versions.room = handle->version;
}

// Out of line: each runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) bool take_whole(sandglass_room* handle, const CameraImage& image) {
  Room* room = &handle->room;
  if (!room_take_image(room, image)) return false;
  ++handle->version;
  while (room->phase != RoomPhase::idle) room_run_unit(room);
  return room->view.lesson != RoomLesson::nothing;
}

__attribute__((noinline)) void estimate_at(const Room& room, const sandglass_room_place& place,
                                           sandglass_room_light* light) {
  room_estimate(room, k_room_model, place, light);
}

__attribute__((noinline)) void face_at(const Room& room, const float position[3], float height, uint32_t face,
                                       bool left_handed, uint16_t* texels) {
  room_face(room, k_room_model, position, height, face, left_handed, texels);
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

sandglass_room* lay_out(const sandglass_room_desc& desc, Layout* layout) {
  auto* handle = layout_region<sandglass_room>(layout, "room", 1);
  auto* probe = layout_region<RoomProbe>(layout, "room.probe", desc.probe);
  auto* texels = layout_region<RoomTexel>(layout, "room.texels", desc.reflections * k_cube_texels);
  if (handle == nullptr) return handle;
  handle->room.probe = probe;
  handle->room.texels = texels;
  return handle;
}

sandglass_status build(const sandglass_room_desc& desc, sandglass_room* handle, const char** reason) {
  handle->member.capability = &k_room_capability;
  handle->room.given_radius = static_cast<double>(desc.radius);
  handle->room.half_life = static_cast<double>(desc.half_life);
  handle->room.interval_ns = to_whole<uint64_t>(static_cast<double>(desc.interval) * 1e9);
  room_reset(&handle->room);
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

sandglass_status begin_cube(Room* room, const sandglass_cube* cube, const char** reason) {
  if (room->probe == nullptr) return refuse(reason, "room keeps no probe: create it with desc.probe = 1.");
  if (cube->struct_size != sizeof *cube)
    return refuse(reason, "cube.struct_size is not that of this library: start from sandglass_cube_default.");
  if (cube->format < SANDGLASS_CUBE_RGBA8 || cube->format > SANDGLASS_CUBE_RGBA32F)
    return refuse(reason, "cube.format is unknown: give one of sandglass_cube_format.");
  if (cube->size < 4 || cube->size > 1024) return refuse(reason, "cube.size is not in 4..1024 texels: scale it.");
  constexpr int32_t k_texel[] = {4, 4, 8, 12, 16};
  const int32_t row = static_cast<int32_t>(cube->size) * k_texel[cube->format];
  if (cube->stride < row && cube->stride > -row)
    return refuse(reason, "cube.stride is shorter than a row: it is bytes from row to row.");
  for (const void* face : cube->faces)
    if (face == nullptr) return refuse(reason, "a face of the cube is NULL: pass all six.");
  Rotation turn = {};
  if (!rotation_of(cube->orientation, &turn)) return refuse(reason, "cube.orientation is no rotation: pass its pose.");
  if (cube->left_handed > 1 || cube->in_frame > 1 || !within(cube->exposure, 0.0f, 1e6f) ||
      !within(cube->confidence, 0.0f, 1.0f) ||
      !all_within(cube->position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "left_handed, in_frame, exposure, confidence or position of the cube is out of range.");
  room_begin_cube(room, *cube);
  return accept(reason);
}

sandglass_status begin_harmonics(Room* room, const sandglass_harmonics* harmonics, const char** reason) {
  if (room->probe == nullptr) return refuse(reason, "room keeps no probe: create it with desc.probe = 1.");
  if (harmonics->struct_size != sizeof *harmonics)
    return refuse(reason, "harmonics.struct_size is not that of this library: start from sandglass_harmonics_default.");
  if (harmonics->kind < SANDGLASS_HARMONICS_TOTAL || harmonics->kind > SANDGLASS_HARMONICS_AMBIENT)
    return refuse(reason, "harmonics.kind is neither TOTAL nor AMBIENT.");
  if (!all_within(harmonics->sh, 27, -1e6f, 1e6f) || !all_within(harmonics->main_direction, 3, -2.0f, 2.0f) ||
      !all_within(harmonics->main_irradiance, 3, 0.0f, 1e6f) || !within(harmonics->exposure, 0.0f, 1e6f) ||
      !within(harmonics->confidence, 0.0f, 1.0f) || harmonics->in_frame > 1 || harmonics->with_phase > 1 ||
      !all_within(harmonics->position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "harmonics hold a number that is not finite or out of range.");
  room_begin_harmonics(room, *harmonics);
  return accept(reason);
}

void forget_probe(sandglass_room* handle) {
  Room* room = &handle->room;
  if (room->probe == nullptr) return;
  room->probe->confidence = 0;
  room_drop_probe_unit(room);
  ++handle->version;
}

__attribute__((noinline)) void run_probe(Room* room) {
  while (room_probe_units_left(*room) > 0) room->probe->run(room);
}

}  // namespace

extern const Capability k_room_capability = {.begin_frame = begin_frame,
                                             .next = next,
                                             .run = run,
                                             .forecast = forecast,
                                             .under_way = under_way,
                                             .end_frame = end_frame};

}  // namespace sandglass

using namespace sandglass;

void sandglass_room_desc_default(sandglass_room_desc* desc) {
  if (desc == nullptr) return;
  *desc = {sizeof *desc, 0, 180.0f, 0.1f, 0, 0};
}

sandglass_status sandglass_room_bytes(const sandglass_room_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_room_create(const sandglass_room_desc* desc, void* block, uint64_t bytes,
                                       sandglass_room** room, const char** reason) {
  return create_in<Maker>(desc, block, bytes, room, "room is NULL: pass where to store it.", reason);
}

void sandglass_room_reset(sandglass_room* room) {
  if (room != nullptr) {
    room_reset(&room->room);
    ++room->version;
  }
}

sandglass_status sandglass_room_set_image(sandglass_room* room, const sandglass_camera_image* image, int32_t* taken,
                                          const char** reason) {
  if (taken != nullptr) *taken = 0;
  if (room == nullptr) return refuse(reason, "room is NULL: pass the room that sandglass_room_create made.");
  if (const sandglass_status status = check_image(&room->room, image, reason)) return status;
  const ExactFloatingPoint exact;
  const bool took = take_whole(room, *image);
  if (taken != nullptr) *taken = took ? 1 : 0;
  return accept(reason);
}

sandglass_status sandglass_room_move(sandglass_room* room, const float rotation[4], const float translation[3],
                                     const char** reason) {
  if (room == nullptr || rotation == nullptr || translation == nullptr)
    return refuse(reason, "room, rotation or translation is NULL: pass all three.");
  if (!all_within(translation, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "translation is not finite or beyond 1000 m: keep the world near its origin.");
  const ExactFloatingPoint exact;
  if (!move(&room->room, rotation, translation))
    return refuse(reason, "rotation is not one about the y axis: gravity stays where it is; turn the world about y.");
  ++room->version;
  return accept(reason);
}

void sandglass_room_place_default(sandglass_room_place* place) { empty_struct(place); }

sandglass_status sandglass_room_get(const sandglass_room* room, const sandglass_room_place* place,
                                    sandglass_room_light* light, const char** reason) {
  if (room == nullptr || place == nullptr || light == nullptr)
    return refuse(reason, "room, place or light is NULL: pass the room, a place and the struct to fill.");
  if (place->struct_size != sizeof *place)
    return refuse(reason, "place.struct_size is not that of this library: start from sandglass_room_place_default.");
  if (!can_fill(light)) return refuse(reason, "light.struct_size is not set: set it to sizeof(sandglass_room_light).");
  if (!all_within(place->position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "place.position is not finite or beyond 1000 m: pass where the object stands.");
  const sandglass_estimator_light* estimate = place->network;
  if (estimate != nullptr && (estimate->struct_size < sizeof *estimate || !all_finite(estimate->direction, 3) ||
                              !within(estimate->confidence, 0.0f, 1.0f) || !within(estimate->contrast, 0.0f, 1.0f)))
    return refuse(reason, "place.network is not one of sandglass_estimator_get: pass it as it was filled, or NULL.");
  const sandglass_room_light* shown = place->shown;
  if (shown != nullptr && shown->struct_size >= sizeof *shown &&
      (!all_within(shown->main_direction, 3, -1.01f, 1.01f) || !is_finite(shown->main_share)))
    return refuse(reason, "place.shown holds a main light that is none: pass what sandglass_room_fade moves, or NULL.");
  if (place->floor != nullptr && !all_within(place->floor, 3, 0.0f, 1e6f))
    return refuse(reason, "place.floor is not three numbers of 0..1e6: pass linear RGB, or NULL.");
  if (place->normal == nullptr && place->along != nullptr)
    return refuse(reason, "place.along is given without a normal: pass both, or neither.");
  constexpr float k_along[3] = {1, 0, 0};
  double axes[3][3];
  const char* wrong = place->normal == nullptr
                          ? nullptr
                          : plane_axes(place->normal, place->along != nullptr ? place->along : k_along, axes);
  if (wrong != nullptr) return refuse(reason, wrong);
  sandglass_room_place at = *place;
  if (shown != nullptr && shown->struct_size < sizeof *shown) at.shown = nullptr;  // nothing is shown yet
  const ExactFloatingPoint exact;
  estimate_at(room->room, at, light);
  return accept(reason);
}

float sandglass_room_exposure(const sandglass_room_light* light, const sandglass_camera_image* image) {
  if (light == nullptr || image == nullptr) return 0.0f;
  if (light->struct_size < sizeof *light || image->struct_size != sizeof *image) return 1.0f;
  const float exposure = image->exposure * light->white;
  return light->exposure_known != 0 && image->exposure > 0 && is_finite(exposure) ? exposure : 1.0f;
}

void sandglass_cube_default(sandglass_cube* cube) {
  if (!empty_struct(cube)) return;
  cube->orientation[3] = cube->confidence = 1;
}

void sandglass_harmonics_default(sandglass_harmonics* harmonics) {
  if (!empty_struct(harmonics)) return;
  harmonics->main_direction[1] = harmonics->confidence = 1;
}

sandglass_status sandglass_room_set_cube(sandglass_room* room, const sandglass_cube* cube, const char** reason) {
  if (room == nullptr) return refuse(reason, "room is NULL: pass the room that sandglass_room_create made.");
  if (cube == nullptr) {
    forget_probe(room);
    return accept(reason);
  }
  const ExactFloatingPoint exact;
  const sandglass_status status = begin_cube(&room->room, cube, reason);
  if (status != SANDGLASS_OK) return status;
  ++room->version;
  if (cube->in_frame != 0) return status;
  run_probe(&room->room);
  if (cube->confidence > 0 && !(room->room.probe->confidence > 0))
    return refuse(reason, "no texel of the cube is a number of 0..65000: pass the texture when it has been drawn.");
  return status;
}

sandglass_status sandglass_room_get_cube(const sandglass_room* room, const float position[3], float height,
                                         uint32_t face, uint32_t left_handed, uint16_t* texels, const char** reason) {
  if (room == nullptr || position == nullptr || texels == nullptr)
    return refuse(reason, "room, position or texels is NULL: pass the room, a place and 4 * 32 * 32 halves.");
  if (room->room.texels == nullptr)
    return refuse(reason, "room keeps no reflections: create it with desc.reflections = 1.");
  if (face > 5 || left_handed > 1) return refuse(reason, "face is not in 0..5, or left_handed is neither 0 nor 1.");
  if (!all_within(position, 3, -SANDGLASS_COORDINATE_LIMIT, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "position is not finite or beyond 1000 m: pass where the object is.");
  if (!within(height, 0.0f, SANDGLASS_COORDINATE_LIMIT))
    return refuse(reason, "height is not in 0..1000 m: pass how far above its floor the position is.");
  const ExactFloatingPoint exact;
  face_at(room->room, position, height, face, left_handed != 0, texels);
  return accept(reason);
}

sandglass_status sandglass_room_set_harmonics(sandglass_room* room, const sandglass_harmonics* harmonics,
                                              const char** reason) {
  if (room == nullptr) return refuse(reason, "room is NULL: pass the room that sandglass_room_create made.");
  if (harmonics == nullptr) {
    forget_probe(room);
    return accept(reason);
  }
  const ExactFloatingPoint exact;
  const sandglass_status status = begin_harmonics(&room->room, harmonics, reason);
  if (status != SANDGLASS_OK) return status;
  ++room->version;
  if (harmonics->in_frame == 0) run_probe(&room->room);
  return status;
}

int32_t sandglass_room_probe_fit(const sandglass_room* room, uint32_t* turn_deg, int32_t* mirrored) {
  if (room == nullptr || turn_deg == nullptr || mirrored == nullptr) return 0;
  uint32_t quarters = 0;
  bool mirror = false;
  const RoomProbe* probe = room->room.probe;
  if (probe == nullptr || !(probe->confidence > 0) || !room_probe_fit(room->room, &quarters, &mirror)) return 0;
  *turn_deg = 90 * quarters;
  *mirrored = mirror ? 1 : 0;
  return 1;
}

uint64_t sandglass_room_hash(const sandglass_room* room) {
  if (room == nullptr) return 0;
  const Room& r = room->room;
  uint64_t hash = hash_bytes(r.parts, sizeof r.parts);
  hash = hash_with(hash, hash_bytes(r.centre, sizeof r.centre));
  const double numbers[3] = {r.yaw, r.scale, r.light};
  hash = hash_with(hash, hash_bytes(numbers, sizeof numbers));
  hash = hash_with(hash, hash_bytes(r.balance, sizeof r.balance));
  if (r.lamps[0].images > 0) hash = hash_with(hash, hash_bytes(r.lamps, sizeof r.lamps));
  if (r.texels != nullptr) hash = hash_with(hash, hash_bytes(r.texels, sizeof *r.texels * k_cube_texels));
  if (r.probe != nullptr && r.probe->confidence > 0)
    hash = hash_with(hash, hash_bytes(r.probe->parts, sizeof r.probe->parts));
  if (r.probe != nullptr && r.probe->confidence > 0 && luminance(r.probe->far.irradiance) > 0)
    hash = hash_with(hash, hash_bytes(&r.probe->far, sizeof r.probe->far));
  return hash_with(hash, r.images);
}

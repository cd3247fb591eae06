// Thin C++ owner types over the C API: the same functions, with memory owned, pointers and counts joined, and status
// and reason in one value. Header-only, C++17, no exceptions, no RTTI.
//
// Everything that the C headers promise holds here. Memory is allocated by create, from_*, sample_*, save and box_body
// alone, none of which is called in a frame. Each owner type gives its C handle by get(), for every function that has no
// short form here. One that nothing was created in yet is empty: see the C API's rule for NULL.
//
//   sandglass_scene_desc desc = sandglass::scene_desc();
//   desc.granular.particle_capacity = 1000;
//   sandglass::Scene scene;
//   if (sandglass::Status status = scene.create(desc); !status) return fail(status.reason);
#ifndef SANDGLASS_SANDGLASS_HPP
#define SANDGLASS_SANDGLASS_HPP

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
#if defined(__has_include)
#if __has_include(<version>)
#include <version>
#endif
#endif
#if defined(__cpp_lib_span)
#include <span>
#endif

#include "sandglass/camera.h"
#include "sandglass/cast.h"
#include "sandglass/estimator.h"
#include "sandglass/owned.hpp"
#include "sandglass/pile_shadow.h"
#include "sandglass/relief.h"
#include "sandglass/renderers.h"
#include "sandglass/room.h"
#include "sandglass/sampling.hpp"
#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"
#include "sandglass/skin.h"

namespace sandglass {
// The inline namespace keeps these inline functions apart from the library's own symbols in one static link.
inline namespace cpp {

// Structs with their defaults and struct_size filled in.
inline sandglass_scene_desc scene_desc() { return filled(sandglass_scene_desc_default); }
inline sandglass_frame_input frame_input(float time_step = 0.0f, uint64_t budget_ns = 0) {
  sandglass_frame_input input = filled(sandglass_frame_input_default);
  input.time_step = time_step;
  input.budget_ns = budget_ns;
  return input;
}
inline sandglass_frame_report frame_report() {
  sandglass_frame_report report{};
  report.struct_size = sizeof report;
  return report;
}
inline sandglass_box_desc box_desc() { return filled(sandglass_box_desc_default); }
inline sandglass_body body() { return filled(sandglass_body_default); }

// A rotation as a quaternion (x, y, z, w).
using Rotation = std::array<float, 4>;
// The rotation by `angle` radians about the axis (x, y, z), of any length above 0. An axis without length gives the
// identity.
inline Rotation rotation_about(float x, float y, float z, float angle) {
  const float axis[3] = {x, y, z};
  Rotation rotation{};
  sandglass_rotation_about(axis, angle, rotation.data());
  return rotation;
}

// Colliders at rest and unrotated; set `rotation` and the velocities afterwards for others. Metres.
inline sandglass_collider collider(sandglass_shape shape, float x, float y, float z) {
  sandglass_collider c = filled(sandglass_collider_default);
  c.shape = shape;
  c.position[0] = x;
  c.position[1] = y;
  c.position[2] = z;
  return c;
}
inline sandglass_collider floor_at(float height) { return collider(SANDGLASS_SHAPE_HALF_SPACE, 0.0f, height, 0.0f); }
inline sandglass_collider sphere(float x, float y, float z, float radius) {
  sandglass_collider c = collider(SANDGLASS_SHAPE_SPHERE, x, y, z);
  c.size[0] = radius;
  return c;
}
inline sandglass_collider capsule(float x, float y, float z, float radius, float half_length) {
  sandglass_collider c = collider(SANDGLASS_SHAPE_CAPSULE, x, y, z);
  c.size[0] = radius;
  c.size[1] = half_length;
  return c;
}
inline sandglass_collider box(float x, float y, float z, float half_x, float half_y, float half_z) {
  sandglass_collider c = collider(SANDGLASS_SHAPE_BOX, x, y, z);
  c.size[0] = half_x;
  c.size[1] = half_y;
  c.size[2] = half_z;
  return c;
}

// A nozzle that pours straight down. Metres, m/s.
inline sandglass_emitter emitter(float x, float y, float z, float radius, float speed,
                                 uint32_t grains_per_particle = 0) {
  sandglass_emitter e = filled(sandglass_emitter_default);
  e.position[0] = x;
  e.position[1] = y;
  e.position[2] = z;
  e.radius = radius;
  e.speed = speed;
  e.grains_per_particle = grains_per_particle;
  return e;
}

// A box as a rigid body, by sandglass_box_body: its particles, what Scene::add_body takes, and the box's collider.
struct BoxBody {
  // Three floats each, metres.
  std::vector<float> particles;
  // What Scene::add_body takes.
  sandglass_body body{};
  // What it was made from.
  sandglass_box_desc desc{};

  // The box at a pose: keeps grains out, and says where its mesh is drawn.
  sandglass_collider collider(const sandglass_body_pose& pose) const {
    sandglass_collider c{};
    sandglass_box_collider(&desc, &pose, &c);
    return c;
  }
};

// Fills *box; its body.particle_positions point into box->particles. `density` over that of packed sand. Fails like
// sandglass_box_body.
inline Status box_body(const std::array<float, 3>& half_extents, float particle_radius,
                       const std::array<float, 3>& position, float density, BoxBody* box,
                       const Rotation& rotation = {0.0f, 0.0f, 0.0f, 1.0f}) {
  sandglass_box_desc& desc = box->desc = box_desc();
  std::copy(half_extents.begin(), half_extents.end(), desc.half_extents);
  std::copy(position.begin(), position.end(), desc.position);
  std::copy(rotation.begin(), rotation.end(), desc.rotation);
  desc.particle_radius = particle_radius;
  desc.density = density;
  uint32_t count = 0;
  if (const Status status = call(sandglass_box_count, &desc, &count); !status) return status;
  box->particles.resize(3 * static_cast<std::size_t>(count));
  return call(sandglass_box_body, &desc, box->particles.data(), count, &box->body);
}

// A scene and, unless the app lends it, the block it lives in. Movable, not copyable.
class Scene : public Owned<sandglass_scene> {
 public:
  // The bytes that a scene of this description needs; 0 when the description is not valid (create says why).
  static uint64_t bytes(const sandglass_scene_desc& desc) {
    uint64_t need = 0;
    return sandglass_scene_bytes(&desc, &need, nullptr) == SANDGLASS_OK ? need : 0;
  }

  // See sandglass_scene_create.
  Status create(const sandglass_scene_desc& desc) {
    return create_of(sandglass_scene_bytes, sandglass_scene_create, &desc);
  }
  // Makes the scene in a block of the app, aligned to SANDGLASS_BLOCK_ALIGNMENT, which must outlive it.
  Status create_in(const sandglass_scene_desc& desc, void* block, uint64_t bytes) {
    return create_at(block, bytes, sandglass_scene_create, &desc);
  }
#if defined(__cpp_lib_span)
  // The same, in a span.
  Status create_in(const sandglass_scene_desc& desc, std::span<std::byte> block) {
    return create_in(desc, block.data(), block.size());
  }
#endif

  // Adds particles and grains at rest. For moving ones: sandglass_scene_add(get(), ...).
  Status add(Points particles, Points grains = {}) {
    const sandglass_points sand = {particles.xyz, nullptr, particles.count}, fine = {grains.xyz, nullptr, grains.count};
    return call(sandglass_scene_add, get(), &sand, &fine);
  }
  // Removes the sand inside a shape; the counts may be null.
  Status remove(const sandglass_collider& region, uint32_t* particles = nullptr, uint32_t* grains = nullptr) {
    return call(sandglass_scene_remove, get(), &region, particles, grains);
  }
  // Adds a rigid body; *index, which may be null, is its number.
  Status add_body(const sandglass_body& body, uint32_t* index = nullptr) {
    return call(sandglass_scene_add_body, get(), &body, index);
  }
  // See sandglass_scene_held_collider.
  bool held_collider(uint32_t index, sandglass_collider* held) const {
    return sandglass_scene_held_collider(get(), index, held) != 0;
  }
  // See sandglass_scene_body_pose.
  sandglass_body_pose body_pose(uint32_t index) const { return sandglass_scene_body_pose(get(), index); }
  // See sandglass_scene_has_body.
  bool has_body(uint32_t index) const { return sandglass_scene_has_body(get(), index) != 0; }
  // See sandglass_scene_remove_body.
  Status remove_body(uint32_t index) { return call(sandglass_scene_remove_body, get(), index); }
  // See sandglass_scene_set_body.
  Status set_body(uint32_t index, const sandglass_body_pose& pose) {
    return call(sandglass_scene_set_body, get(), index, &pose);
  }
  // At a point of the world, 3 floats such as sandglass_ray_hit::point, by default the centre of mass: see
  // sandglass_scene_push_body.
  Status push_body(uint32_t index, const std::array<float, 3>& impulse, const float* point = nullptr) {
    return call(sandglass_scene_push_body, get(), index, impulse.data(), point);
  }
  // See sandglass_scene_ray. `what` is SANDGLASS_HIT_NOTHING where nothing was hit.
  sandglass_ray_hit ray(const std::array<float, 3>& origin, const std::array<float, 3>& direction, float reach) const {
    sandglass_ray_hit hit{};
    sandglass_scene_ray(get(), origin.data(), direction.data(), reach, &hit);
    return hit;
  }
  // See sandglass_scene_set_boundary.
  Status set_boundary(Points samples) { return call(sandglass_scene_set_boundary, get(), samples.xyz, samples.count); }
  // See sandglass_scene_set_friction.
  Status set_friction(float static_friction, float kinetic_friction) {
    return call(sandglass_scene_set_friction, get(), static_friction, kinetic_friction);
  }

  // One frame; see sandglass_scene_frame. `report` may be null.
  Status frame(const sandglass_frame_input& input, sandglass_frame_report* report = nullptr) {
    if (report != nullptr) report->struct_size = sizeof *report;
    return call(sandglass_scene_frame, get(), &input, report);
  }

  // Moves everything rigidly: see sandglass_scene_move.
  Status move(const Rotation& rotation, const std::array<float, 3>& translation) {
    return call(sandglass_scene_move, get(), rotation.data(), translation.data());
  }
  // See sandglass_scene_set_gravity.
  Status set_gravity(const std::array<float, 3>& gravity) {
    return call(sandglass_scene_set_gravity, get(), gravity.data());
  }
  // The state as bytes, and back: see sandglass_scene_save.
  Status save(std::vector<std::byte>* data) {
    return saved(get(), sandglass_scene_save_bytes, sandglass_scene_save, data);
  }
  // See sandglass_scene_restore.
  Status restore(const void* data, uint64_t bytes) { return call(sandglass_scene_restore, get(), data, bytes); }
  // The same, from what save wrote.
  Status restore(const std::vector<std::byte>& data) { return restore(data.data(), data.size()); }

  // See sandglass_scene_reset.
  void reset() { sandglass_scene_reset(get()); }
  // See sandglass_scene_isa.
  sandglass_isa isa() const { return sandglass_scene_isa(get()); }
  // See sandglass_scene_hash.
  uint64_t hash() const { return sandglass_scene_hash(get()); }
};

// ---- estimate
inline sandglass_estimator_desc estimator_desc() { return filled(sandglass_estimator_desc_default); }
inline sandglass_camera_image camera_image() { return filled(sandglass_camera_image_default); }

// An estimator and the block it lives in. Movable, not copyable. The network's file belongs to the app, and must
// outlive it.
class Estimator : public Owned<sandglass_estimator> {
 public:
  // No estimator yet: create makes it.
  Estimator() = default;
  // Takes the estimator and its block over.
  Estimator(Estimator&&) noexcept = default;
  // Gives back what sandglass_estimator_release names.
  ~Estimator() { sandglass_estimator_release(get()); }
  // Takes the estimator and its block over; the one that was here is released.
  Estimator& operator=(Estimator&& other) noexcept {
    if (this == &other) return *this;
    sandglass_estimator_release(get());
    Owned::operator=(std::move(other));
    return *this;
  }

  // See sandglass_estimator_create.
  Status create(const sandglass_estimator_desc& desc) {
    Estimator made;
    const Status status = made.create_of(sandglass_estimator_bytes, sandglass_estimator_create, &desc);
    if (status) *this = std::move(made);
    return status;
  }

  // Without a scene: takes the image if one is due, then runs units until the estimate is complete.
  Status estimate(const sandglass_camera_image& image) {
    const Status status = call(sandglass_estimator_set_image, get(), &image, nullptr);
    if (status) sandglass_estimator_run(get(), UINT32_MAX);
    return status;
  }
  // See sandglass_estimator_get.
  sandglass_estimator_light light() const {
    return reported<sandglass_estimator_light>(sandglass_estimator_get, get());
  }
  // See sandglass_estimator_turn.
  Status turn(const Rotation& rotation) { return call(sandglass_estimator_turn, get(), rotation.data()); }
  // See sandglass_estimator_reset.
  void reset() { sandglass_estimator_reset(get()); }
};

// ---- room, relief

inline sandglass_room_desc room_desc() { return filled(sandglass_room_desc_default); }

// A cube with the defaults: see sandglass_cube.
inline sandglass_cube cube() { return filled(sandglass_cube_default); }

// Harmonics with the defaults: see sandglass_harmonics.
inline sandglass_harmonics harmonics() { return filled(sandglass_harmonics_default); }

// Where light is asked for: see sandglass_room_place. `shown` and `network` may be NULL.
inline sandglass_room_place room_place(const float position[3], const sandglass_room_light* shown = nullptr,
                                       const sandglass_estimator_light* network = nullptr) {
  sandglass_room_place place = filled(sandglass_room_place_default);
  for (int k = 0; k < 3; ++k) place.position[k] = position[k];
  place.shown = shown;
  place.network = network;
  return place;
}

// What the camera has seen of a room, and the block it lives in. Movable, not copyable.
class Room : public Owned<sandglass_room> {
 public:
  // See sandglass_room_create.
  Status create(const sandglass_room_desc& desc = room_desc()) {
    return create_of(sandglass_room_bytes, sandglass_room_create, &desc);
  }

  // See sandglass_room_set_image.
  Status set_image(const sandglass_camera_image& image) {
    return call(sandglass_room_set_image, get(), &image, nullptr);
  }
  // The light at a place. Where it fails, the light has struct_size 0, and *status, which may be null, says why. See
  // sandglass_room_get.
  sandglass_room_light light_at(const sandglass_room_place& place, Status* status = nullptr) const {
    sandglass_room_light light{};
    light.struct_size = sizeof light;
    const Status got = call(sandglass_room_get, get(), &place, &light);
    if (!got) light = {};
    if (status != nullptr) *status = got;
    return light;
  }
  // The same; `shown`, `network` and `status` may be null.
  sandglass_room_light light_at(const float position[3], const sandglass_room_light* shown = nullptr,
                                const sandglass_estimator_light* network = nullptr, Status* status = nullptr) const {
    return light_at(room_place(position, shown, network), status);
  }
  // A face of what a shiny object reflects, 4 * 32 * 32 halves. See sandglass_room_get_cube.
  Status get_cube(const float position[3], float height, uint32_t face, uint16_t* texels,
                  bool left_handed = false) const {
    return call(sandglass_room_get_cube, get(), position, height, face, left_handed ? 1u : 0u, texels);
  }
  // See sandglass_room_set_cube.
  Status set_cube(const sandglass_cube& cube) { return call(sandglass_room_set_cube, get(), &cube); }
  // See sandglass_room_set_harmonics.
  Status set_harmonics(const sandglass_harmonics& harmonics) {
    return call(sandglass_room_set_harmonics, get(), &harmonics);
  }
  // See sandglass_room_move.
  Status move(const Rotation& rotation, const float translation[3]) {
    return call(sandglass_room_move, get(), rotation.data(), translation);
  }
  // See sandglass_room_save.
  Status save(std::vector<std::byte>* data) const {
    return saved(get(), sandglass_room_save_bytes, sandglass_room_save, data);
  }
  // See sandglass_room_restore.
  Status restore(const void* data, uint64_t bytes) { return call(sandglass_room_restore, get(), data, bytes); }
  // The same, from what save wrote.
  Status restore(const std::vector<std::byte>& data) { return restore(data.data(), data.size()); }
  // See sandglass_room_reset.
  void reset() { sandglass_room_reset(get()); }
  // See sandglass_room_hash.
  uint64_t hash() const { return sandglass_room_hash(get()); }
};

// The defaults of relief.h.
inline sandglass_relief_desc relief_desc() { return filled(sandglass_relief_desc_default); }
inline sandglass_depth_image depth_image() { return filled(sandglass_depth_image_default); }

// Heights of the real place, and the block they live in. Movable, not copyable.
class Relief : public Owned<sandglass_relief> {
 public:
  // See sandglass_relief_create.
  Status create(const sandglass_relief_desc& desc = relief_desc()) {
    return create_of(sandglass_relief_bytes, sandglass_relief_create, &desc);
  }
  // See sandglass_relief_set_plane.
  Status set_plane(const float position[3], const Rotation& rotation) {
    return call(sandglass_relief_set_plane, get(), position, rotation.data());
  }
  // See sandglass_relief_set_meshes.
  Status set_meshes(const sandglass_cast_mesh* meshes, uint32_t count) {
    return call(sandglass_relief_set_meshes, get(), meshes, count);
  }
  // See sandglass_relief_set_outline.
  Status set_outline(const float* corners, const uint32_t* counts, uint32_t rings) {
    return call(sandglass_relief_set_outline, get(), corners, counts, rings);
  }
  // Without a scene: see sandglass_relief_run.
  uint32_t run(uint32_t units = UINT32_MAX) { return sandglass_relief_run(get(), units); }
  // See sandglass_relief_set_image.
  Status set_image(const sandglass_depth_image& image) {
    return call(sandglass_relief_set_image, get(), &image, nullptr);
  }
  // See sandglass_relief_get_heights.
  sandglass_heights heights() const { return reported<sandglass_heights>(sandglass_relief_get_heights, get()); }
  // All heights, or what the last version has changed. See sandglass_relief_save.
  Status save(std::vector<std::byte>* data, bool whole = true) const {
    data->resize(static_cast<std::size_t>(sandglass_relief_save_bytes(get(), whole ? 1 : 0)));
    uint64_t written = 0;
    return call(sandglass_relief_save, get(), whole ? 1u : 0u, data->data(), uint64_t{data->size()}, &written);
  }
  // See sandglass_relief_restore.
  Status restore(const std::vector<std::byte>& data) {
    return call(sandglass_relief_restore, get(), data.data(), uint64_t{data.size()});
  }
  // See sandglass_relief_reset.
  void reset() { sandglass_relief_reset(get()); }
  // See sandglass_relief_hash.
  uint64_t hash() const { return sandglass_relief_hash(get()); }
};

// A relief as sand meets it, at the pose of its plane. The relief must outlive it.
inline sandglass_collider relief_collider(const Relief& relief) {
  sandglass_collider c = collider(SANDGLASS_SHAPE_RELIEF, 0.0f, 0.0f, 0.0f);
  sandglass_relief_get_collider(relief.get(), &c);
  return c;
}

// ---- shadows

inline sandglass_shadow_desc shadow_desc(const void* asset = nullptr, uint64_t bytes = 0) {
  sandglass_shadow_desc desc = filled(sandglass_shadow_desc_default);
  desc.asset = asset;
  desc.asset_bytes = bytes;
  return desc;
}
inline sandglass_skin_desc skin_desc(const sandglass_granular_desc& granular) {
  sandglass_skin_desc desc;
  sandglass_skin_desc_default(&desc, &granular);
  return desc;
}
inline sandglass_pile_shadow_desc pile_shadow_desc() { return filled(sandglass_pile_shadow_desc_default); }
inline sandglass_cast_desc cast_desc() { return filled(sandglass_cast_desc_default); }
// The real floor y = 0.
inline sandglass_cast_plane cast_plane() { return filled(sandglass_cast_plane_default); }
// No triangles yet.
inline sandglass_cast_mesh cast_mesh() { return filled(sandglass_cast_mesh_default); }

// The shadows of one object and the block they live in. Movable, not copyable. The baked file may go after create.
class Shadow : public Owned<sandglass_shadow> {
 public:
  // See sandglass_shadow_create.
  Status create(const sandglass_shadow_desc& desc) {
    return create_of(sandglass_shadow_bytes, sandglass_shadow_create, &desc);
  }

  // The direction towards a light in the object's frame: see sandglass_shadow_set_light.
  Status set_light(const std::array<float, 3>& direction, float irradiance = 1.0f, uint32_t light = 0) {
    return call(sandglass_shadow_set_light, get(), light, direction.data(), irradiance);
  }
  // Without a scene: runs at most `units` work units, by default all; returns how many it ran.
  uint32_t run(uint32_t units = UINT32_MAX) {
    sandglass_shadow* const handle = get();
    return sandglass_shadow_run(&handle, 1, units);
  }
  // See sandglass_shadow_get_texture.
  sandglass_texture texture(uint32_t light = 0) const {
    return reported<sandglass_texture>(sandglass_shadow_get_texture, get(), light);
  }
  // See sandglass_shadow_evaluated.
  uint32_t evaluated(uint32_t light = 0) const { return sandglass_shadow_evaluated(get(), light); }
  // The light of the room: see sandglass_shadow_set_cells.
  Status set_cells(const std::array<float, SANDGLASS_LIGHT_CELLS>& cells, float yaw = 0.0f) {
    return call(sandglass_shadow_set_cells, get(), cells.data(), yaw);
  }
  // The same, for the arrays of sandglass_room_light.
  Status set_cells(const float (&cells)[SANDGLASS_LIGHT_CELLS], float yaw = 0.0f) {
    return call(sandglass_shadow_set_cells, get(), cells, yaw);
  }
  // See sandglass_shadow_get_ambient.
  sandglass_texture ambient() const { return reported<sandglass_texture>(sandglass_shadow_get_ambient, get()); }
  // See sandglass_shadow_hash.
  uint64_t hash() const { return sandglass_shadow_hash(get()); }
};

// What a baked file says of itself. Fails like sandglass_shadow_inspect.
inline Status inspect_shadow(const void* asset, uint64_t asset_bytes, sandglass_shadow_info* info) {
  info->struct_size = sizeof *info;
  return call(sandglass_shadow_inspect, asset, asset_bytes, info);
}

// How the vertices of the app's mesh see the room past the object itself, nine floats each: see
// sandglass_shadow_transfer. The file is that of `desc`. Fails like the C function, and where there is not one normal
// for each position; *transfer is then empty.
inline Status shadow_transfer(const sandglass_shadow_desc& desc, Points positions, Points normals,
                              std::vector<float>* transfer) {
  transfer->resize(9 * static_cast<std::size_t>(positions.count));
  Status status = {SANDGLASS_ERROR_INVALID_ARGUMENT,
                   "positions and normals are not equally many: pass one normal each"};
  if (positions.count == normals.count)
    status = call(sandglass_shadow_transfer, desc.asset, desc.asset_bytes, positions.xyz, normals.xyz, positions.count,
                  transfer->data());
  if (!status) transfer->clear();
  return status;
}

// The shadows of any triangles on a plane and the block they live in. Movable, not copyable.
class Cast : public Owned<sandglass_cast> {
 public:
  // See sandglass_cast_create.
  Status create(const sandglass_cast_desc& desc) {
    return create_of(sandglass_cast_bytes, sandglass_cast_create, &desc);
  }

  // See sandglass_cast_set_plane.
  Status set_plane(const sandglass_cast_plane& plane) { return call(sandglass_cast_set_plane, get(), &plane); }
  // See sandglass_cast_set_meshes.
  Status set_meshes(const sandglass_cast_mesh* meshes, uint32_t count) {
    return call(sandglass_cast_set_meshes, get(), meshes, count);
  }
  // See sandglass_cast_set_light.
  Status set_light(const std::array<float, 3>& direction, float angular_diameter = 0) {
    return call(sandglass_cast_set_light, get(), direction.data(), angular_diameter);
  }
  // See sandglass_cast_set_cells.
  Status set_cells(const std::array<float, SANDGLASS_LIGHT_CELLS>& cells) {
    return call(sandglass_cast_set_cells, get(), cells.data());
  }
  // The same, for the arrays of sandglass_room_light.
  Status set_cells(const float (&cells)[SANDGLASS_LIGHT_CELLS]) { return call(sandglass_cast_set_cells, get(), cells); }
  // Without a scene: see sandglass_cast_run.
  uint32_t run(uint32_t units = UINT32_MAX) {
    sandglass_cast* const handle = get();
    return sandglass_cast_run(&handle, 1, units);
  }
  // See sandglass_cast_get_texture.
  sandglass_texture texture() const { return reported<sandglass_texture>(sandglass_cast_get_texture, get()); }
  // See sandglass_cast_get_ambient.
  sandglass_texture ambient() const { return reported<sandglass_texture>(sandglass_cast_get_ambient, get()); }
  // See sandglass_cast_get_report.
  sandglass_cast_report report() const { return reported<sandglass_cast_report>(sandglass_cast_get_report, get()); }
};

// The surface of a scene's sand as a mesh and the block it lives in. Movable, not copyable.
class Skin : public Owned<sandglass_skin> {
 public:
  // See sandglass_skin_create.
  Status create(const sandglass_skin_desc& desc) {
    return create_of(sandglass_skin_bytes, sandglass_skin_create, &desc);
  }

  // See sandglass_skin_get_mesh.
  sandglass_skin_mesh mesh() const { return reported<sandglass_skin_mesh>(sandglass_skin_get_mesh, get()); }
  // See sandglass_skin_refresh.
  void refresh() { sandglass_skin_refresh(get()); }
  // See sandglass_skin_hash.
  uint64_t hash() const { return sandglass_skin_hash(get()); }
};

// The shadow of a scene's sand and the block it lives in. Movable, not copyable.
class PileShadow : public Owned<sandglass_pile_shadow> {
 public:
  // See sandglass_pile_shadow_create.
  Status create(const sandglass_pile_shadow_desc& desc) {
    return create_of(sandglass_pile_shadow_bytes, sandglass_pile_shadow_create, &desc);
  }

  // See sandglass_pile_shadow_set_light.
  Status set_light(const std::array<float, 3>& direction, float angular_diameter = 0) {
    return call(sandglass_pile_shadow_set_light, get(), direction.data(), angular_diameter);
  }
  // See sandglass_pile_shadow_set_cells.
  Status set_cells(const std::array<float, SANDGLASS_LIGHT_CELLS>& cells) {
    return call(sandglass_pile_shadow_set_cells, get(), cells.data());
  }
  // The same, for the arrays of sandglass_room_light.
  Status set_cells(const float (&cells)[SANDGLASS_LIGHT_CELLS]) {
    return call(sandglass_pile_shadow_set_cells, get(), cells);
  }
  // See sandglass_pile_shadow_set_ground.
  Status set_ground(const sandglass_heights& map) { return call(sandglass_pile_shadow_set_ground, get(), &map); }
  // See sandglass_pile_shadow_refresh.
  void refresh() { sandglass_pile_shadow_refresh(get()); }
  // Without a scene: see sandglass_pile_shadow_run.
  uint32_t run(Points spheres, float radius, uint32_t units = UINT32_MAX) {
    return sandglass_pile_shadow_run(get(), spheres.xyz, spheres.count, radius, units);
  }
  // See sandglass_pile_shadow_get_texture.
  sandglass_texture texture(sandglass_pile_shadow_part part = SANDGLASS_PILE_SHADOW_FLOOR) const {
    return reported<sandglass_texture>(sandglass_pile_shadow_get_texture, get(), part);
  }
  // See sandglass_pile_shadow_light_grains.
  void light_grains(Points grains, float radius, uint8_t* visibility) const {
    sandglass_pile_shadow_light_grains(get(), grains.xyz, grains.count, radius, visibility);
  }
  // See sandglass_pile_shadow_hash.
  uint64_t hash() const { return sandglass_pile_shadow_hash(get()); }
};

}  // namespace cpp
}  // namespace sandglass

#endif  // SANDGLASS_SANDGLASS_HPP

// Thin C++ owner types over sandglass.h: the same functions, with the block owned, the pointer-and-count pairs joined,
// and status and reason in one value. Header-only, C++17, no exceptions, no RTTI. Everything the C API promises holds
// here. Memory is allocated by Scene::create and by the sample_* functions, before the first frame, and by nothing
// else. Structs are the C API's own (sandglass_scene_desc, …).
//
//   sandglass_scene_desc desc = sandglass::scene_desc();
//   desc.granular.particle_capacity = 1000;
//   sandglass::Scene scene;
//   if (sandglass::Status status = scene.create(desc); !status) return fail(status.reason);
#ifndef SANDGLASS_SANDGLASS_HPP
#define SANDGLASS_SANDGLASS_HPP

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
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

#include "sandglass/light.h"
#include "sandglass/sandglass.h"

namespace sandglass {
// The inline namespace keeps these inline functions apart from the library's own symbols in one static link.
inline namespace cpp {

// A status code and its sentence. True when the call succeeded; `reason` is then null.
struct [[nodiscard]] Status {
  sandglass_status code = SANDGLASS_OK;
  const char* reason = nullptr;
  explicit operator bool() const { return code == SANDGLASS_OK; }
  const char* name() const { return sandglass_status_name(code); }
};

// A view of points or vectors, three floats each, in memory that the caller keeps for the duration of the call. Made
// from a pointer and a number of points, or from any contiguous container of floats (a trailing incomplete point is
// left out).
struct Points {
  const float* xyz = nullptr;
  uint32_t count = 0;
  Points() = default;
  Points(const float* first, uint32_t points) : xyz(first), count(points) {}
  template <class Container, class = decltype(static_cast<const float*>(std::declval<const Container&>().data()))>
  Points(const Container& floats) : xyz(floats.data()), count(static_cast<uint32_t>(floats.size() / 3)) {}
};

// A block aligned as the library wants it; empty when the heap has none.
struct ReleaseBlock {
  void operator()(std::byte* block) const { ::operator delete (block, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT}); }
};
using Block = std::unique_ptr<std::byte[], ReleaseBlock>;
inline Block allocate_block(uint64_t bytes) {
  return Block(static_cast<std::byte*>(
      ::operator new (static_cast<std::size_t>(bytes), std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT}, std::nothrow)));
}
inline Status no_memory() {
  return {SANDGLASS_ERROR_MEMORY_TOO_SMALL, "the heap has no block of the size that is needed"};
}

// Structs with their defaults and struct_size filled in.
inline sandglass_scene_desc scene_desc() {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  return desc;
}
inline sandglass_frame_input frame_input() {
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  return input;
}
inline sandglass_frame_report frame_report() {
  sandglass_frame_report report{};
  report.struct_size = sizeof report;
  return report;
}

// Colliders at rest and unrotated; set `rotation` and the velocities afterwards for others. Metres.
inline sandglass_collider collider(sandglass_shape shape, float x, float y, float z) {
  sandglass_collider c{};
  c.shape = shape;
  c.position[0] = x, c.position[1] = y, c.position[2] = z;
  c.rotation[3] = 1.0f;
  c.size[0] = c.size[1] = c.size[2] = 1.0f;
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
  c.size[0] = radius, c.size[1] = half_length;
  return c;
}
inline sandglass_collider box(float x, float y, float z, float half_x, float half_y, float half_z) {
  sandglass_collider c = collider(SANDGLASS_SHAPE_BOX, x, y, z);
  c.size[0] = half_x, c.size[1] = half_y, c.size[2] = half_z;
  return c;
}

// A scene and, unless the caller lends it, the block it lives in. Movable, not copyable; the C handle stays valid
// across a move because the block does not move. The functions below create must be called only on a scene that create
// made.
class Scene {
 public:
  Scene() = default;
  Scene(Scene&& other) noexcept : block_(std::move(other.block_)), scene_(std::exchange(other.scene_, nullptr)) {}
  Scene& operator=(Scene&& other) noexcept {
    block_ = std::move(other.block_);
    scene_ = std::exchange(other.scene_, nullptr);
    return *this;
  }

  // The bytes that a scene of this description needs; 0 when the description is not valid (create says why).
  static uint64_t bytes(const sandglass_scene_desc& desc) {
    uint64_t need = 0;
    return sandglass_scene_bytes(&desc, &need, nullptr) == SANDGLASS_OK ? need : 0;
  }

  // Allocates the scene's block, once and for all, and makes the scene in it. An existing scene is replaced on success
  // and kept on failure. Fails like sandglass_scene_create, or with MEMORY_TOO_SMALL when the heap has no such block.
  Status create(const sandglass_scene_desc& desc) {
    Status status;
    uint64_t need = 0;
    status.code = sandglass_scene_bytes(&desc, &need, &status.reason);
    if (!status) return status;
    Block block = allocate_block(need);
    if (block == nullptr) return no_memory();
    status = create_in(desc, block.get(), need);
    if (status) block_ = std::move(block);
    return status;
  }

  // Makes the scene in a block of the caller's, aligned to SANDGLASS_BLOCK_ALIGNMENT, which must outlive it.
  Status create_in(const sandglass_scene_desc& desc, void* block, uint64_t bytes) {
    Status status;
    sandglass_scene* scene = nullptr;
    status.code = sandglass_scene_create(&desc, block, bytes, &scene, &status.reason);
    if (!status) return status;
    block_.reset();
    scene_ = scene;
    return status;
  }
#if defined(__cpp_lib_span)
  Status create_in(const sandglass_scene_desc& desc, std::span<std::byte> block) {
    return create_in(desc, block.data(), block.size());
  }
#endif

  // True once create has succeeded.
  explicit operator bool() const { return scene_ != nullptr; }
  // The C handle, for every function of sandglass.h that has no short form here.
  sandglass_scene* get() const { return scene_; }

  // Adds particles and grains at rest. For moving ones: sandglass_granular_add(get(), …).
  Status add(Points particles, Points grains = {}) {
    Status status;
    status.code = sandglass_granular_add(scene_, particles.xyz, nullptr, particles.count, grains.xyz, nullptr,
                                         grains.count, &status.reason);
    return status;
  }
  Status set_boundary(Points samples) {
    Status status;
    status.code = sandglass_granular_set_boundary(scene_, samples.xyz, samples.count, &status.reason);
    return status;
  }
  Status set_friction(float static_friction, float kinetic_friction) {
    Status status;
    status.code = sandglass_granular_set_friction(scene_, static_friction, kinetic_friction, &status.reason);
    return status;
  }

  // One frame; see sandglass_scene_frame. `report` may be null.
  Status frame(const sandglass_frame_input& input, sandglass_frame_report* report = nullptr) {
    Status status;
    if (report != nullptr) report->struct_size = sizeof *report;
    status.code = sandglass_scene_frame(scene_, &input, report, &status.reason);
    return status;
  }

  void reset() { sandglass_scene_reset(scene_); }
  sandglass_isa isa() const { return sandglass_scene_isa(scene_); }
  uint64_t hash() const { return sandglass_scene_hash(scene_); }

 private:
  Block block_;  // empty when the caller lent the block
  sandglass_scene* scene_ = nullptr;
};

// ----------------------------------------------------------------------------------------------------------------
// light

inline sandglass_light_desc light_desc() {
  sandglass_light_desc desc;
  sandglass_light_desc_default(&desc);
  return desc;
}
inline sandglass_camera_image camera_image() {
  sandglass_camera_image image;
  sandglass_camera_image_default(&image);
  return image;
}

// The light of a room and the block it lives in. Movable, not copyable. The network's file stays the caller's, and must
// outlive it. The functions below create must be called only on a light that create made.
class Light {
 public:
  Light() = default;
  Light(Light&& other) noexcept : block_(std::move(other.block_)), light_(std::exchange(other.light_, nullptr)) {}
  ~Light() { release(); }
  Light& operator=(Light&& other) noexcept {
    if (this == &other) return *this;
    release();
    block_ = std::move(other.block_);
    light_ = std::exchange(other.light_, nullptr);
    return *this;
  }

  // Allocates the block, once and for all. Fails like sandglass_light_create, or with MEMORY_TOO_SMALL when the heap
  // has no such block; an existing light is then kept.
  Status create(const sandglass_light_desc& desc) {
    Status status;
    uint64_t need = 0;
    status.code = sandglass_light_bytes(&desc, &need, &status.reason);
    if (!status) return status;
    Block block = allocate_block(need);
    if (block == nullptr) return no_memory();
    sandglass_light* light = nullptr;
    status.code = sandglass_light_create(&desc, block.get(), need, &light, &status.reason);
    if (!status) return status;
    release();
    block_ = std::move(block);
    light_ = light;
    return status;
  }

  explicit operator bool() const { return light_ != nullptr; }
  // The C handle: for sandglass_frame_input::light, and every function of light.h that has no short form here.
  sandglass_light* get() const { return light_; }

  // Without a scene: takes the image if one is due, then runs units until the estimate is complete.
  Status estimate(const sandglass_camera_image& image) {
    Status status;
    status.code = sandglass_light_set_image(light_, &image, nullptr, &status.reason);
    if (status) sandglass_light_run(light_, UINT32_MAX);
    return status;
  }
  sandglass_light_estimate estimated() const {
    sandglass_light_estimate now{};
    now.struct_size = sizeof now;
    sandglass_light_get(light_, &now);
    return now;
  }

 private:
  void release() {
    if (light_ != nullptr) sandglass_light_release(light_);
  }

  Block block_;
  sandglass_light* light_ = nullptr;
};

// ----------------------------------------------------------------------------------------------------------------
// sampling

struct Box {
  float min[3];
  float max[3];
};

// Each fills *points, three floats a point, and allocates the result and the working memory for the duration of the
// call. `inside` is anything that can be called with a const float[3] and says whether that point lies in the volume.
// Fails like the C function of the same name; *points is then empty.

// What all of them share: working memory, room for the result, the run, and the result cut to its length.
template <class Run>
Status sample_into(std::vector<float>* points, uint32_t capacity, uint64_t scratch_bytes, Run run) {
  const Block scratch = allocate_block(scratch_bytes);
  if (scratch == nullptr) return no_memory();
  points->resize(3 * static_cast<std::size_t>(capacity));
  uint32_t count = 0;
  Status status;
  status.code = run(scratch.get(), points->data(), &count, &status.reason);
  points->resize(3 * static_cast<std::size_t>(status ? count : 0));
  return status;
}

// Anything callable as the C API's function pointer and its user pointer.
template <class Inside>
int call_inside(void* inside, const float point[3]) {
  return (*static_cast<Inside*>(inside))(point) ? 1 : 0;
}

// Sites of a hexagonal close packing: how a volume is filled with particles (distance 2r).
template <class Inside>
Status sample_lattice(const Box& box, float distance, Inside inside, std::vector<float>* points) {
  points->clear();
  Status status;
  uint64_t bytes = 0;
  uint32_t capacity = 0;
  status.code = sandglass_sample_lattice_capacity(box.min, box.max, distance, &capacity, &status.reason);
  if (status) status.code = sandglass_sample_lattice_bytes(box.min, box.max, distance, &bytes, &status.reason);
  if (!status) return status;
  return sample_into(points, capacity, bytes, [&](void* scratch, float* out, uint32_t* count, const char** reason) {
    return sandglass_sample_lattice(box.min, box.max, distance, call_inside<Inside>, &inside, nullptr, scratch, bytes,
                                    out, capacity, count, reason);
  });
}

// A Poisson-disk (blue-noise) set in a volume: how it is filled with grains. `options` null: the defaults.
template <class Inside>
Status sample_volume(const Box& box, float distance, Inside inside, std::vector<float>* points,
                     const sandglass_sample_options* options = nullptr) {
  points->clear();
  Status status;
  uint64_t bytes = 0;
  uint32_t capacity = 0;
  status.code = sandglass_sample_volume_capacity(box.min, box.max, distance, &capacity, &status.reason);
  if (status) status.code = sandglass_sample_volume_bytes(box.min, box.max, distance, capacity, &bytes, &status.reason);
  if (!status) return status;
  return sample_into(points, capacity, bytes, [&](void* scratch, float* out, uint32_t* count, const char** reason) {
    return sandglass_sample_volume(box.min, box.max, distance, call_inside<Inside>, &inside, options, scratch, bytes,
                                   out, capacity, count, reason);
  });
}

// A Poisson-disk set on a mesh's surface: boundary particles of a scanned room, say. `options` null: the defaults.
inline Status sample_surface(const sandglass_mesh& mesh, float distance, std::vector<float>* points,
                             const sandglass_sample_options* options = nullptr) {
  points->clear();
  Status status;
  uint64_t bytes = 0;
  uint32_t capacity = 0;
  status.code = sandglass_sample_surface_capacity(&mesh, distance, options, &capacity, &status.reason);
  if (status) status.code = sandglass_sample_surface_bytes(&mesh, distance, options, capacity, &bytes, &status.reason);
  if (!status) return status;
  return sample_into(points, capacity, bytes, [&](void* scratch, float* out, uint32_t* count, const char** reason) {
    return sandglass_sample_surface(&mesh, distance, options, scratch, bytes, out, capacity, count, reason);
  });
}

}  // namespace cpp
}  // namespace sandglass

#endif  // SANDGLASS_SANDGLASS_HPP

// Points in volumes and on meshes, inside tests and signed-distance fields: the C++ side of sampling.h and field.h.
#ifndef SANDGLASS_SAMPLING_HPP
#define SANDGLASS_SAMPLING_HPP

#include <algorithm>
#include <vector>

#include "sandglass/field.h"
#include "sandglass/owned.hpp"
#include "sandglass/sampling.h"
#include "sandglass/sand.h"

namespace sandglass {
inline namespace cpp {

// Structs with their defaults and struct_size filled in.
inline sandglass_sample_desc sample_desc() { return filled(sandglass_sample_desc_default); }
inline sandglass_field_desc field_desc() { return filled(sandglass_field_desc_default); }

// A box along the axes, metres.
struct Box {
  // The corner with the smallest coordinates.
  float min[3];
  // The corner with the largest.
  float max[3];
};

// Each fills *points, three floats a point, and allocates the result and the working memory for the duration of the
// call. `inside` is anything that can be called with a const float[3] and says whether that point lies in the volume.
// `desc` holds what else is not the default: seed, tries, metric, progress. Fails like sandglass_sample_points; *points
// is then empty.
inline Status sample_points(const sandglass_sample_desc& desc, std::vector<float>* points) {
  points->clear();
  uint64_t bytes = 0;
  uint32_t capacity = 0, count = 0;
  Status status = call(sandglass_sample_capacity, &desc, &capacity);
  if (status) status = call(sandglass_sample_bytes, &desc, capacity, &bytes);
  if (!status) return status;
  const Block scratch = allocate_block(bytes);
  if (scratch == nullptr) return no_memory();
  points->resize(3 * static_cast<std::size_t>(capacity));
  status = call(sandglass_sample_points, &desc, scratch.get(), bytes, points->data(), capacity, &count);
  points->resize(3 * static_cast<std::size_t>(count));
  return status;
}

// What the two volumes share.
template <class Inside>
Status sample_inside(const Box& box, float distance, Inside inside, sandglass_sample_desc desc,
                     std::vector<float>* points) {
  std::copy(box.min, box.min + 3, desc.bounds_min);
  std::copy(box.max, box.max + 3, desc.bounds_max);
  desc.distance = distance;
  desc.inside = [](void* test, const float point[3]) -> int32_t {
    return (*static_cast<Inside*>(test))(point) ? 1 : 0;
  };
  desc.inside_user = &inside;
  return sample_points(desc, points);
}

// Sites of a hexagonal close packing: how a volume is filled with particles (distance 2r).
template <class Inside>
Status sample_lattice(const Box& box, float distance, Inside inside, std::vector<float>* points,
                      sandglass_sample_desc desc = sample_desc()) {
  desc.method = SANDGLASS_SAMPLE_LATTICE;
  return sample_inside(box, distance, inside, desc, points);
}

// A Poisson-disk (blue-noise) set in a volume: how it is filled with grains.
template <class Inside>
Status sample_volume(const Box& box, float distance, Inside inside, std::vector<float>* points,
                     sandglass_sample_desc desc = sample_desc()) {
  desc.method = SANDGLASS_SAMPLE_VOLUME;
  return sample_inside(box, distance, inside, desc, points);
}

// A Poisson-disk set on a mesh's surface: boundary particles of a scanned room, say.
inline Status sample_surface(const sandglass_mesh& mesh, float distance, std::vector<float>* points,
                             sandglass_sample_desc desc = sample_desc()) {
  desc.method = SANDGLASS_SAMPLE_SURFACE;
  desc.mesh = &mesh;
  desc.distance = distance;
  return sample_points(desc, points);
}

// A mesh prepared for many inside tests, and its block; the mesh's arrays may go after create. Movable, not copyable.
// Give the samplers a reference: [&](const float* p) { return inside(p); }.
class MeshInside : public Owned<sandglass_mesh_inside> {
 public:
  // See sandglass_mesh_inside_create.
  Status create(const sandglass_mesh& mesh, sandglass_inside_rule rule = SANDGLASS_INSIDE_PARITY) {
    return create_of(sandglass_mesh_inside_bytes, sandglass_mesh_inside_create, &mesh, rule);
  }
  // See sandglass_mesh_inside_test.
  bool operator()(const float point[3]) const { return sandglass_mesh_inside_test(get(), point) != 0; }
};

// A signed-distance field and its block: what a collider of SANDGLASS_SHAPE_FIELD points to. Movable, not copyable.
class Field : public Owned<sandglass_field> {
 public:
  // See sandglass_field_create.
  Status create(const sandglass_field_desc& desc) {
    return create_of(sandglass_field_bytes, sandglass_field_create, &desc);
  }
  // `distance_of` is anything that can be called with a const float[3] and gives the distance from the surface.
  template <class Distance>
  Status from_function(const Box& box, float spacing, sandglass_solid solid, Distance distance_of) {
    sandglass_field_desc desc = over(box, spacing, solid);
    desc.distance = [](void* distance, const float point[3]) -> float {
      return (*static_cast<Distance*>(distance))(point);
    };
    desc.distance_user = &distance_of;
    return create(desc);
  }
  // From a mesh and the inside test that was prepared from it.
  Status from_mesh(const sandglass_mesh& mesh, const MeshInside& inside, const Box& box, float spacing, float band,
                   sandglass_solid solid) {
    sandglass_field_desc desc = over(box, spacing, solid);
    desc.band = band;
    desc.mesh = &mesh;
    desc.inside = sandglass_mesh_inside_test;
    desc.inside_user = inside.get();
    return create(desc);
  }
  // See sandglass_field_distance.
  float distance(const float point[3]) const { return sandglass_field_distance(get(), point, nullptr); }

 private:
  static sandglass_field_desc over(const Box& box, float spacing, sandglass_solid solid) {
    sandglass_field_desc desc = field_desc();
    std::copy(box.min, box.min + 3, desc.bounds_min);
    std::copy(box.max, box.max + 3, desc.bounds_max);
    desc.spacing = spacing;
    desc.solid = solid;
    return desc;
  }
};

// A collider of a field whose own coordinates begin at (x, y, z), unrotated and at rest. The field must outlive it.
inline sandglass_collider field_at(const Field& field, float x, float y, float z) {
  sandglass_collider c = filled(sandglass_collider_default);
  c.shape = SANDGLASS_SHAPE_FIELD;
  c.position[0] = x;
  c.position[1] = y;
  c.position[2] = z;
  c.field = field.get();
  return c;
}

}  // namespace cpp
}  // namespace sandglass

#endif  // SANDGLASS_SAMPLING_HPP

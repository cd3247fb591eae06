// A box as a rigid body: particles on a lattice whose outermost spheres touch the box's faces from inside, and the
// collider that is the box itself. The lattice is not that of packed sand, so the body's density makes up for it.
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/math/rotation.h"
#include "sandglass/sandglass.h"

namespace sandglass {

namespace {

constexpr uint32_t k_box_particles_max = 1u << 20;
constexpr double k_packed_volume = 5.65685424949238;  // of a particle in a hexagonal close packing: 4 sqrt(2) r^3

// What turns a vector: the columns of the rotation, by the unit quaternion q.
struct Axes {
  double column[3][3];
};

bool axes_of(const float rotation[4], Axes* axes) {
  double q[4], squared = 0.0;
  for (int k = 0; k < 4; ++k) q[k] = static_cast<double>(rotation[k]);
  for (const double x : q) squared += x * x;
  if (!(squared > 1e-12 && squared < 1e12)) return false;
  const double s = 2.0 / squared, x = q[0], y = q[1], z = q[2], w = q[3];
  *axes = {{{1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)},
            {s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)},
            {s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)}}};
  return true;
}

// Particles along each axis, so many that neighbours are at most two radii apart; or a sentence.
const char* lattice_of(const sandglass_box_desc* desc, uint32_t counts[3], Axes* axes) {
  if (desc == nullptr || desc->struct_size != sizeof *desc)
    return "desc is NULL or its struct_size is wrong: start from sandglass_box_desc_default.";
  const float radius = desc->particle_radius;
  if (!(radius >= 1e-4f && radius <= 10.0f)) return "particle_radius must be 0.0001 to 10 metres.";
  double all = 1.0;
  for (int k = 0; k < 3; ++k) {
    const float half = desc->half_extents[k];
    if (!(half >= radius && half <= SANDGLASS_COORDINATE_LIMIT))
      return "half_extents must be at least particle_radius and at most 1000 m: the box holds no particle, or too "
             "many.";
    // A box of whole particles must not get one more for the rounding of its edges.
    counts[k] = static_cast<uint32_t>(ceiling_index(static_cast<double>(half) / static_cast<double>(radius) - 1e-4));
    all *= counts[k];
  }
  if (!axes_of(desc->rotation, axes)) return "rotation is not finite or has no length: pass a quaternion (x, y, z, w).";
  if (!all_finite(desc->position, 3) || !is_finite(desc->density))
    return "position or density is not finite: check where they come from.";
  return all <= k_box_particles_max ? nullptr : "the box has more than 2^20 particles: make it smaller, or hollow.";
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_box_desc_default(sandglass_box_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->rotation[3] = 1.0f;
  desc->density = 1.0f;
}

sandglass_status sandglass_box_count(const sandglass_box_desc* desc, uint32_t* count, const char** reason) {
  uint32_t counts[3];
  Axes axes;
  if (const char* wrong = lattice_of(desc, counts, &axes)) return refuse(reason, wrong);
  if (count == nullptr) return refuse(reason, "count is NULL: pass where to store the number of particles.");
  *count = counts[0] * counts[1] * counts[2];
  return accept(reason);
}

sandglass_status sandglass_box_body(const sandglass_box_desc* desc, float* points, uint32_t capacity,
                                    sandglass_body* body, const char** reason) {
  uint32_t counts[3];
  Axes axes;
  if (const char* wrong = lattice_of(desc, counts, &axes)) return refuse(reason, wrong);
  if (points == nullptr || body == nullptr)
    return refuse(reason, "points or body is NULL: pass room for 3 floats a particle, and a body.");
  const uint32_t all = counts[0] * counts[1] * counts[2];
  if (capacity < all)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "capacity is less than the box has particles: ask sandglass_box_count.");
  double first[3], step[3], volume = 1.0;
  const double radius = static_cast<double>(desc->particle_radius);
  for (int k = 0; k < 3; ++k) {
    const double half = static_cast<double>(desc->half_extents[k]), reach = counts[k] > 1 ? half - radius : 0.0;
    first[k] = -reach;
    step[k] = counts[k] > 1 ? 2.0 * reach / (counts[k] - 1) : 0.0;
    volume *= 2.0 * half;
  }
  for (uint32_t i = 0; i < all; ++i) {
    const uint32_t at[3] = {i % counts[0], i / counts[0] % counts[1], i / counts[0] / counts[1]};
    double local[3];
    for (int k = 0; k < 3; ++k) local[k] = first[k] + step[k] * at[k];
    for (int k = 0; k < 3; ++k)
      points[3ull * i + k] = static_cast<float>(static_cast<double>(desc->position[k]) + local[0] * axes.column[0][k] +
                                                local[1] * axes.column[1][k] + local[2] * axes.column[2][k]);
  }
  sandglass_body_default(body);
  body->particle_positions = points;
  body->particle_count = all;
  body->density_ratio = static_cast<float>(static_cast<double>(desc->density) * volume /
                                           (all * k_packed_volume * radius * radius * radius));
  return accept(reason);
}

void sandglass_box_collider(const sandglass_box_desc* desc, const sandglass_body_pose* pose,
                            sandglass_collider* collider) {
  if (desc == nullptr || desc->struct_size != sizeof *desc || pose == nullptr || collider == nullptr) return;
  *collider = {};
  collider->shape = SANDGLASS_SHAPE_BOX;
  multiply(pose->rotation, desc->rotation, collider->rotation);
  for (int k = 0; k < 3; ++k) {
    collider->position[k] = pose->position[k];
    collider->size[k] = desc->half_extents[k];
    collider->linear_velocity[k] = pose->linear_velocity[k];
    collider->angular_velocity[k] = pose->angular_velocity[k];
  }
  collider->grains_only = 1;
}

// Rotations by angular velocity use the first-order quaternion step, renormalised: no sine or cosine in a hashed path,
// and an error of (angle^3)/12, 7e-4 rad for a turn of 0.2 rad within one frame.
#include "runtime/granular/colliders.h"

#include "runtime/granular/field.h"

namespace sandglass {

namespace {

bool finite(float a) { return a - a == 0.0f; }

bool finite(const float* a, uint32_t n) {
  for (uint32_t i = 0; i < n; ++i) {
    if (!finite(a[i])) return false;
  }
  return true;
}

bool normalise(float q[4]) {
  const float length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(length2 > 1e-12f && length2 < 1e12f)) return false;
  const float inverse = 1.0f / __builtin_sqrtf(length2);
  for (int i = 0; i < 4; ++i) q[i] *= inverse;
  return true;
}

}  // namespace

bool collider_accept(const sandglass_collider& collider, sandglass_collider* accepted) {
  if (collider.shape < SANDGLASS_SHAPE_HALF_SPACE || collider.shape > SANDGLASS_SHAPE_FIELD) return false;
  if (!finite(collider.position, 3) || !finite(collider.rotation, 4) || !finite(collider.linear_velocity, 3) ||
      !finite(collider.angular_velocity, 3)) {
    return false;
  }
  for (int k = 0; k < 3; ++k) {
    if (!(__builtin_fabsf(collider.position[k]) <= k_coordinate_bound &&
          __builtin_fabsf(collider.linear_velocity[k]) <= 1e4f &&
          __builtin_fabsf(collider.angular_velocity[k]) <= 1e4f)) {
      return false;
    }
  }
  const bool field = collider.shape == SANDGLASS_SHAPE_FIELD;
  if (field && (collider.field == nullptr || collider.field->magic != k_field_magic)) return false;
  const uint32_t sizes = field                                       ? 0
                         : collider.shape == SANDGLASS_SHAPE_BOX     ? 3
                         : collider.shape == SANDGLASS_SHAPE_CAPSULE ? 2
                                                                     : collider.shape;
  for (uint32_t k = 0; k < sizes; ++k) {
    if (!(collider.size[k] > 0.0f && collider.size[k] <= k_coordinate_bound)) return false;
  }
  *accepted = collider;
  if (field) {  // how far its points are from its origin: what turning moves them by
    float low[3], high[3];
    sandglass_field_bounds(collider.field, low, high);
    for (int k = 0; k < 3; ++k) accepted->size[k] = high[k] > -low[k] ? high[k] : -low[k];
  }
  return normalise(accepted->rotation);
}

void colliders_pose(const sandglass_collider* colliders, uint32_t count, float before, ColliderFrame* frames) {
  for (uint32_t c = 0; c < count; ++c) {
    const sandglass_collider& collider = colliders[c];
    ColliderFrame& frame = frames[c];
    frame.shape = collider.shape;
    if (collider.shape == SANDGLASS_SHAPE_FIELD) frame.field = collider.field->grid;
    const float* q = collider.rotation;
    const float* w = collider.angular_velocity;
    const float h = -0.5f * before;
    float r[4] = {
        q[0] + h * (w[0] * q[3] + w[1] * q[2] - w[2] * q[1]), q[1] + h * (w[1] * q[3] + w[2] * q[0] - w[0] * q[2]),
        q[2] + h * (w[2] * q[3] + w[0] * q[1] - w[1] * q[0]), q[3] - h * (w[0] * q[0] + w[1] * q[1] + w[2] * q[2])};
    normalise(r);
    const float x = r[0], y = r[1], z = r[2], s = r[3];
    const float axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * s), 2 * (x * z - y * s)},
                              {2 * (x * y - z * s), 1 - 2 * (x * x + z * z), 2 * (y * z + x * s)},
                              {2 * (x * z + y * s), 2 * (y * z - x * s), 1 - 2 * (x * x + y * y)}};
    for (int k = 0; k < 3; ++k) {
      frame.position[k] = collider.position[k] - before * collider.linear_velocity[k];
      frame.size[k] = collider.size[k];
      frame.linear[k] = collider.linear_velocity[k];
      frame.angular[k] = collider.angular_velocity[k];
      for (int j = 0; j < 3; ++j) frame.axes[k][j] = axes[k][j];
    }
  }
}

}  // namespace sandglass

// A rotation from what people write down: an axis and an angle.
#include "runtime/math/math.h"
#include "sandglass/sandglass.h"

int32_t sandglass_rotation_about(const float axis[3], float angle, float rotation[4]) {
  if (rotation == nullptr) return 0;
  rotation[0] = rotation[1] = rotation[2] = 0.0f;
  rotation[3] = 1.0f;
  if (axis == nullptr) return 0;
  double direction[3], squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    direction[k] = static_cast<double>(axis[k]);
    squared += direction[k] * direction[k];
  }
  const double turns = static_cast<double>(angle) / (2.0 * sandglass::k_pi);
  // The square of the smallest float above 0 is a double above 0; beyond the limit a turn is below a float's
  // resolution.
  if (!(squared > 0.0 && squared < 1e80) || !(turns > -1e15 && turns < 1e15)) return 0;
  const sandglass::SinCos half = sandglass::sin_cos_turns(0.5 * turns);
  const double scale = half.sin / sandglass::square_root(squared);
  for (int k = 0; k < 3; ++k) rotation[k] = static_cast<float>(direction[k] * scale);
  rotation[3] = static_cast<float>(half.cos);
  return 1;
}

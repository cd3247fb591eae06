// Harmonics turned into an object's frame.
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/turn.h"
#include "sandglass/renderers.h"

namespace sandglass {
namespace {

// Real harmonics of order 2 are a number, a vector and a symmetric matrix without trace: with the factors of
// sandglass_estimator_light.sh taken out, L(d) = c + v . d + d^T M d. Seen by an object that is turned by R they are c,
// R^T v and R^T M R.
constexpr double k_product = 1.0925484305920792, k_zonal = 0.31539156525252005, k_difference = 0.54627421529603959;

void turn_colour(const Rotation& rotation, const float* sh, float* turned) {
  const auto at = [&](uint32_t j) { return static_cast<double>(sh[3 * j]); };
  const double vector[3] = {at(3), at(1), at(2)};
  const double xy = 0.5 * k_product * at(4), yz = 0.5 * k_product * at(5), xz = 0.5 * k_product * at(7);
  const double zonal = k_zonal * at(6), difference = k_difference * at(8);
  const double form[3][3] = {{difference - zonal, xy, xz}, {xy, -difference - zonal, yz}, {xz, yz, 2 * zonal}};
  double v[3] = {}, half[3][3] = {}, m[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      v[i] += rotation.m[j][i] * vector[j];
      for (int k = 0; k < 3; ++k) half[i][j] += form[i][k] * rotation.m[k][j];
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) m[i][j] += rotation.m[k][i] * half[k][j];
  const double out[9] = {at(0),
                         v[1],
                         v[2],
                         v[0],
                         2 * m[0][1] / k_product,
                         2 * m[1][2] / k_product,
                         m[2][2] / (2 * k_zonal),
                         2 * m[0][2] / k_product,
                         (m[0][0] - m[1][1]) / (2 * k_difference)};
  for (uint32_t j = 0; j < 9; ++j) turned[3 * j] = static_cast<float>(out[j]);
}

__attribute__((noinline)) sandglass_status turn_harmonics(const float sh[27], const float rotation[4], float turned[27],
                                                          const char** reason) {
  Rotation matrix;
  if (!rotation_of(rotation, &matrix)) return refuse(reason, "rotation is zero or not finite: pass a quaternion.");
  if (!all_finite(sh, 27)) return refuse(reason, "a coefficient of sh is not finite.");
  float result[27];
  for (uint32_t colour = 0; colour < 3; ++colour) turn_colour(matrix, sh + colour, result + colour);
  for (uint32_t i = 0; i < 27; ++i) turned[i] = result[i];
  return accept(reason);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_harmonics_turn(const float sh[27], const float rotation[4], float turned[27],
                                          const char** reason) {
  if (sh == nullptr || rotation == nullptr || turned == nullptr)
    return refuse(reason, "sh, rotation or turned is NULL: pass 27 floats, 4 floats, and room for 27.");
  const ExactFloatingPoint exact;
  return turn_harmonics(sh, rotation, turned, reason);
}

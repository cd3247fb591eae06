// The quaternion of the best rotation is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix (Horn
// 1987). Other than a polar decomposition it is a proper rotation for every input. Other than an iteration from the
// last rotation it does not stall at a half turn. Jacobi's method finds all four eigenvectors with + - * / and sqrt
// alone.
#include "runtime/math/rotation.h"

namespace sandglass {

namespace {

constexpr int k_rounds = 12;           // Jacobi's method converges quadratically: 6 are enough for doubles
constexpr double k_degenerate = 1e-9;  // eigenvalues closer than this, relative to the largest entry, are equal
constexpr double k_unrelated = 1e-12;  // squared length of a projection that is only rounding

// Turns rows and columns p and q so that m[p][q] = 0, and the eigenvectors (columns of v) with them.
void rotate_pair(double m[4][4], double v[4][4], int p, int q) {
  if (m[p][q] == 0.0) return;
  const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
  const double magnitude = theta < 0.0 ? -theta : theta;
  // Beyond 1e150 the square overflows and the angle is 1/(2 theta) anyway.
  const double t = (theta < 0.0 ? -1.0 : 1.0) /
                   (magnitude > 1e150 ? 2.0 * magnitude : magnitude + __builtin_sqrt(magnitude * magnitude + 1.0));
  const double c = 1.0 / __builtin_sqrt(t * t + 1.0), s = t * c;
  for (int k = 0; k < 4; ++k) {
    const double kp = m[k][p], kq = m[k][q];
    m[k][p] = c * kp - s * kq;
    m[k][q] = s * kp + c * kq;
  }
  for (int k = 0; k < 4; ++k) {
    const double pk = m[p][k], qk = m[q][k];
    m[p][k] = c * pk - s * qk;
    m[q][k] = s * pk + c * qk;
    const double vp = v[k][p], vq = v[k][q];
    v[k][p] = c * vp - s * vq;
    v[k][q] = s * vp + c * vq;
  }
}

}  // namespace

void nearest_rotation(const double a[9], const double near[4], double q[4]) {
  for (int k = 0; k < 4; ++k) q[k] = near[k];
  double scale = 0.0;
  for (int i = 0; i < 9; ++i) {
    const double size = a[i] < 0.0 ? -a[i] : a[i];
    if (!(size < 1e300)) return;  // not finite, or so large that squares overflow
    scale = size > scale ? size : scale;
  }
  if (!(scale > 1e-300)) return;
  double s[3][3];  // Horn's S: s[i][j] = sum of (before)_i (after)_j
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s[i][j] = a[3 * j + i] / scale;
  // Order w, x, y, z.
  double m[4][4] = {{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
                    {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                    {s[2][0] - s[0][2], s[0][1] + s[1][0], -s[0][0] + s[1][1] - s[2][2], s[1][2] + s[2][1]},
                    {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], -s[0][0] - s[1][1] + s[2][2]}};
  double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  for (int round = 0; round < k_rounds; ++round) {
    double off = 0.0;
    for (int p = 0; p < 3; ++p)
      for (int r = p + 1; r < 4; ++r) off += m[p][r] * m[p][r];
    if (off < 1e-30) break;
    for (int p = 0; p < 3; ++p)
      for (int r = p + 1; r < 4; ++r) rotate_pair(m, v, p, r);
  }
  int best = 0;
  for (int k = 1; k < 4; ++k) best = m[k][k] > m[best][best] ? k : best;

  // `near`, projected onto the eigenvectors that are as good as the best.
  const double start[4] = {near[3], near[0], near[1], near[2]};
  double found[4] = {0, 0, 0, 0};
  for (int k = 0; k < 4; ++k) {
    if (m[best][best] - m[k][k] > k_degenerate) continue;
    const double along = v[0][k] * start[0] + v[1][k] * start[1] + v[2][k] * start[2] + v[3][k] * start[3];
    for (int i = 0; i < 4; ++i) found[i] += along * v[i][k];
  }
  double length2 = 0.0;
  for (const double f : found) length2 += f * f;
  if (length2 < k_unrelated) {  // a half turn away: any sign will do
    for (int i = 0; i < 4; ++i) found[i] = v[i][best];
    length2 = found[0] * found[0] + found[1] * found[1] + found[2] * found[2] + found[3] * found[3];
  }
  const double inverse = 1.0 / __builtin_sqrt(length2);
  q[0] = found[1] * inverse;
  q[1] = found[2] * inverse;
  q[2] = found[3] * inverse;
  q[3] = found[0] * inverse;
}

}  // namespace sandglass

#include "runtime/light/harmonics.h"

namespace sandglass {

extern const double k_harmonic_factors[k_harmonics] = {0.28209479177387814, 0.48860251190291992, 0.48860251190291992,
                                                       0.48860251190291992, 1.0925484305920792,  1.0925484305920792,
                                                       0.31539156525252005, 1.0925484305920792,  0.54627421529603959};

extern const double k_cosine_factors[k_harmonics] = {1.0,  2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25,
                                                     0.25, 0.25,      0.25,      0.25};

void harmonic_polynomials(const double v[3], double p[k_harmonics]) {
  const double x = v[0], y = v[1], z = v[2];
  p[0] = 1.0;
  p[1] = y;
  p[2] = z;
  p[3] = x;
  p[4] = x * y;
  p[5] = y * z;
  p[6] = 3.0 * z * z - 1.0;
  p[7] = x * z;
  p[8] = x * x - y * y;
}

}  // namespace sandglass

// From a finger on the screen to a place on the sand: the first particle on a ray. It asks every particle, in double,
// so that a far origin costs no digits: the search is a fraction of a millisecond in any scene that a phone can
// simulate.
#include "runtime/core/finite.h"
#include "runtime/granular/granular.h"

namespace sandglass {

void granular_ray(const Granular& g, const float origin[3], const float direction[3], float reach,
                  sandglass_ray_hit* hit) {
  *hit = {};
  const double o[3] = {static_cast<double>(origin[0]), static_cast<double>(origin[1]), static_cast<double>(origin[2])};
  double u[3], length2 = 0.0;
  for (int k = 0; k < 3; ++k) u[k] = static_cast<double>(direction[k]), length2 += u[k] * u[k];
  // The squares of the smallest floats are above 0 in double.
  if (!all_finite(origin, 3) || !is_finite(length2) || !(length2 > 0.0) || !(reach > 0.0f)) return;
  for (double& x : u) x /= __builtin_sqrt(length2);
  const double radius2 = static_cast<double>(g.desc.particle_radius) * static_cast<double>(g.desc.particle_radius);
  double nearest = static_cast<double>(reach);
  const Particle* found = nullptr;
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const Particle& p = g.particles.records[0][i];
    const double x = static_cast<double>(p.position[0]) - o[0], y = static_cast<double>(p.position[1]) - o[1],
                 z = static_cast<double>(p.position[2]) - o[2];
    const double along = x * u[0] + y * u[1] + z * u[2];  // to the foot of the centre
    const double a = x - along * u[0], b = y - along * u[1], c = z - along * u[2];
    const double half2 = radius2 - (a * a + b * b + c * c);
    if (!(half2 >= 0.0)) continue;
    const double half = __builtin_sqrt(half2);
    if (along + half < 0.0) continue;  // behind
    const double at = along - half > 0.0 ? along - half : 0.0;
    const bool nearer = found != nullptr && at == nearest ? number_of(p) < number_of(*found) : at <= nearest;
    if (nearer) nearest = at, found = &p;
  }
  if (found == nullptr) return;
  hit->what = in_body(*found) ? SANDGLASS_HIT_BODY : SANDGLASS_HIT_SAND;
  hit->index = in_body(*found) ? body_of(*found) - 1 : number_of(*found);
  hit->distance = static_cast<float>(nearest);
  double normal[3], size2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double point = o[k] + nearest * u[k];
    hit->point[k] = static_cast<float>(point);
    normal[k] = point - static_cast<double>(found->position[k]);
    size2 += normal[k] * normal[k];
  }
  for (int k = 0; k < 3; ++k)
    hit->normal[k] = static_cast<float>(size2 > 0.0 ? normal[k] / __builtin_sqrt(size2) : -u[k]);
}

}  // namespace sandglass

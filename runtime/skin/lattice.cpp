// Which way is up, and so how the lattice lies and leans. Held still while gravity turns little.
#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_turned = 0.05f;  // of the unit vector up: so far it turns before sand is filled anew

// The lattice's axes, right-handed: y is the world's axis nearest to up. True: they are others.
bool choose_axes(SkinLattice* lattice, const float up[3]) {
  uint32_t steepest = lattice->axis[1];
  for (uint32_t k = 0; k < 3; ++k)
    if (__builtin_fabsf(up[k]) > 1.2f * __builtin_fabsf(up[steepest])) steepest = k;
  const float sign = up[steepest] < 0 ? -1.0f : 1.0f;
  if (lattice->axis[1] == steepest && lattice->sign[1] == sign) return false;
  // x, y, z in a cycle, or with two of them turned round.
  const uint32_t x = (steepest + 2) % 3, z = (steepest + 1) % 3;
  lattice->axis[0] = x;
  lattice->axis[1] = steepest;
  lattice->axis[2] = z;
  lattice->sign[0] = sign;
  lattice->sign[1] = sign;
  lattice->sign[2] = 1.0f;
  return true;
}

}  // namespace

SkinTurn lattice_follow(SkinLattice* lattice, const Granular& g) {
  float up[3] = {0, 1, 0}, turned = 0;
  if (g.gravity_length > 0)
    for (uint32_t k = 0; k < 3; ++k) up[k] = -g.gravity[k] / g.gravity_length;
  for (uint32_t a = 0; a < 3; ++a) {
    const float d = lattice->sign[a] * up[lattice->axis[a]] - lattice->up[a];
    turned += d * d;
  }
  const bool falls = g.gravity_length > 0;
  if (turned <= k_turned * k_turned && falls == lattice->falls) return SkinTurn::none;
  lattice->falls = falls;
  const bool other_axes = choose_axes(lattice, up);
  for (uint32_t a = 0; a < 3; ++a) lattice->up[a] = lattice->sign[a] * up[lattice->axis[a]];
  for (uint32_t k = 0; k < 2; ++k) {
    const float lean = -lattice->up[2 * k] / lattice->up[1];  // aside for one down
    const float bounded = lean > -1.0f ? (lean < 1.0f ? lean : 1.0f) : -1.0f;
    lattice->lean[k] = floor_whole(bounded * k_skin_one + 0.5f);
  }
  return other_axes ? SkinTurn::other_axes : SkinTurn::leans;
}

}  // namespace sandglass

// A light as directions that give the plane equal irradiance.
#include <cstring>

#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr double k_golden_turn = 0.3819660112501051;                       // 137.5 degrees
constexpr double k_plastic[2] = {0.7548776662466927, 0.5698402909980532};  // of the R2 sequence
constexpr uint32_t k_candidates = 16;  // for each direction of a light that the horizon cuts
constexpr double k_lowest = 1e-3;      // what is lower than this sine of elevation is left out

double fraction(double x) { return x - static_cast<double>(floor_index(x)); }

// x and z of a unit vector. The texel grid is shifted from direction to direction, so that straight edges do not step.
void put(double x, double z, uint32_t index, CastDirection* d) {
  const double square = 1 - x * x - z * z, y = square_root(square > k_lowest * k_lowest ? square : k_lowest * k_lowest);
  d->slope[0] = static_cast<float>(x / y);
  d->slope[1] = static_cast<float>(z / y);
  for (uint32_t axis = 0; axis < 2; ++axis)
    d->shift[axis] = static_cast<float>(fraction(0.5 + (index + 1) * k_plastic[axis]) - 0.5);
}

// A light that the horizon cuts: places that are even over the cap, of which every so many is taken, by the cosine.
uint32_t cut_cap(const double ahead[2], double flat, double up, double cosine, uint32_t count, CastDirection* out) {
  const uint32_t candidates = k_candidates * count;
  double sum = 0, next = 0;
  uint32_t made = 0;
  for (uint32_t round = 0; round < 2; ++round) {
    double run = 0;
    if (round == 1) next = 0.5 * sum / count;
    for (uint32_t i = 0; i < candidates; ++i) {
      const double c = 1 - (1 - cosine) * (i + 0.5) / candidates, s = square_root(1 - c * c);
      const SinCos turn = sin_cos_turns(k_golden_turn * i);
      const double towards_zenith = s * turn.cos, aside = s * turn.sin;
      const double y = c * up + towards_zenith * flat, forward = c * flat - towards_zenith * up;
      if (!(y > k_lowest)) continue;
      run += y;
      if (round == 0) continue;
      for (; run > next && made < count; next += sum / count, ++made)
        put(forward * ahead[0] - aside * ahead[1], forward * ahead[1] + aside * ahead[0], made, out + made);
    }
    sum = run;
  }
  return made;
}

}  // namespace

uint32_t cast_light_directions(const double light[3], double half_turns, uint32_t count, CastDirection* out) {
  const double flat = square_root(light[0] * light[0] + light[2] * light[2]), up = light[1];
  const double ahead[2] = {flat > 0 ? light[0] / flat : 1, flat > 0 ? light[2] / flat : 0};
  const SinCos half = sin_cos_turns(half_turns);
  if (!(up > half.sin)) return cut_cap(ahead, flat, up, half.cos, count, out);
  // The cap's projection on the plane is an ellipse, in which equal areas give equal irradiance: a sunflower is even.
  for (uint32_t i = 0; i < count; ++i) {
    const double radius = square_root((i + 0.5) / count);
    const SinCos turn = sin_cos_turns(k_golden_turn * i);
    const double forward = flat * half.cos + radius * turn.cos * half.sin * up, aside = radius * turn.sin * half.sin;
    put(forward * ahead[0] - aside * ahead[1], forward * ahead[1] + aside * ahead[0], i, out + i);
  }
  return count;
}

// Cells get directions by their shares, in an order in which neighbours follow each other.
uint32_t cast_cell_directions(const float cells[k_light_cells], uint32_t count, CastDirection* out) {
  double sum = 0, run = 0;
  for (uint32_t i = 0; i < k_light_cells; ++i) sum += static_cast<double>(cells[i]);
  if (!(sum > 0)) return 0;
  uint32_t made = 0;
  double next = 0.5 * sum / count;
  for (uint32_t i = 0; i < k_light_cells; ++i) {
    const uint32_t ring = i / k_cell_sectors, along = i % k_cell_sectors;
    const uint32_t sector = ring % 2 == 0 ? along : k_cell_sectors - 1 - along;
    const double share = static_cast<double>(cells[ring * k_cell_sectors + sector]), first = run;
    run += share;
    for (; next < run && made < count; next += sum / count, ++made) {
      const double a = (next - first) / share, b = fraction(0.5 + (made + 1) * (1 - k_golden_turn));
      const double square = (ring + b) / k_cell_rings, flat = square_root(1 - square);
      const SinCos turn = sin_cos_turns((sector + a) / k_cell_sectors);
      put(flat * turn.cos, flat * turn.sin, made, out + made);
    }
  }
  return made;
}

}  // namespace sandglass

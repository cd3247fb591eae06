// The light's azimuths, and what of each the columns leave to a row of the texture.
#include <cstdint>
#include <cstring>

#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/shadow/pile/pile.h"
#include "runtime/shadow/pile/thin.h"

namespace sandglass {
namespace {

// Sand is lit as it is seen, sphere by sphere. A receiver on the sand is raised by this share of a radius, so that
// neighbours of the same height do not shade each other.
constexpr float k_surface_lift = 0.5f;
constexpr double k_cap_share = 0.9;     // what hides this share of a light counts as reaching its upper edge
constexpr double k_step_growth = 1.12;  // of distant steps; a light of 20 degrees is 0.35 wide at distance 1
constexpr double k_near_steps = 1;      // that count as if their columns lay just where they end
constexpr double k_even_steps = 8;      // texels that are walked one by one

// The range of elevations that the light fills in one vertical half plane, as squares of sines. `cosine` is that of the
// angle between the half plane's azimuth and the light's. The light is where a cos e + b sin e >= cos(half), with
// a = flat * cosine and b = up; `flat` and `up` are the horizontal and vertical components of its direction. False: the
// half plane does not meet the light.
bool elevations(double flat, double up, double cosine, double half_cosine, double* low, double* high) {
  const double a = flat * cosine, b = up, norm = square_root(a * a + b * b);
  if (!(norm > half_cosine)) return false;
  const double c1 = a / norm, s1 = b / norm, c2 = half_cosine / norm, s2 = square_root(1 - c2 * c2);
  const double sin_high = s1 * c2 + c1 * s2, cos_high = c1 * c2 - s1 * s2;
  const double sin_low = s1 * c2 - c1 * s2, cos_low = c1 * c2 + s1 * s2;
  if (!(cos_low > 0)) return false;  // it lies in the opposite half plane
  *high = cos_high > 0 ? (sin_high > 0 ? sin_high * sin_high : 0) : 1;
  *low = sin_low > 0 ? sin_low * sin_low : 0;
  return *high > *low;
}

// The steps along an azimuth, out to the distance at which the highest sand no longer reaches the light's lower edge.
uint32_t walk(const Pile& p, double cosine, double sine, double low, PileStep* steps) {
  const double texel =
      static_cast<double>(p.rectangle.texel[0] < p.rectangle.texel[1] ? p.rectangle.texel[0] : p.rectangle.texel[1]);
  const double slope = square_root(low / (1 - (low < 1 ? low : 0)));
  const double across = 1.5 * p.rectangle.texels;
  const double reach = slope * across * texel > static_cast<double>(p.columns.top)
                           ? static_cast<double>(p.columns.top) / (slope * texel)
                           : across;
  uint32_t count = 0;
  // The receiver's own column: two random places in it are a third of its width apart on average. The first of
  // the other columns counts as if it lay just where the step ends, so that a thin layer is met within a texel's width
  // whatever the azimuth is.
  steps[count++] = {0, 0, static_cast<float>(3 / texel)};
  for (double distance = 1; distance <= reach + 1 && count < k_pile_steps;
       distance = distance < k_even_steps ? distance + 1 : distance * k_step_growth) {
    const double x = distance * texel * cosine / static_cast<double>(p.rectangle.texel[0]);
    const double z = distance * texel * sine / static_cast<double>(p.rectangle.texel[1]);
    const int64_t columns = floor_index(x + 0.5), rows = floor_index(z + 0.5);
    const double dx = static_cast<double>(columns) * static_cast<double>(p.rectangle.texel[0]);
    const double dz = static_cast<double>(rows) * static_cast<double>(p.rectangle.texel[1]);
    const double length = distance <= k_near_steps ? distance * texel : square_root(dx * dx + dz * dz);
    if ((columns == 0 && rows == 0) || !(length > 0)) continue;
    steps[count++] = {static_cast<int32_t>(columns), static_cast<int32_t>(rows), static_cast<float>(1 / length)};
  }
  return count;
}

// The steps of a row that meet rows with sand; the receiver's own column stays. Texels from `begin` to before `end` may
// meet sand.
void gather_row(PileLighting* lighting, const Pile& p, int32_t row, uint32_t* begin, uint32_t* end) {
  uint32_t count = 0;
  int32_t first_texel = INT32_MAX, last_texel = INT32_MIN;
  for (uint32_t k = 0; k < lighting->azimuth_count; ++k) {
    PileAzimuth* out = &lighting->row_azimuths[k];
    *out = lighting->azimuths[k];
    const uint32_t first = out->first_step, last = out->last_step;
    out->first_step = count;
    for (uint32_t s = first; s < last; ++s) {
      const int32_t at = row + lighting->steps[s].rows;
      const bool meets = at >= p.columns.sand_rows[0] && at <= p.columns.sand_rows[1];
      if (s == first || meets) lighting->row_steps[count++] = lighting->steps[s];
      if (!meets) continue;
      const int32_t from = p.columns.sand_columns[0] - lighting->steps[s].columns,
                    to = p.columns.sand_columns[1] - lighting->steps[s].columns;
      first_texel = from < first_texel ? from : first_texel;
      last_texel = to > last_texel ? to : last_texel;
    }
    out->last_step = count;
  }
  const int32_t n = static_cast<int32_t>(p.rectangle.texels);
  first_texel = first_texel > 0 ? first_texel : 0;
  last_texel = last_texel < n ? last_texel : n - 1;
  *begin = *end = 0;
  if (first_texel > last_texel) return;
  *begin = static_cast<uint32_t>(first_texel) / k_lane_group * k_lane_group;
  *end = (static_cast<uint32_t>(last_texel) / k_lane_group + 1) * k_lane_group;
}

void light_row(PileLighting* lighting, const Pile& p, bool floor, uint8_t* coverage) {
  const uint32_t texels = p.rectangle.texels;
  PileLightArgs args = {};
  args.tops = p.columns.tops;
  args.bottoms = p.columns.bottoms;
  args.fills = p.columns.fills;
  args.pitch = p.columns.pitch;
  args.row = static_cast<int32_t>(lighting->row);
  for (uint32_t side = 0; side < 2; ++side) {
    args.sand_rows[side] = p.columns.sand_rows[side];
    args.sand_columns[side] = p.columns.sand_columns[side];
  }
  args.receivers = floor ? lighting->ground : lighting->receivers;
  args.on_floor = floor ? 1 : 0;
  uint32_t begin, end;
  gather_row(lighting, p, args.row, &begin, &end);
  for (uint32_t u = 0; u < texels; ++u) lighting->shares[u] = 1;
  args.azimuths = lighting->row_azimuths;
  args.azimuth_count = lighting->azimuth_count;
  args.steps = lighting->row_steps;
  args.inverse_total = lighting->inverse_total;
  args.shares = lighting->shares;
  uint32_t unused = 0;
  p.kernels->pile_light(&args, begin, end, &unused);
  if (p.air.any)
    for (uint32_t u = 0; u < texels; ++u) lighting->shares[u] *= p.air.shares[lighting->row * texels + u];
  for (uint32_t u = 0; u < texels; ++u)
    coverage[u] = static_cast<uint8_t>(to_whole<uint32_t>(255.0f * (1.0f - lighting->shares[u]) + 0.5f));
}

}  // namespace

// Cuts the light into azimuths. They lie evenly in the sine of the angle from the light's own azimuth, over its width.
// A light that holds the zenith is cut all round.
void lighting_cut(PileLighting* lighting, const Pile& p) {
  const double flat =
      square_root(lighting->made_for[0] * lighting->made_for[0] + lighting->made_for[2] * lighting->made_for[2]);
  const double up = lighting->made_for[1];
  const bool round = flat <= lighting->half_sine;
  const double ahead_x = flat > 0 ? lighting->made_for[0] / flat : 1,
               ahead_z = flat > 0 ? lighting->made_for[2] / flat : 0;
  const uint32_t count = round ? k_pile_azimuths : k_pile_azimuths / 2;
  double total = 0;
  uint32_t steps = 0;
  lighting->azimuth_count = 0;
  for (uint32_t k = 0; k < count; ++k) {
    double cosine, sine, weight;
    if (round) {
      const SinCos turn = sin_cos_turns((k + 0.5) / count);
      cosine = turn.cos;
      sine = turn.sin;
      weight = 1;
    } else {
      const double widest = lighting->half_sine / flat;
      sine = widest * ((2.0 * k + 1.0) / count - 1.0);
      cosine = square_root(1 - sine * sine);
      weight = 1 / cosine;  // d(azimuth) / d(sine)
    }
    double low = 0, high = 0;
    if (!elevations(flat, up, cosine, lighting->half_cosine, &low, &high)) continue;
    PileAzimuth& azimuth = lighting->azimuths[lighting->azimuth_count++];
    azimuth.low = static_cast<float>(low);
    azimuth.high = static_cast<float>(high);
    azimuth.weight = static_cast<float>(weight);
    const double cap = low + k_cap_share * (high - low);
    azimuth.foot = static_cast<float>(square_root(low / (1 - low)));
    azimuth.cap = static_cast<float>(square_root(cap / (1 - cap)));
    azimuth.first_step = steps;
    steps +=
        walk(p, ahead_x * cosine - ahead_z * sine, ahead_z * cosine + ahead_x * sine, low, lighting->steps + steps);
    azimuth.last_step = steps;
    thin_own_column(p, lighting->steps + azimuth.first_step, steps - azimuth.first_step, &azimuth);
    total += static_cast<double>(azimuth.weight) * static_cast<double>(azimuth.high - azimuth.low);
  }
  lighting->inverse_total = total > 0 ? static_cast<float>(1 / total) : 0.0f;
}

bool lighting_run(PileLighting* lighting, const Pile& p, uint8_t* texture, bool floor) {
  const uint32_t texels = p.rectangle.texels;
  const uint32_t rows = k_pile_unit_texels / texels > 0 ? k_pile_unit_texels / texels : 1;
  const uint32_t end = lighting->row + rows > texels ? texels : lighting->row + rows;
  for (; lighting->row < end; ++lighting->row) {
    uint8_t* coverage = texture + uint64_t{lighting->row} * texels;
    if (p.columns.sand_rows[1] < 0 && !p.air.any) {
      memset(coverage, 0, texels);
    } else {
      ground_row(p.ground, lighting->row, texels, 1, lighting->ground);
      const float* tops = p.columns.tops + uint64_t{lighting->row} * p.columns.pitch;
      for (uint32_t u = 0; !floor && u < texels; ++u)
        lighting->receivers[u] = tops[u] > 0 ? tops[u] + k_surface_lift * p.request.source.radius : lighting->ground[u];
      light_row(lighting, p, floor, coverage);
    }
  }
  if (lighting->row < texels) return false;
  lighting->row = 0;
  return true;
}

}  // namespace sandglass

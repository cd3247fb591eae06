// See thin.h.
#include "runtime/shadow/pile/thin.h"

#include "runtime/math/math.h"

namespace sandglass {
namespace {

// Radii: the width of the box by which a grain blocks light from the side. It is below that of a box with the sphere's
// silhouette, 1.77, so that the steps hide no more than the layer does also where it is low.
constexpr float k_side = 1.6f;
constexpr uint32_t k_elevations = 16;  // at which a layer is compared with its steps
constexpr double k_hidden_max = 0.95;  // by one grain of the own column
constexpr double k_power_max = 2;      // the last of k_powers
constexpr double k_powers[5] = {0, 0.25, 0.5, 1, 2};

// The share of the texel that grains on the floor hide from its uncovered points at most: the mean over random places
// of a grain and of a point in a square, by the distribution of the distance between the two.
double share_under(double radius) {  // in sides of the square, at most 1
  return radius * radius * (k_pi - radius * (8.0 / 3) + 0.5 * radius * radius);
}

// What of a layer is missing from the steps at elevations spread evenly over the azimuth's: expected grains in the way
// of a light, for one grain a texel. None is negative; their sum is what is missing in all. Where the steps meet the
// layer at most elevations, what is missing comes from where steps happen to end, and is spread evenly.
void missing_from_steps(const Pile& p, const PileStep* steps, uint32_t count, const PileAzimuth& azimuth,
                        double missing[k_elevations]) {
  const double radius = static_cast<double>(p.request.source.radius), share = static_cast<double>(sphere_share(p));
  const double texel = static_cast<double>(p.rectangle.texel[0]) * static_cast<double>(p.rectangle.texel[1]);
  const double top = radius + static_cast<double>(k_fine_rise) * radius;
  const double low = static_cast<double>(azimuth.low), width = static_cast<double>(azimuth.high) - low;
  double sum = 0, positive = 0;
  uint32_t met = 0;  // elevations at which the steps meet the layer
  for (uint32_t i = 0; i < k_elevations; ++i) {
    const double square = low + width * (i + 0.5) / k_elevations, slope = square_root(square / (1 - square));
    uint32_t reach = 1;
    while (reach < count && top * static_cast<double>(steps[reach].inverse_distance) > slope) ++reach;
    const double rest = radius * radius * shadow_beyond_outline(square_root(square)) / texel - share * (reach - 1);
    sum += rest;
    positive += rest > 0 ? rest : 0;
    missing[i] = rest > 0 ? rest : 0;
    met += reach > 1 ? 1 : 0;
  }
  const double scale = sum > 0 ? sum / positive : 0, mean = sum > 0 ? sum / k_elevations : 0;
  for (uint32_t i = 0; i < k_elevations; ++i) missing[i] = 4 * met > k_elevations ? mean : scale * missing[i];
}

// Adds the weights of k_powers in the polynomial through y^k_powers as functions of the power, at `power`.
void interpolate_power(double power, double* weights) {
  for (uint32_t i = 0; i < 5; ++i) {
    double weight = 1;
    for (uint32_t k = 0; k < 5; ++k)
      if (k != i) weight *= (power - k_powers[k]) / (k_powers[i] - k_powers[k]);
    weights[i] += weight;
  }
}

}  // namespace

float sphere_share(const Pile& p) {
  const float longer = p.rectangle.texel[0] > p.rectangle.texel[1] ? p.rectangle.texel[0] : p.rectangle.texel[1],
              radius = p.request.source.radius;
  const float share = is_finer_than_texels(p) ? k_side * radius / longer
                                              : 4 * k_half_face * k_half_face * (radius / p.rectangle.texel[0]) *
                                                    (radius / p.rectangle.texel[1]);
  return share < 1 ? share : 1;
}

double shadow_beyond_outline(double sine) {
  // The shadow is an ellipse with the semi-axes 1 / sine and 1. The sphere touches the floor in its focus. Both
  // outlines meet where the ellipse's radius from there is 1, at the angle `meet`.
  const double cosine = square_root(1 - sine * sine);
  if (!(cosine > 0)) return 0;
  const double middle = cosine / sine, cos_meet = (1 - sine) / cosine, sin_meet = square_root(1 - cos_meet * cos_meet);
  const double meet = arc_tangent2(sin_meet, cos_meet);
  const double anomaly = arc_tangent2(sin_meet, (cos_meet - middle) * sine);
  return anomaly / sine + middle * sin_meet - meet;
}

void thin_own_column(const Pile& p, const PileStep* steps, uint32_t count, PileAzimuth* azimuth) {
  azimuth->thin = 0;
  if (!is_finer_than_texels(p) || p.request.source.skin != nullptr) return;
  const double radius = static_cast<double>(p.request.source.radius);
  const double texel[2] = {static_cast<double>(p.rectangle.texel[0]), static_cast<double>(p.rectangle.texel[1])};
  const double under = share_under(radius / square_root(texel[0] * texel[1]));
  double missing[k_elevations], weights[5] = {};
  missing_from_steps(p, steps, count, *azimuth, missing);
  // n grains leave (1 - hidden)^n, and the column's fill is 1 - (1 - share)^n.
  const double left = logarithm(1 - static_cast<double>(sphere_share(p)));
  if (!(left < 0)) return;  // a grain too small to hide anything of its texel
  const double per_grain = 1 / left;
  for (const double rest : missing) {
    const double hidden = rest / (1 - under) < k_hidden_max ? rest / (1 - under) : k_hidden_max;
    const double power = logarithm(1 - hidden) * per_grain;
    interpolate_power(power < k_power_max ? power : k_power_max, weights);
  }
  for (uint32_t i = 0; i < 5; ++i) azimuth->own[i] = static_cast<float>(weights[i] / k_elevations);
  azimuth->own[0] -= 1;
  // Sand in the own column is at most half a texel away. Of what is higher, only light above its slope is hidden.
  const double foot = static_cast<double>(azimuth->foot), rise = static_cast<double>(azimuth->cap) - foot;
  if (!(rise > 0)) return;  // nothing is higher than the light's foot
  azimuth->near_from = static_cast<float>(1 + foot / rise);
  azimuth->near_per_metre = static_cast<float>(2 / ((texel[0] < texel[1] ? texel[0] : texel[1]) * rise));
  azimuth->thin = 1;
}

}  // namespace sandglass

// Constants of the perceived errors are those of the papers. The weights of a filter are normalised. Outside, a picture
// continues with its border pixels.
#include "models/compositing/image_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi;

using Plane = std::vector<double>;

struct Filter {
  int radius;
  std::vector<double> weight;  // 2 * radius + 1
};

Filter make_filter(int radius, const std::function<double(int)>& value) {
  Filter filter = {radius, {}};
  for (int i = -radius; i <= radius; ++i) filter.weight.push_back(value(i));
  return filter;
}

Filter normalised_sum(Filter filter) {
  double sum = 0.0;
  for (const double w : filter.weight) sum += w;
  for (double& w : filter.weight) w /= sum;
  return filter;
}

Filter gaussian(double deviation) {
  return normalised_sum(make_filter(static_cast<int>(std::ceil(3.0 * deviation)),
                                    [&](int i) { return std::exp(-i * i / (2.0 * deviation * deviation)); }));
}

// Filters along x, then along y.
Plane filtered(const Plane& plane, int width, int height, const Filter& along_x, const Filter& along_y) {
  Plane middle(plane.size()), result(plane.size());
  const auto at = [&](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int i = -along_x.radius; i <= along_x.radius; ++i)
        sum += along_x.weight[static_cast<size_t>(i + along_x.radius)] * plane[at(std::clamp(x + i, 0, width - 1), y)];
      middle[at(x, y)] = sum;
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int i = -along_y.radius; i <= along_y.radius; ++i)
        sum +=
            along_y.weight[static_cast<size_t>(i + along_y.radius)] * middle[at(x, std::clamp(y + i, 0, height - 1))];
      result[at(x, y)] = sum;
    }
  return result;
}

Vec3 displayed(const RadianceMap& map, size_t pixel) {
  const auto value = [&](size_t c) { return std::clamp(static_cast<double>(map.rgb[3 * pixel + c]), 0.0, 1.0); };
  return {value(0), value(1), value(2)};
}

// From linear BT.709 to XYZ divided by the white point, and back.
constexpr double k_to_xyz[3][3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                                   {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                                   {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};

Vec3 multiply(const double m[3][3], Vec3 v) {
  return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
          m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}
Vec3 inverse_multiply(const double m[3][3], Vec3 v) {
  const Vec3 a = {m[0][0], m[1][0], m[2][0]}, b = {m[0][1], m[1][1], m[2][1]}, c = {m[0][2], m[1][2], m[2][2]};
  const double determinant = dot(a, cross(b, c));
  return Vec3{dot(v, cross(b, c)), dot(v, cross(c, a)), dot(v, cross(a, b))} * (1.0 / determinant);
}
Vec3 relative_xyz(Vec3 linear) {
  const Vec3 white = multiply(k_to_xyz, {1, 1, 1}), xyz = multiply(k_to_xyz, linear);
  return {xyz.x / white.x, xyz.y / white.y, xyz.z / white.z};
}

// YCxCz, which is L*a*b* without the cube roots. Filtering is linear in it.
Vec3 opponent(Vec3 linear) {
  const Vec3 r = relative_xyz(linear);
  return {116.0 * r.y - 16.0, 500.0 * (r.x - r.y), 200.0 * (r.y - r.z)};
}
Vec3 linear_of_opponent(Vec3 o) {
  const double y = (o.x + 16.0) / 116.0;
  const Vec3 white = multiply(k_to_xyz, {1, 1, 1});
  return inverse_multiply(k_to_xyz, {(y + o.y / 500.0) * white.x, y * white.y, (y - o.z / 200.0) * white.z});
}

// L*a*b* whose two colour axes are scaled by lightness (Hunt effect).
Vec3 hunt_lab(Vec3 linear) {
  const auto f = [](double t) {
    constexpr double k_delta = 6.0 / 29.0;
    return t > k_delta * k_delta * k_delta ? std::cbrt(t) : t / (3.0 * k_delta * k_delta) + 4.0 / 29.0;
  };
  const Vec3 r = relative_xyz(linear);
  const double l = 116.0 * f(r.y) - 16.0;
  return {l, 0.01 * l * 500.0 * (f(r.x) - f(r.y)), 0.01 * l * 200.0 * (f(r.y) - f(r.z))};
}

double hyab(Vec3 a, Vec3 b) { return std::fabs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z); }

// The contrast sensitivity of a channel as one or two Gaussians over degrees. If height2 is 0, there is no second one.
struct Sensitivity {
  double height, width, height2, width2;
};
constexpr Sensitivity k_sensitivity[3] = {
    {1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

// Filters with each Gaussian on its own, because only a single one is separable. Each result is weighted by the
// Gaussian's height and sum.
Plane sensitivity_filtered(const Plane& plane, int width, int height, const Sensitivity& s, double per_degree) {
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * k_pi * k_pi)) * per_degree));
  const auto part = [&](double spread) {
    return make_filter(radius, [&](int i) {
      const double degrees = i / per_degree;
      return std::exp(-k_pi * k_pi * degrees * degrees / spread);
    });
  };
  const auto sum = [](const Filter& f) {
    double total = 0.0;
    for (const double w : f.weight) total += w;
    return total * total;
  };
  const Filter filter = part(s.width);
  if (s.height2 == 0.0) return filtered(plane, width, height, normalised_sum(filter), normalised_sum(filter));
  const Filter filter2 = part(s.width2);
  const double a = s.height * k_pi / s.width * sum(filter), b = s.height2 * k_pi / s.width2 * sum(filter2);
  Plane first = filtered(plane, width, height, normalised_sum(filter), normalised_sum(filter));
  const Plane second = filtered(plane, width, height, normalised_sum(filter2), normalised_sum(filter2));
  for (size_t i = 0; i < first.size(); ++i) first[i] = (a * first[i] + b * second[i]) / (a + b);
  return first;
}

std::vector<Vec3> seen_colours(const RadianceMap& map, double per_degree) {
  const size_t pixels = map.rgb.size() / 3;
  std::array<Plane, 3> channels;
  for (Plane& channel : channels) channel.resize(pixels);
  for (size_t i = 0; i < pixels; ++i) {
    const Vec3 o = opponent(displayed(map, i));
    channels[0][i] = o.x;
    channels[1][i] = o.y;
    channels[2][i] = o.z;
  }
  for (size_t c = 0; c < 3; ++c)
    channels[c] = sensitivity_filtered(channels[c], map.width, map.height, k_sensitivity[c], per_degree);
  std::vector<Vec3> lab(pixels);
  for (size_t i = 0; i < pixels; ++i) {
    const Vec3 c = linear_of_opponent({channels[0][i], channels[1][i], channels[2][i]});
    lab[i] = hunt_lab({std::clamp(c.x, 0.0, 1.0), std::clamp(c.y, 0.0, 1.0), std::clamp(c.z, 0.0, 1.0)});
  }
  return lab;
}

// How strongly edges (first derivative) and points (second derivative) show in the achromatic channel.
struct Features {
  Plane edge, point;
};
Features features_of(const RadianceMap& map, double per_degree) {
  constexpr double k_feature_width = 0.082;  // degrees
  const double deviation = 0.5 * k_feature_width * per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * deviation));
  const auto bell = [&](int i) { return std::exp(-i * i / (2.0 * deviation * deviation)); };
  // The positive weights of the two-dimensional filter sum to 1, the negative ones to -1.
  const auto balanced = [](Filter f) {
    double positive = 0.0, negative = 0.0;
    for (const double w : f.weight) (w > 0.0 ? positive : negative) += std::fabs(w);
    for (double& w : f.weight) w /= w > 0.0 ? positive : negative;
    return f;
  };
  const Filter across = normalised_sum(make_filter(radius, bell));
  const Filter slope = balanced(make_filter(radius, [&](int i) { return -i * bell(i); }));
  const Filter bend =
      balanced(make_filter(radius, [&](int i) { return (i * i / (deviation * deviation) - 1.0) * bell(i); }));
  Plane grey(map.rgb.size() / 3);
  for (size_t i = 0; i < grey.size(); ++i) grey[i] = (opponent(displayed(map, i)).x + 16.0) / 116.0;
  const auto magnitude = [&](const Filter& f) {
    Plane x = filtered(grey, map.width, map.height, f, across);
    const Plane y = filtered(grey, map.width, map.height, across, f);
    for (size_t i = 0; i < x.size(); ++i) x[i] = std::hypot(x[i], y[i]);
    return x;
  };
  return {magnitude(slope), magnitude(bend)};
}

}  // namespace

double root_mean_square_error(const RadianceMap& truth, const RadianceMap& picture) {
  double sum = 0.0;
  for (size_t i = 0; i < truth.rgb.size(); ++i) sum += std::pow(static_cast<double>(truth.rgb[i] - picture.rgb[i]), 2);
  return std::sqrt(sum / static_cast<double>(truth.rgb.size()));
}

double structural_similarity(const RadianceMap& truth, const RadianceMap& picture) {
  constexpr double k_mean = 1e-4, k_spread = 9e-4;  // (0.01)^2, (0.03)^2
  const Filter window = gaussian(1.5);
  const size_t pixels = truth.rgb.size() / 3;
  Plane a(pixels), b(pixels), aa(pixels), bb(pixels), ab(pixels);
  for (size_t i = 0; i < pixels; ++i) {
    const auto luma = [&](const RadianceMap& map) {
      const Vec3 c = displayed(map, i);
      return 0.2126 * srgb_of(c.x) + 0.7152 * srgb_of(c.y) + 0.0722 * srgb_of(c.z);
    };
    a[i] = luma(truth);
    b[i] = luma(picture);
    aa[i] = a[i] * a[i];
    bb[i] = b[i] * b[i];
    ab[i] = a[i] * b[i];
  }
  for (Plane* plane : {&a, &b, &aa, &bb, &ab}) *plane = filtered(*plane, truth.width, truth.height, window, window);
  double sum = 0.0;
  for (size_t i = 0; i < pixels; ++i) {
    const double va = aa[i] - a[i] * a[i], vb = bb[i] - b[i] * b[i], both = ab[i] - a[i] * b[i];
    sum += (2.0 * a[i] * b[i] + k_mean) * (2.0 * both + k_spread) /
           ((a[i] * a[i] + b[i] * b[i] + k_mean) * (va + vb + k_spread));
  }
  return sum / static_cast<double>(pixels);
}

std::vector<double> flip_map(const RadianceMap& truth, const RadianceMap& picture, double pixels_per_degree) {
  constexpr double k_colour_exponent = 0.7, k_feature_exponent = 0.5, k_knee = 0.4, k_knee_error = 0.95;
  const double full = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), k_colour_exponent);
  const std::vector<Vec3> seen = seen_colours(truth, pixels_per_degree),
                          other = seen_colours(picture, pixels_per_degree);
  const Features a = features_of(truth, pixels_per_degree), b = features_of(picture, pixels_per_degree);
  std::vector<double> errors(seen.size());
  for (size_t i = 0; i < errors.size(); ++i) {
    const double difference = std::pow(hyab(seen[i], other[i]), k_colour_exponent), knee = k_knee * full;
    const double colour = difference < knee ? k_knee_error / knee * difference
                                            : k_knee_error + (difference - knee) / (full - knee) * (1.0 - k_knee_error);
    const double change = std::max(std::fabs(a.edge[i] - b.edge[i]), std::fabs(a.point[i] - b.point[i]));
    const double feature = std::pow(change / std::numbers::sqrt2, k_feature_exponent);
    errors[i] = std::pow(std::clamp(colour, 0.0, 1.0), 1.0 - std::clamp(feature, 0.0, 1.0));
  }
  return errors;
}

double flip(const RadianceMap& truth, const RadianceMap& picture) {
  double sum = 0.0;
  const std::vector<double> errors = flip_map(truth, picture);
  for (const double e : errors) sum += e;
  return sum / static_cast<double>(errors.size());
}

}  // namespace sandglass::host

#include "models/rooms/panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

namespace {
constexpr double k_pi = std::numbers::pi;
}

Vec3 direction_of_angles(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

Vec3 panorama_direction(double u, double v, int width, int height) {
  return direction_of_angles(k_pi * (v + 0.5) / height, 2.0 * k_pi * (u + 0.5) / width - 0.5 * k_pi);
}

PanoramaPlace panorama_place(Vec3 d, int width, int height) {
  const double theta = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
  double phi = std::atan2(d.z, d.x) + 0.5 * k_pi;  // from the left edge
  if (phi < 0.0) phi += 2.0 * k_pi;
  return {phi * width / (2.0 * k_pi) - 0.5, theta * height / k_pi - 0.5};
}

double pixel_solid_angle(int v, int width, int height) {
  return 2.0 * k_pi * k_pi / (static_cast<double>(width) * height) * std::sin(k_pi * (v + 0.5) / height);
}

Vec3 look_up(const RadianceMap& panorama, Vec3 direction) {
  const int w = panorama.width, h = panorama.height;
  const PanoramaPlace place = panorama_place(direction, w, h);
  const double u0 = std::floor(place.u), v0 = std::floor(place.v);
  const double fu = place.u - u0, fv = place.v - v0;
  const auto pixel = [&](int u, int v) {
    if (v < 0 || v >= h) {  // beyond a pole the rows come back, half a turn further
      v = v < 0 ? -1 - v : 2 * h - 1 - v;
      u += w / 2;
    }
    return panorama.colour((u % w + w) % w, v);
  };
  const int u = static_cast<int>(u0), v = static_cast<int>(v0);
  const Vec3 above = pixel(u, v) * (1.0 - fu) + pixel(u + 1, v) * fu;
  const Vec3 below = pixel(u, v + 1) * (1.0 - fu) + pixel(u + 1, v + 1) * fu;
  return above * (1.0 - fv) + below * fv;
}

double greatest_luminance(const RadianceMap& map) {
  double greatest = 0.0;
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) greatest = std::max(greatest, luminance(map.colour(u, v)));
  return greatest;
}

RadianceMap shrunk(const RadianceMap& map, int factor) {
  RadianceMap small(map.width / factor, map.height / factor);
  for (int v = 0; v < small.height; ++v)
    for (int u = 0; u < small.width; ++u) {
      Vec3 sum;
      for (int k = 0; k < factor * factor; ++k)
        sum = sum + map.colour(u * factor + k % factor, v * factor + k / factor);
      small.set(u, v, sum * (1.0 / (factor * factor)));
    }
  return small;
}

double tone_mapped_luminance(double radiance, double white) {
  return white > 0.0 ? radiance * (1.0 + radiance / (white * white)) / (1.0 + radiance) : 0.0;
}

Vec3 tone_mapped(Vec3 radiance, double white) {
  const double bright = luminance(radiance);
  return bright > 0.0 ? radiance * (tone_mapped_luminance(bright, white) / bright) : Vec3{};
}

double radiance_of_luminance(double shown, double white) {
  // The positive root of L^2 / white^2 + (1 - shown) L - shown = 0. This form keeps its precision where the root is
  // small.
  const double b = 1.0 - shown, root = std::sqrt(b * b + 4.0 * shown / (white * white));
  return b >= 0.0 ? 2.0 * shown / (b + root) : 0.5 * white * white * (root - b);
}

Vec3 radiance_of(Vec3 shown, double white) {
  const double y = luminance(shown);
  return y > 0.0 ? shown * (radiance_of_luminance(y, white) / y) : Vec3{};
}

void fill_tripod(RadianceMap* panorama) {
  const auto black = [](const float* p) { return p[0] <= 0.0f && p[1] <= 0.0f && p[2] <= 0.0f; };
  for (int u = 0; u < panorama->width; ++u)
    for (int v = std::max(panorama->height / 2, 1); v < panorama->height; ++v)
      if (black(panorama->at(u, v))) std::copy_n(panorama->at(u, v - 1), 3, panorama->at(u, v));
}

Picture picture_of(const RadianceMap& linear, double exposure) {
  Picture picture(linear.width, linear.height, {0, 0, 0});
  for (size_t i = 0; i < linear.rgb.size(); ++i)
    picture.rgb[i] = srgb_byte(static_cast<double>(linear.rgb[i]) * exposure);
  return picture;
}

Picture tone_mapped_picture(const RadianceMap& map, double white) {
  RadianceMap mapped(map.width, map.height);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) mapped.set(u, v, tone_mapped(map.colour(u, v), white));
  return picture_of(mapped);
}

}  // namespace sandglass::host

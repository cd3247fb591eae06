// Equirectangular panoramas of linear radiance, and the one convention on which all of lighting rests. Pixel (u, v) of
// a w x h panorama looks along
//   theta = pi (v + 1/2) / h            the polar angle from +y
//   phi = 2 pi (u + 1/2) / w - pi / 2   the azimuth
// so its centre looks along +z, and places right of the centre have negative x (5.5 and 5.6 with half-pixel centres).
#pragma once

#include <cstddef>
#include <vector>

#include "models/files/image.h"
#include "models/geometry/vec3.h"

namespace sandglass::host {

// Three floats for each pixel, row by row from the top. Panoramas are twice as wide as high; excerpts and renders are
// not.
struct RadianceMap {
  int width = 0, height = 0;
  std::vector<float> rgb;

  RadianceMap() = default;
  RadianceMap(int w, int h) : width(w), height(h), rgb(3 * static_cast<size_t>(w) * static_cast<size_t>(h)) {}
  float* at(int u, int v) {
    return rgb.data() + 3 * (static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u));
  }
  const float* at(int u, int v) const { return const_cast<RadianceMap*>(this)->at(u, v); }
  Vec3 colour(int u, int v) const {
    const float* pixel = at(u, v);
    return {pixel[0], pixel[1], pixel[2]};
  }
  void set(int u, int v, Vec3 c) {
    float* pixel = at(u, v);
    pixel[0] = static_cast<float>(c.x);
    pixel[1] = static_cast<float>(c.y);
    pixel[2] = static_cast<float>(c.z);
  }
};

// Relative luminance of linear BT.709 colours (5.2).
constexpr double luminance(Vec3 c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// A colour as a display shows it: no channel above 1.
constexpr Vec3 limited(Vec3 c) { return {c.x < 1.0 ? c.x : 1.0, c.y < 1.0 ? c.y : 1.0, c.z < 1.0 ? c.z : 1.0}; }

constexpr Vec3 product(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

Vec3 direction_of_angles(double theta, double phi);

// The direction of a place in pixels (an integer is a pixel's centre), and its inverse (5.5, 5.6).
Vec3 panorama_direction(double u, double v, int width, int height);
struct PanoramaPlace {
  double u, v;
};
PanoramaPlace panorama_place(Vec3 direction, int width, int height);

// Of so many pixels; `radiance` gives the colour in a direction.
template <class Radiance>
RadianceMap panorama_of(int width, int height, const Radiance& radiance) {
  RadianceMap map(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) map.set(u, v, radiance(panorama_direction(u, v, width, height)));
  return map;
}

// Solid angle of each pixel of row v (5.23).
double pixel_solid_angle(int v, int width, int height);

// Radiance from a direction (any length but 0), bilinear; columns wrap, and rows go on over the poles.
Vec3 look_up(const RadianceMap& panorama, Vec3 direction);

double greatest_luminance(const RadianceMap& map);

// Means of squares of so many pixels.
RadianceMap shrunk(const RadianceMap& map, int factor);

// Extended Reinhard tone mapping (5.3): maps luminance to 0..1, and `white` (the greatest of the panorama) to 1.
double tone_mapped_luminance(double radiance, double white);
// A colour scaled by the ratio of luminances (5.4): its channels can exceed 1.
Vec3 tone_mapped(Vec3 radiance, double white);

// Stitched panoramas are black where the tripod stood. Each black pixel of the lower half takes the value of the last
// pixel above it that is not black.
void fill_tripod(RadianceMap* panorama);

// The inverse, for luminances below 1 (or that of `white`) and for colours of such luminance.
double radiance_of_luminance(double shown, double white);
Vec3 radiance_of(Vec3 shown, double white);

// Linear radiance times `exposure`, clamped to 1, as sRGB.
Picture picture_of(const RadianceMap& linear, double exposure = 1.0);
// A picture for the eye: tone mapped with `white`, channels clamped to 1, sRGB.
Picture tone_mapped_picture(const RadianceMap& map, double white);

}  // namespace sandglass::host

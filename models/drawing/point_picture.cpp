// See point_picture.h. Each ball is drawn as a disc of pixels with the depth and the normal of a sphere; a depth buffer
// sorts them. Rendered at twice the size and averaged down for smooth rims.
#include "models/drawing/point_picture.h"
#include "models/files/failure.h"

#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "models/mesh/ply.h"

namespace sandglass::host {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector normalised(const Vector& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

constexpr int k_oversampling = 2;
constexpr double k_focal = 2.6;          // of half the picture's smaller side
const Vector k_view = {0.45, 0.4, 0.8};  // from the object towards the camera
const Vector k_light = {0.35, 0.85, 0.4};
const Vector k_sand = {0.80, 0.62, 0.38}, k_background = {0.93, 0.94, 0.95};

struct Canvas {
  int width, height;
  std::vector<float> depth;
  std::vector<Vector> colour;
};

// x right, y up, z towards the camera, in camera space.
void draw_ball(Canvas* canvas, const Vector& centre, double radius, const Vector& light) {
  const double scale = k_focal * 0.5 * std::min(canvas->width, canvas->height) / -centre[2];
  const double px = 0.5 * canvas->width + centre[0] * scale, py = 0.5 * canvas->height - centre[1] * scale;
  const double reach = std::max(radius * scale, 0.7);
  const int x0 = std::max(0, static_cast<int>(px - reach)),
            x1 = std::min(canvas->width - 1, static_cast<int>(px + reach) + 1);
  const int y0 = std::max(0, static_cast<int>(py - reach)),
            y1 = std::min(canvas->height - 1, static_cast<int>(py + reach) + 1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double nx = (x + 0.5 - px) / reach, ny = (py - y - 0.5) / reach, rest = 1 - nx * nx - ny * ny;
      if (rest < 0) continue;
      const Vector normal = {nx, ny, std::sqrt(rest)};
      const float depth = static_cast<float>(-centre[2] - normal[2] * radius);
      const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(canvas->width) + static_cast<size_t>(x);
      if (depth >= canvas->depth[pixel]) continue;
      canvas->depth[pixel] = depth;
      const double shade = 0.28 + 0.72 * std::max(0.0, dot(normal, light));
      for (size_t k = 0; k < 3; ++k) canvas->colour[pixel][k] = k_sand[k] * shade;
    }
}

// Depth differences to the surroundings darken what lies behind a rim: separates near from far.
void darken_behind_rims(Canvas* canvas, double ball_radius) {
  const std::vector<Vector> source = canvas->colour;
  for (int y = 0; y < canvas->height; ++y)
    for (int x = 0; x < canvas->width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(canvas->width) + static_cast<size_t>(x);
      if (canvas->depth[pixel] > 1e20f) continue;
      double occlusion = 0;
      for (int n = 0; n < 16; ++n) {
        const double angle = 2.399963 * n, reach = 1.5 * (n + 1);
        const int sx = x + static_cast<int>(reach * std::cos(angle)),
                  sy = y + static_cast<int>(reach * std::sin(angle));
        if (sx < 0 || sy < 0 || sx >= canvas->width || sy >= canvas->height) continue;
        const size_t other = static_cast<size_t>(sy) * static_cast<size_t>(canvas->width) + static_cast<size_t>(sx);
        const double gap = canvas->depth[pixel] - canvas->depth[other];
        if (gap > 0.5 * ball_radius) occlusion += std::min(1.0, gap / (6 * ball_radius)) / 16;
      }
      for (size_t k = 0; k < 3; ++k) canvas->colour[pixel][k] = source[pixel][k] * (1 - 0.7 * occlusion);
    }
}

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
}

}  // namespace

std::string write_point_picture(const std::string& path, const std::vector<float>& points, float ball_radius, int width,
                                int height) {
  Vector low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  for (size_t i = 0; i + 2 < points.size(); i += 3)
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], static_cast<double>(points[i + k]));
      high[k] = std::max(high[k], static_cast<double>(points[i + k]));
    }
  if (points.size() < 3) return message("draw", path, "there are no points", "Sample at a smaller distance");
  Vector centre;
  double extent = ball_radius;
  for (size_t k = 0; k < 3; ++k) centre[k] = 0.5 * (low[k] + high[k]);
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    Vector d = {points[i] - centre[0], points[i + 1] - centre[1], points[i + 2] - centre[2]};
    extent = std::max(extent, std::sqrt(dot(d, d)) + ball_radius);
  }
  const Vector back = normalised(k_view), right = normalised(cross({0, 1, 0}, back)), up = cross(back, right);
  const Vector light_world = normalised(k_light),
               light = {dot(light_world, right), dot(light_world, up), dot(light_world, back)};
  const double camera_distance = extent * std::sqrt(1 + k_focal * k_focal) * 1.02;

  const size_t wide = static_cast<size_t>(width) * k_oversampling, tall = static_cast<size_t>(height) * k_oversampling;
  Canvas canvas = {static_cast<int>(wide), static_cast<int>(tall), std::vector<float>(wide * tall, 1e30f),
                   std::vector<Vector>(wide * tall, k_background)};
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vector d = {points[i] - centre[0], points[i + 1] - centre[1], points[i + 2] - centre[2]};
    draw_ball(&canvas, {dot(d, right), dot(d, up), dot(d, back) - camera_distance}, ball_radius, light);
  }
  darken_behind_rims(&canvas, ball_radius);

  std::vector<unsigned char> pixels(3 * static_cast<size_t>(width) * static_cast<size_t>(height));
  for (size_t y = 0; y < static_cast<size_t>(height); ++y)
    for (size_t x = 0; x < static_cast<size_t>(width); ++x)
      for (size_t k = 0; k < 3; ++k) {
        double sum = 0;
        for (size_t s = 0; s < k_oversampling * k_oversampling; ++s)
          sum += canvas.colour[(y * k_oversampling + s / k_oversampling) * wide + x * k_oversampling +
                               s % k_oversampling][k];
        const double value = sum / (k_oversampling * k_oversampling);
        pixels[3 * (y * static_cast<size_t>(width) + x) + k] =
            static_cast<unsigned char>(std::clamp(value, 0.0, 1.0) * 255 + 0.5);
      }
  std::string png;
  if (stbi_write_png_to_func(append, &png, width, height, 3, pixels.data(), 3 * width) == 0)
    return message("draw", path, "the picture has no pixel", "Make it larger");
  return write_whole_file(path, png);
}

}  // namespace sandglass::host

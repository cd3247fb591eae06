// See point_picture.h. Each ball is drawn as a disc of pixels with the depth and the normal of a sphere. A depth buffer
// keeps the nearest. The picture is drawn at twice the size and averaged down for smooth rims.
#include "models/drawing/point_picture.h"

#include <algorithm>
#include <cmath>

#include "models/drawing/render.h"
#include "models/files/failure.h"
#include "models/files/image.h"

namespace sandglass::host {
namespace {

constexpr int k_oversampling = 2;
constexpr double k_focal = 2.6;            // in halves of the picture's smaller side
constexpr Vec3 k_view = {0.45, 0.4, 0.8};  // from the object towards the camera
constexpr Vec3 k_light = {0.35, 0.85, 0.4};
constexpr Vec3 k_sand = {0.80, 0.62, 0.38}, k_background = {0.93, 0.94, 0.95};

struct Canvas {
  int width, height;
  std::vector<float> depth;
  std::vector<Vec3> colour;
};

// `centre` and `light` are in camera space: x right, y up, z towards the camera.
void draw_ball(Canvas* canvas, const Vec3& centre, double radius, const Vec3& light) {
  const double scale = k_focal * 0.5 * std::min(canvas->width, canvas->height) / -centre.z;
  const double px = 0.5 * canvas->width + centre.x * scale, py = 0.5 * canvas->height - centre.y * scale;
  const double reach = std::max(radius * scale, 0.7);
  const int x0 = std::max(0, static_cast<int>(px - reach)),
            x1 = std::min(canvas->width - 1, static_cast<int>(px + reach) + 1);
  const int y0 = std::max(0, static_cast<int>(py - reach)),
            y1 = std::min(canvas->height - 1, static_cast<int>(py + reach) + 1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double nx = (x + 0.5 - px) / reach, ny = (py - y - 0.5) / reach, rest = 1 - nx * nx - ny * ny;
      if (rest < 0) continue;
      const Vec3 normal = {nx, ny, std::sqrt(rest)};
      const float depth = static_cast<float>(-centre.z - normal.z * radius);
      const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(canvas->width) + static_cast<size_t>(x);
      if (depth >= canvas->depth[pixel]) continue;
      canvas->depth[pixel] = depth;
      const double shade = 0.28 + 0.72 * std::max(0.0, dot(normal, light));
      canvas->colour[pixel] = k_sand * shade;
    }
}

// Darkens a pixel whose surroundings are nearer to the camera. It separates near balls from far ones.
void darken_behind_rims(Canvas* canvas, double ball_radius) {
  const std::vector<Vec3> source = canvas->colour;
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
      canvas->colour[pixel] = source[pixel] * (1 - 0.7 * occlusion);
    }
}

}  // namespace

std::string write_point_picture(const std::string& path, const std::vector<float>& points, float ball_radius, int width,
                                int height) {
  if (points.size() < 3) return message("draw", path, "there are no points", "Sample at a smaller distance");
  Bounds bounds;
  for (size_t i = 0; i + 2 < points.size(); i += 3) bounds.add(from_floats(&points[i]));
  const Vec3 centre = (bounds.low + bounds.high) * 0.5;
  double extent = ball_radius;
  for (size_t i = 0; i + 2 < points.size(); i += 3)
    extent = std::max(extent, length(from_floats(&points[i]) - centre) + ball_radius);
  const Vec3 back = normalised(k_view), right = normalised(cross({0, 1, 0}, back)), up = cross(back, right);
  const Vec3 light_world = normalised(k_light),
             light = {dot(light_world, right), dot(light_world, up), dot(light_world, back)};
  const double camera_distance = extent * std::sqrt(1 + k_focal * k_focal) * 1.02;

  const size_t wide = static_cast<size_t>(width) * k_oversampling, tall = static_cast<size_t>(height) * k_oversampling;
  Canvas canvas = {static_cast<int>(wide), static_cast<int>(tall), std::vector<float>(wide * tall, 1e30f),
                   std::vector<Vec3>(wide * tall, k_background)};
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vec3 d = from_floats(&points[i]) - centre;
    draw_ball(&canvas, {dot(d, right), dot(d, up), dot(d, back) - camera_distance}, ball_radius, light);
  }
  darken_behind_rims(&canvas, ball_radius);

  Picture picture(width, height, {0, 0, 0});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Vec3 sum;
      for (int s = 0; s < k_oversampling * k_oversampling; ++s)
        sum = sum + canvas.colour[static_cast<size_t>(y * k_oversampling + s / k_oversampling) * wide +
                                  static_cast<size_t>(x * k_oversampling + s % k_oversampling)];
      const Vec3 mean = sum * (1.0 / (k_oversampling * k_oversampling));
      uint8_t* pixel = picture.at(x, y);
      for (const double value : {mean.x, mean.y, mean.z})
        *pixel++ = static_cast<uint8_t>(std::clamp(value, 0.0, 1.0) * 255 + 0.5);
    }
  try {
    write_png(path, picture);
    return "";
  } catch (const Failure& failure) {
    return failure.what();
  }
}

}  // namespace sandglass::host

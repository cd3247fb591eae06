#include "models/lighting/light_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "models/lighting/labels.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/excerpt.h"

namespace sandglass::host {

namespace {

constexpr Colour k_black = {0, 0, 0}, k_white = {255, 255, 255};
constexpr int k_tile_height = 288, k_text_height = 14;
constexpr double k_reflectance = 0.7;      // the reflectance of the floor and the matt ball
constexpr double k_half_angle_deg = 10.0;  // of the soft directional light
constexpr int k_rays = 3;                  // rays along each side of a pixel

void draw_line(Picture* picture, double x0, double y0, double x1, double y1, Colour colour, int thick) {
  const int steps = 1 + static_cast<int>(2.0 * std::hypot(x1 - x0, y1 - y0));
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const int x = static_cast<int>(std::lround(x0 + t * (x1 - x0))),
              y = static_cast<int>(std::lround(y0 + t * (y1 - y0)));
    fill_rectangle(picture, x - thick / 2, y - thick / 2, thick, thick, colour);
  }
}

Vec3 vector_of(const float* v) { return {v[0], v[1], v[2]}; }

// The area that two caps share, divided by the area of the first. Their angular radii are a and b, their distance is s.
double shared_part(double a, double b, double s) {
  if (s >= a + b) return 0.0;
  if (s <= std::fabs(a - b)) return a <= b ? 1.0 : b * b / (a * a);
  const double lens = a * a * std::acos((s * s + a * a - b * b) / (2 * s * a)) +
                      b * b * std::acos((s * s + b * b - a * a) / (2 * s * b)) -
                      0.5 * std::sqrt(std::max(0.0, (-s + a + b) * (s + a - b) * (s - a + b) * (s + a + b)));
  return lens / (std::numbers::pi * a * a);
}

struct Ball {
  Vec3 centre;  // radius 1
  bool mirror;
};

// Two balls side by side in front of a level camera. They lie on the floor y = k_floor.
constexpr double k_floor = 2.6;
const Ball k_balls[2] = {{{-1.15, k_floor - 1.0, 6.0}, false}, {{1.15, k_floor - 1.0, 6.0}, true}};

struct Scene {
  Vec3 light, colour, ambient;  // the light's direction, and strength times colour
  LightLabels labels;           // the labels of the same light, for the environment map

  // The share of the light that reaches a point past the balls.
  double visible(Vec3 point, const Ball* but) const {
    double share = 1.0;
    for (const Ball& ball : k_balls) {
      if (&ball == but) continue;
      const Vec3 to = ball.centre - point;
      const double distance = length(to);
      const double radius = std::asin(std::min(1.0, 1.0 / distance));
      const double apart = std::acos(std::clamp(dot(to, light) / distance, -1.0, 1.0));
      share *= 1.0 - shared_part(k_half_angle_deg * std::numbers::pi / 180.0, radius, apart);
    }
    return share;
  }
  Vec3 matt(Vec3 point, Vec3 normal, double open, const Ball* ball) const {
    const double facing = std::max(0.0, dot(normal, light)) * visible(point, ball);
    return (ambient * open + colour * facing) * k_reflectance;
  }
  Vec3 floor_colour(Vec3 point) const {
    double open = 1.0;  // each ball takes away the form factor of a sphere, (R / d)^2 cos
    for (const Ball& ball : k_balls) {
      const Vec3 to = ball.centre - point;
      const double d = length(to);
      open -= std::max(0.0, -to.y / d) / (d * d);
    }
    return matt(point, {0, -1, 0}, std::max(0.0, open), nullptr);
  }
  static std::optional<double> hit(const Ball& ball, Vec3 from, Vec3 along) {
    const Vec3 to = ball.centre - from;
    const double middle = dot(to, along), root = middle * middle - dot(to, to) + 1.0;
    if (root <= 0.0 || middle <= 0.0) return std::nullopt;
    const double t = middle - std::sqrt(root);
    return t > 1e-6 ? std::optional(t) : std::nullopt;
  }
  Vec3 seen(Vec3 from, Vec3 along, int bounces) const {
    const Ball* ball = nullptr;
    double nearest = along.y > 1e-9 ? (k_floor - from.y) / along.y : 1e9;
    for (const Ball& b : k_balls)
      if (const std::optional<double> t = hit(b, from, along); t && *t < nearest) nearest = *t, ball = &b;
    if (nearest > 1e8) return environment_at(labels, along);
    const Vec3 point = from + along * nearest;
    if (ball == nullptr) return floor_colour(point);
    const Vec3 normal = normalised(point - ball->centre);
    if (!ball->mirror) return matt(point, normal, 1.0, ball);
    if (bounces == 0) return ambient;
    return seen(point, along - normal * (2.0 * dot(along, normal)), bounces - 1);
  }
};

Scene scene_of(const sandglass_light_estimate& e) {
  Scene scene;
  scene.light = normalised(vector_of(e.direction));
  scene.colour = vector_of(e.light) * e.strength;
  scene.ambient = vector_of(e.ambient);
  scene.labels = {scene.light, vector_of(e.light), scene.ambient, 0.0, true};
  return scene;
}

// By means over boxes, or by the nearest pixel.
Picture scaled(const Picture& picture, int width, int height) {
  Picture out(width, height, k_black);
  const double step_x = static_cast<double>(picture.width) / width,
               step_y = static_cast<double>(picture.height) / height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int x0 = static_cast<int>(x * step_x), y0 = static_cast<int>(y * step_y);
      const int x1 = std::clamp(static_cast<int>((x + 1) * step_x), x0 + 1, picture.width);
      const int y1 = std::clamp(static_cast<int>((y + 1) * step_y), y0 + 1, picture.height);
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int v = y0; v < y1; ++v)
          for (int u = x0; u < x1; ++u) sum += picture.at(u, v)[c];
        out.at(x, y)[c] = static_cast<uint8_t>(sum / ((x1 - x0) * (y1 - y0)));
      }
    }
  return out;
}

Picture lit_balls(const sandglass_light_estimate& estimate, int width, int height) {
  const Scene scene = scene_of(estimate);
  Picture picture(width, height, k_black);
  // The window in the image plane z = 1 that contains both balls and the floor around them.
  const double half = 0.52, middle = 0.27, pixel = 2.0 * half / width;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Vec3 sum;
      for (int j = 0; j < k_rays; ++j)
        for (int i = 0; i < k_rays; ++i) {
          const double u = (x + (i + 0.5) / k_rays) * pixel - half;
          const double v = middle + (y + (j + 0.5) / k_rays - 0.5 * height) * pixel;
          const Vec3 colour = scene.seen({0, 0, 0}, normalised(Vec3{u, v, 1.0}), 3);
          sum = sum + Vec3{std::min(1.0, colour.x), std::min(1.0, colour.y), std::min(1.0, colour.z)};
        }
      sum = sum * (1.0 / (k_rays * k_rays));
      uint8_t* out = picture.at(x, y);
      out[0] = srgb_byte(sum.x), out[1] = srgb_byte(sum.y), out[2] = srgb_byte(sum.z);
    }
  return picture;
}

Picture environment_picture(const sandglass_light_estimate& estimate, int width, int height) {
  LightLabels labels = {};
  labels.direction = camera_to_rotated(vector_of(estimate.direction));
  labels.light = vector_of(estimate.light), labels.ambient = vector_of(estimate.ambient);
  Picture picture = picture_of(environment_of(labels, width, height));
  const PanoramaPlace place = panorama_place(labels.direction, width, height);
  const int x = static_cast<int>(std::lround(place.u)), y = static_cast<int>(std::lround(place.v));
  fill_rectangle(&picture, x - 5, y, 11, 1, k_black), fill_rectangle(&picture, x, y - 5, 1, 11, k_black);
  return picture;
}

}  // namespace

void draw_light_arrow(Picture* picture, Vec3 d, Colour colour) {
  const double cx = 0.5 * picture->width, cy = 0.5 * picture->height, reach = 0.42 * picture->height;
  const double x = cx + reach * d.x, y = cy + reach * d.y;
  draw_line(picture, cx, cy, x, y, k_black, 5), draw_line(picture, cx, cy, x, y, colour, 3);
  const int px = static_cast<int>(x), py = static_cast<int>(y);
  fill_rectangle(picture, px - 6, py - 6, 13, 13, k_black), fill_rectangle(picture, px - 5, py - 5, 11, 11, colour);
  if (d.z < 0.0) fill_rectangle(picture, px - 2, py - 2, 5, 5, k_black);
}

void paste(Picture* onto, const Picture& picture, int x, int y) {
  for (int row = 0; row < picture.height; ++row)
    std::copy_n(picture.at(0, row), 3 * picture.width, onto->at(x, y + row));
}

Picture light_picture(const Picture& photograph, const sandglass_light_estimate& estimate, const std::string& name) {
  const int wide = std::clamp(k_tile_height * photograph.width / photograph.height, 64, 3 * k_tile_height);
  const int balls = 4 * k_tile_height / 3, map = 2 * k_tile_height;
  Picture sheet(wide + balls + map + 8, k_tile_height + k_text_height, k_white);
  Picture photo = scaled(photograph, wide, k_tile_height);
  const Vec3 c = vector_of(estimate.light);
  const double top = std::max({c.x, c.y, c.z, 1e-6});
  draw_light_arrow(&photo, vector_of(estimate.direction),
                   {srgb_byte(c.x / top), srgb_byte(c.y / top), srgb_byte(c.z / top)});
  paste(&sheet, photo, 0, k_text_height);
  paste(&sheet, lit_balls(estimate, balls, k_tile_height), wide + 4, k_text_height);
  paste(&sheet, environment_picture(estimate, map, k_tile_height), wide + balls + 8, k_text_height);
  char numbers[160];
  const double azimuth = std::atan2(estimate.direction[0], estimate.direction[2]) * 180.0 / std::numbers::pi;
  const double elevation = std::asin(std::clamp(-estimate.direction[1], -1.0f, 1.0f)) * 180.0 / std::numbers::pi;
  std::snprintf(numbers, sizeof numbers,
                "%s  LIGHT %.0f DEG %s, %.0f %s  COLOUR %.2f %.2f %.2f  AMBIENT %.2f %.2f %.2f  CONTRAST %.2f",
                name.c_str(), std::fabs(azimuth), azimuth < 0 ? "LEFT" : "RIGHT", std::fabs(elevation),
                elevation < 0 ? "DOWN" : "UP", c.x, c.y, c.z, estimate.ambient[0], estimate.ambient[1],
                estimate.ambient[2], estimate.contrast);
  draw_text(&sheet, 3, 3, 1, numbers, k_black);
  return sheet;
}

}  // namespace sandglass::host

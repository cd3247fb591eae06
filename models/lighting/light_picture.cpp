// See light_picture.h.
#include "models/lighting/light_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "models/geometry/vec3.h"

namespace sandglass::host {

namespace {

constexpr Colour k_black = {0, 0, 0}, k_white = {255, 255, 255};
constexpr int k_side = 288, k_text_height = 14, k_gap = 4;  // pixels

void draw_line(Picture* picture, double x0, double y0, double x1, double y1, Colour colour, int thick) {
  const int steps = 1 + static_cast<int>(2.0 * std::hypot(x1 - x0, y1 - y0));
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const int x = static_cast<int>(std::lround(x0 + t * (x1 - x0))),
              y = static_cast<int>(std::lround(y0 + t * (y1 - y0)));
    fill_rectangle(picture, x - thick / 2, y - thick / 2, thick, thick, colour);
  }
}

Colour shown(Vec3 linear) { return {srgb_byte(linear.x), srgb_byte(linear.y), srgb_byte(linear.z)}; }

// An arrow from the middle towards the light as the camera sees it. Its tip is hollow if the light is behind the camera.
void draw_light_arrow(Picture* picture, Vec3 d, Colour colour) {
  const double cx = 0.5 * picture->width, cy = 0.5 * picture->height, reach = 0.42 * picture->height;
  const double x = cx + reach * d.x, y = cy + reach * d.y;
  draw_line(picture, cx, cy, x, y, k_black, 5);
  draw_line(picture, cx, cy, x, y, colour, 3);
  const int px = static_cast<int>(x), py = static_cast<int>(y);
  fill_rectangle(picture, px - 6, py - 6, 13, 13, k_black);
  fill_rectangle(picture, px - 5, py - 5, 11, 11, colour);
  if (d.z < 0.0) fill_rectangle(picture, px - 2, py - 2, 5, 5, k_black);
}

}  // namespace

Picture light_picture(const Picture& photograph, const sandglass_estimator_light& estimate, const std::string& name) {
  const int wide = std::clamp(k_side * photograph.width / photograph.height, 64, 3 * k_side);
  const int swatch = wide + k_gap, half = k_side / 2;
  Picture sheet(swatch + half, k_side + k_text_height, k_white);
  Picture photo = scaled(photograph, wide, k_side);
  const Vec3 light = from_floats(estimate.light), ambient = from_floats(estimate.ambient);
  draw_light_arrow(&photo, from_floats(estimate.direction),
                   shown(light * (1.0 / std::max({light.x, light.y, light.z, 1e-6}))));
  paste(&sheet, photo, 0, k_text_height);
  fill_rectangle(&sheet, swatch, k_text_height, half, half, shown(light));
  fill_rectangle(&sheet, swatch, k_text_height + half, half, half, shown(ambient));
  char text[96];
  const auto label = [&](int x, int y, Colour ink) {
    draw_text(&sheet, x + 1, y + 1, 1, text, k_black);
    draw_text(&sheet, x, y, 1, text, ink);
  };
  std::snprintf(text, sizeof text, "light %.2f %.2f %.2f", light.x, light.y, light.z);
  label(swatch + 6, k_text_height + 6, k_white);
  std::snprintf(text, sizeof text, "ambient %.2f %.2f %.2f", ambient.x, ambient.y, ambient.z);
  label(swatch + 6, k_text_height + half + 6, k_white);
  const double degrees = 180.0 / std::numbers::pi;
  const double azimuth = std::atan2(estimate.direction[0], estimate.direction[2]) * degrees;
  const double elevation = std::asin(std::clamp(-estimate.direction[1], -1.0f, 1.0f)) * degrees;
  std::snprintf(text, sizeof text, "%.40s  %.0f deg %s, %.0f %s, contrast %.2f", name.c_str(), std::fabs(azimuth),
                azimuth < 0 ? "left" : "right", std::fabs(elevation), elevation < 0 ? "down" : "up", estimate.contrast);
  draw_text(&sheet, 3, 3, 1, text, k_black);
  return sheet;
}

}  // namespace sandglass::host

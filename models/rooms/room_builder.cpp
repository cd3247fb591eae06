#include "models/rooms/room_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "models/rooms/panorama.h"

namespace sandglass::host {

namespace {

constexpr int k_sphere_bands = 10;  // from pole to pole
constexpr int k_placing_tries = 10;
constexpr int k_shade_sides = 8;

}  // namespace

double RoomBuilder::log_between(double low, double high) { return low * std::pow(high / low, random.uniform()); }

Vec3 RoomBuilder::colour(Span hue, Span saturation, double bright) {
  const double saturated = between(saturation.low, saturation.high);
  return colour_of_hue(between(hue.low, hue.high), saturated, bright);
}

int RoomBuilder::material(const RoomMaterial& m) {
  room.materials.push_back(m);
  return static_cast<int>(room.materials.size()) - 1;
}

uint32_t RoomBuilder::vertex(Vec3 p) {
  for (const double value : {p.x, p.y, p.z}) room.vertices.push_back(static_cast<float>(value));
  return static_cast<uint32_t>(room.vertices.size() / 3) - 1;
}

void RoomBuilder::triangle(Vec3 a, Vec3 b, Vec3 c, int material, int emitter) {
  const uint32_t first = vertex(a);
  vertex(b);
  vertex(c);
  room.triangles.push_back(
      {{first, first + 1, first + 2}, static_cast<uint16_t>(material), static_cast<int16_t>(emitter)});
}

void RoomBuilder::quad(Vec3 corner, Vec3 a, Vec3 b, int material, int emitter) {
  triangle(corner, corner + a, corner + a + b, material, emitter);
  triangle(corner, corner + a + b, corner + b, material, emitter);
}

int RoomBuilder::quad_emitter(Vec3 corner, Vec3 a, Vec3 b, Vec3 radiance) {
  Emitter e;
  e.corner = corner;
  e.edge_a = a;
  e.edge_b = b;
  e.radiance = radiance;
  room.emitters.push_back(e);
  const int index = static_cast<int>(room.emitters.size()) - 1;
  quad(corner, a, b, material({{0.6, 0.6, 0.6}}), index);
  return index;
}

int RoomBuilder::sphere_emitter(Vec3 centre, double radius, Vec3 radiance) {
  Emitter e;
  e.kind = Emitter::Kind::sphere;
  e.centre = centre;
  e.radius = radius;
  e.radiance = radiance;
  room.emitters.push_back(e);
  const int index = static_cast<int>(room.emitters.size()) - 1;
  sphere(centre, radius, material({{0.8, 0.8, 0.8}}), index);
  return index;
}

void RoomBuilder::box(Vec3 base, Vec3 size, double yaw, int material) {
  const Vec3 x = {std::cos(yaw), 0.0, -std::sin(yaw)}, z = {std::sin(yaw), 0.0, std::cos(yaw)};
  const Vec3 a = x * size.x, b = {0.0, size.y, 0.0}, c = z * size.z;
  const Vec3 low = base - a * 0.5 - c * 0.5;
  quad(low, a, c, material);
  quad(low + b, c, a, material);
  quad(low, b, a, material);
  quad(low + c, a, b, material);
  quad(low, c, b, material);
  quad(low + a, b, c, material);
}

void RoomBuilder::cylinder(Vec3 base, double radius, double height, int sides, int material) {
  const Vec3 up = {0.0, height, 0.0};
  const auto rim = [&](int i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    return base + Vec3{radius * std::cos(angle), 0.0, radius * std::sin(angle)};
  };
  for (int i = 0; i < sides; ++i) {
    quad(rim(i), rim(i + 1) - rim(i), up, material);
    triangle(base + up, rim(i + 1) + up, rim(i) + up, material, -1);
    triangle(base, rim(i), rim(i + 1), material, -1);
  }
}

void RoomBuilder::shade(Vec3 base, double low_radius, double high_radius, double height, Vec3 radiance) {
  for (int i = 0; i < k_shade_sides; ++i) {
    const double from = 2.0 * std::numbers::pi * i / k_shade_sides,
                 to = 2.0 * std::numbers::pi * (i + 1) / k_shade_sides;
    const auto at = [&](double angle, double radius, double y) {
      return base + Vec3{radius * std::cos(angle), y, radius * std::sin(angle)};
    };
    // Each side is a trapezoid. A parallelogram of its mean width stands for it, with the same tilt.
    const double mean = 0.5 * (low_radius + high_radius);
    const Vec3 across = at(from, mean, 0.0) - at(to, mean, 0.0);
    const Vec3 low = (at(from, low_radius, 0.0) + at(to, low_radius, 0.0)) * 0.5;
    const Vec3 high = (at(from, high_radius, height) + at(to, high_radius, height)) * 0.5;
    quad_emitter(low - across * 0.5, across, high - low, radiance);
  }
}

void RoomBuilder::sphere(Vec3 centre, double radius, int material, int emitter) {
  const auto at = [&](int band, int step) {
    return centre +
           direction_of_angles(std::numbers::pi * band / k_sphere_bands, std::numbers::pi * step / k_sphere_bands) *
               radius;
  };
  for (int band = 0; band < k_sphere_bands; ++band)
    for (int step = 0; step < 2 * k_sphere_bands; ++step) {
      const Vec3 a = at(band, step), b = at(band, step + 1), c = at(band + 1, step + 1), d = at(band + 1, step);
      if (band > 0) triangle(a, b, c, material, emitter);
      if (band < k_sphere_bands - 1) triangle(a, c, d, material, emitter);
    }
}

bool RoomBuilder::place_at(double x0, double z0, double x1, double z1) {
  if (x0 < 0.0 || z0 < 0.0 || x1 > room.size.x || z1 > room.size.z) return false;
  for (const Area& area : taken)
    if (x0 < area.x1 && area.x0 < x1 && z0 < area.z1 && area.z0 < z1) return false;
  taken.push_back({x0, z0, x1, z1});
  return true;
}

bool RoomBuilder::place(double width, double depth, Vec3* centre) {
  for (int i = 0; i < k_placing_tries; ++i) {
    const double x = between(0.1, room.size.x - width - 0.1), z = between(0.1, room.size.z - depth - 0.1);
    if (!place_at(x, z, x + width, z + depth)) continue;
    *centre = {x + 0.5 * width, 0.0, z + 0.5 * depth};
    return true;
  }
  return false;
}

Vec3 colour_of_temperature(double kelvin) {
  const double t = 1e3 / std::clamp(kelvin, 1667.0, 25000.0);
  const double x = kelvin < 4000.0 ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
                                   : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390;
  const double y = kelvin < 2222.0   ? ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
                   : kelvin < 4000.0 ? ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
                                     : ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
  const double capital_x = x / y, capital_z = (1.0 - x - y) / y;  // at Y = 1
  const Vec3 linear = {3.2404542 * capital_x - 1.5371385 - 0.4985314 * capital_z,
                       -0.9692660 * capital_x + 1.8760108 + 0.0415560 * capital_z,
                       0.0556434 * capital_x - 0.2040259 + 1.0572252 * capital_z};
  const Vec3 inside = {std::max(linear.x, 0.0), std::max(linear.y, 0.0), std::max(linear.z, 0.0)};
  return inside * (1.0 / luminance(inside));
}

Vec3 colour_of_hue(double hue, double saturation, double bright) {
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + 6.0 * hue, 6.0);
    return 1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
  };
  Vec3 colour = {channel(5.0), channel(3.0), channel(1.0)};
  colour = colour * (bright / luminance(colour));
  return {std::min(colour.x, 0.92), std::min(colour.y, 0.92), std::min(colour.z, 0.92)};
}

}  // namespace sandglass::host

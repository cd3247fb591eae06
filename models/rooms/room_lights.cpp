// Lamps. Each room gets one kind of ceiling light and perhaps standing lamps. Their luminance follows from the flux
// that the room's illuminance needs. So a small lamp dazzles and a large panel does not.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/rooms/panorama.h"
#include "models/rooms/room_builder.h"

namespace sandglass::host {

namespace {

constexpr double k_utilisation = 0.5;  // the share of the lamps' flux that reaches the floor
constexpr double k_drop = 0.015;       // metres from the ceiling down to a lamp's face

struct Lamp {
  int first, count;  // its emitters
  double share;      // its share of the flux
};

double emitter_area(const Emitter& e) {
  return e.kind == Emitter::Kind::sphere ? 4.0 * std::numbers::pi * e.radius * e.radius
                                         : length(cross(e.edge_a, e.edge_b));
}

struct Lamps {
  RoomBuilder* b;
  Vec3 colour;
  int housing;
  std::vector<Lamp> on;

  int count() const { return static_cast<int>(b->room.emitters.size()); }
  void add(int first, double share) { on.push_back({first, count() - first, share}); }

  // A downward rectangle in a shallow housing.
  void panel(double x, double z, double wide, double deep, double y) {
    b->box({x, y, z}, {wide + 0.03, 0.03, deep + 0.03}, 0.0, housing);
    b->quad_emitter({x - 0.5 * wide, y - 0.002, z - 0.5 * deep}, {wide, 0, 0}, {0, 0, deep}, colour);
  }

  void panels() {
    const Vec3 s = b->room.size;
    const double side = b->chance(0.5) ? 0.6 : b->between(0.25, 1.2), other = b->chance(0.5) ? side : 2.0 * side;
    const double burning = b->chance(0.8) ? 1.0 : 0.6;
    grid(b->between(1.4, 2.8), burning,
         [&](double x, double z) { panel(x, z, std::min(side, 0.8 * s.x), std::min(other, 0.8 * s.z), s.y - k_drop); });
  }
  void downlights() {
    const double side = b->between(0.05, 0.14);
    grid(b->between(0.9, 1.8), 0.9, [&](double x, double z) { panel(x, z, side, side, b->room.size.y - k_drop); });
  }
  void strips() {
    const Vec3 s = b->room.size;
    const bool along_x = s.x > s.z;
    const double run = along_x ? s.x : s.z, across = along_x ? s.z : s.x, wide = b->between(0.04, 0.16);
    const double piece = b->chance(0.5) ? std::min(1.2, 0.6 * run) : 0.8 * run, gap = b->between(0.3, 1.6);
    const double drop = s.y > 3.0 && b->chance(0.6) ? b->between(0.2, 1.2) : k_drop;
    const int rows = std::max(1, static_cast<int>(across / b->between(1.8, 3.2)));
    const int pieces = std::max(1, static_cast<int>(run / (piece + gap)));
    for (int r = 0; r < rows; ++r)
      for (int p = 0; p < pieces; ++p) {
        const double a = run * (p + 0.5) / pieces, c = across * (r + 0.5) / rows;
        const int first = count();
        panel(along_x ? a : c, along_x ? c : a, along_x ? piece : wide, along_x ? wide : piece, s.y - drop);
        add(first, 1.0);
      }
  }
  void pendants() {
    const Vec3 s = b->room.size;
    const int lamps = 1 + b->pick(3);
    const bool globes = b->chance(0.5);
    const double radius = b->between(0.06, 0.25),
                 drop = std::max(std::min(b->between(0.3, 1.2), s.y - 1.9), radius + 0.02);
    const bool along_x = b->chance(0.5);
    for (int i = 0; i < lamps; ++i) {
      const double t = (i + 0.5) / lamps;
      const Vec3 at = along_x ? Vec3{s.x * t, s.y - drop, s.z * 0.5} : Vec3{s.x * 0.5, s.y - drop, s.z * t};
      const int first = count();
      b->cylinder(at + Vec3{0, radius, 0}, 0.006, drop - radius, 5, housing);
      if (globes) b->sphere_emitter(at, radius, colour);
      else {
        b->shade(at, 1.2 * radius, 0.5 * radius, radius, colour * 0.6);
        b->sphere_emitter(at + Vec3{0, 0.4 * radius, 0}, 0.3 * radius, colour * 4.0);
      }
      add(first, 1.0);
    }
  }
  void floor_lamp() {
    Vec3 at;
    const double radius = b->between(0.12, 0.28), tall = b->between(1.1, 1.7), shade = b->between(0.2, 0.4);
    if (!b->place(0.6, 0.6, &at)) return;
    b->cylinder(at, 0.15, 0.03, 10, housing);
    b->cylinder(at, 0.012, tall, 6, housing);
    const int first = count();
    b->shade(at + Vec3{0, tall - shade, 0}, radius, radius * b->between(0.6, 1.0), shade, colour);
    add(first, 0.5);
  }
  void globe_on_floor() {
    Vec3 at;
    const double radius = b->between(0.1, 0.25);
    if (!b->place(2.2 * radius, 2.2 * radius, &at)) return;
    const int first = count();
    b->sphere_emitter(at + Vec3{0, radius + b->between(0.0, 0.9), 0}, radius, colour);
    add(first, 0.3);
  }
  void screen() {  // a television or a shining sign on a wall
    const Vec3 s = b->room.size;
    const double wide = std::min(b->between(0.5, 1.6), 0.6 * s.x), tall = wide * b->between(0.3, 0.6);
    const double y = b->between(0.8, std::max(0.81, s.y - tall - 0.4)), x = b->between(0.0, s.x - wide);
    const bool far_side = b->chance(0.5);
    const Vec3 tint = product(colour, b->colour({0.0, 1.0}, {0.1, 0.8}, 1.0));
    const int first = count();
    if (far_side) b->quad_emitter({x, y, s.z - 0.05}, {0, tall, 0}, {wide, 0, 0}, tint);
    else b->quad_emitter({x, y, 0.05}, {wide, 0, 0}, {0, tall, 0}, tint);
    add(first, 0.06);
  }

  template <class Place>
  void grid(double spacing, double burning, Place&& place) {
    const Vec3 s = b->room.size;
    const int nx = std::clamp(static_cast<int>(s.x / spacing), 1, 6),
              nz = std::clamp(static_cast<int>(s.z / spacing), 1, 6);
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nz; ++j) {
        const int first = count();
        place(s.x * (i + 0.5) / nx, s.z * (j + 0.5) / nz);
        if (b->chance(burning)) add(first, 1.0);
        else off(first);
      }
  }
  void off(int first) {
    for (int i = first; i < count(); ++i) b->room.emitters[static_cast<size_t>(i)].radiance = {};
  }

  void set_flux(double flux) {
    double shares = 0.0;
    for (const Lamp& lamp : on) shares += lamp.share;
    for (const Lamp& lamp : on) {
      double unit = 0.0;  // the lamp's flux at the luminances given so far, where `colour` has luminance 1
      for (int i = lamp.first; i < lamp.first + lamp.count; ++i) {
        const Emitter& e = b->room.emitters[static_cast<size_t>(i)];
        unit += std::numbers::pi * luminance(e.radiance) * emitter_area(e);
      }
      const double gain = flux * lamp.share / (shares * unit);
      for (int i = lamp.first; i < lamp.first + lamp.count; ++i) {
        Emitter& e = b->room.emitters[static_cast<size_t>(i)];
        e.radiance = e.radiance * gain;
      }
    }
  }
};

}  // namespace

void light(RoomBuilder* b, bool daylight) {
  RoomMaterial metal;
  const double bright = b->chance(0.5) ? 0.7 : 0.08;
  metal.colour = colour_of_hue(b->between(0.0, 1.0), 0.1, bright);
  Lamps lamps = {b, colour_of_temperature(b->log_between(2400.0, 6800.0)), b->material(metal), {}};
  const bool dark_ceiling = daylight && b->chance(0.6);  // by day most ceiling lights hang there switched off
  const int kind = b->pick(5);
  const int first = lamps.count();
  if (kind == 0) lamps.panels();
  if (kind == 1) lamps.downlights();
  if (kind == 2) lamps.strips();
  if (kind >= 3) lamps.pendants();
  if (dark_ceiling || (!daylight && b->chance(0.2))) {
    lamps.off(first);
    lamps.on.clear();
  }
  const int standing = b->pick(3);
  for (int i = 0; i < standing; ++i) b->chance(0.7) ? lamps.floor_lamp() : lamps.globe_on_floor();
  if (b->chance(0.2)) lamps.screen();
  if (lamps.on.empty() && !daylight) lamps.globe_on_floor();
  if (lamps.on.empty() && !daylight) {
    lamps.panel(0.5 * b->room.size.x, 0.5 * b->room.size.z, 0.4, 0.4, b->room.size.y - k_drop);
    lamps.add(lamps.count() - 1, 1.0);
  }
  const double illuminance = b->log_between(40.0, 600.0);
  lamps.set_flux(illuminance * b->room.size.x * b->room.size.z / k_utilisation);
}

}  // namespace sandglass::host

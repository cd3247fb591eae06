#include "tests/laboratory/sand/carried_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi;

// Boxes about a room from y = `wall`, of this half width and height; its bottom is at y = 0.
Vessel boxes(double r, double half, double high, double wall, double filled, bool lid = false) {
  Vessel v;
  const double middle = wall + 0.5 * high, out = half + 0.5 * wall, wide = half + wall;
  v.part(0, 0.5 * wall, 0, wide, 0.5 * wall, wide);
  for (const double side : {1.0, -1.0}) {
    v.part(side * out, middle, 0, 0.5 * wall, 0.5 * high, wide);
    v.part(0, middle, side * out, wide, 0.5 * high, 0.5 * wall);
  }
  if (lid) v.part(0, wall + high + 0.5 * wall, 0, wide, 0.5 * wall, wide);
  v.room = [=](Vec3 p) {
    const double open = std::min({half - std::fabs(p.x), half - std::fabs(p.z), p.y - wall});
    return lid ? std::min(open, wall + high - p.y) : open;
  };
  const double in = half - 1.05 * r;
  v.fill(r, {-in, wall + 1.05 * r, -in}, {in, wall + filled, in}, [](double, double, double) { return true; });
  return v;
}

// A heap that slopes by this much, on a box or within its rims.
void pile(Vessel* v, double r, double bottom, double wide, double slope) {
  v->sand.clear();
  v->fill(r, {-wide, bottom + 1.05 * r, -wide}, {wide, bottom + 0.2, wide},
          [=](double x, double y, double z) { return std::hypot(x, z) < wide - (y - bottom) * slope; });
}

constexpr double k_wide = 0.052;
Profile glass_line() {
  constexpr double k_neck = 0.0125;
  Profile line;
  for (int i = -48; i <= 48; ++i) {
    const double t = std::fabs(i / 48.0), cap = t > 0.72 ? std::sqrt(1.0 - 0.5 * std::pow((t - 0.72) / 0.28, 2)) : 1.0;
    const double open = std::pow(std::sin(0.5 * k_pi * std::min(1.0, t / 0.6)), 2.2);
    line.push_back({(k_neck + (k_wide - k_neck) * open) * cap, k_glass * i / 48.0});
  }
  return line;
}
Vessel glass(double r) {
  Vessel v;
  Profile outline = glass_line();
  outline.insert(outline.begin(), {0.0, -k_glass});
  outline.push_back({0.0, k_glass});
  v.field = vessel(outline, r);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  const sandglass_field* field = v.field.get();
  v.room = [field](Vec3 p) {
    float at[3];
    to_floats(p, at);
    return static_cast<double>(sandglass_field_distance(field, at, nullptr));
  };
  v.fill(r, {-k_wide, -k_glass + 1.05 * r, -k_wide}, {k_wide, 0.0, k_wide}, [&](double x, double y, double z) {
    return v.room({x, y, z}) > 1.05 * r;
  });
  return v;
}

Vessel cup(double r) {
  constexpr double k_in = 0.06, k_out = 0.072, k_top = 0.152, k_bottom = 0.012;
  Vessel v;
  v.field = vessel({{0, 0}, {k_out, 0}, {k_out, k_top}, {k_in, k_top}, {k_in, k_bottom}, {0, k_bottom}}, 0.004,
                   SANDGLASS_SOLID_INSIDE);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  v.room = [](Vec3 p) { return std::min(k_in - std::hypot(p.x, p.z), p.y - k_bottom); };
  v.fill(r, {-k_in, k_bottom + 1.05 * r, -k_in}, {k_in, 0.1, k_in},
         [=](double x, double, double z) { return std::hypot(x, z) < k_in - 1.05 * r; });
  return v;
}

Vessel bucket(double r) { return boxes(r, 0.06, 0.14, 2 * r, 0.088); }
Vessel jar(double r) { return boxes(r, 12 * r, 20 * r, 2 * r, 11 * r, true); }
Vessel spoon(double r) { return boxes(r, 0.03, 0.03, 2 * r, 0.015); }
Vessel tray(double r) {
  Vessel v = boxes(r, 0.12, 0.02, 2 * r, 0.0);
  pile(&v, r, 2 * r, 0.085, 1.3);
  return v;
}
Vessel plate(double r) {
  Vessel v;
  v.part(0, 0, 0, 0.15, 0.01, 0.15);
  v.room = [](Vec3 p) { return std::min({0.15 - std::fabs(p.x), 0.15 - std::fabs(p.z), p.y - 0.01}); };
  pile(&v, r, 0.01, 0.09, 1.5);
  return v;
}
Vessel ball(double r, double size) {
  Vessel v;
  v.parts = {cpp::sphere(0, 0, 0, static_cast<float>(size))};
  v.room = [=](Vec3 p) { return length(p) - size; };
  v.pushes = true;
  pile(&v, r, 0.0, 0.11, 1.3);
  return v;
}

Vessel hand(double r) { return ball(r, 0.04); }
Vessel finger(double r) { return ball(r, 0.01); }
// A jar in a jar, and a ball beside it.
Vessel nested_jars(double r) {
  Vessel v = jar(r);
  const Vessel inner = boxes(r, 5 * r, 8 * r, 2 * r, 4 * r, true);
  const Vec3 at = {-4 * r, 2 * r, 0}, ball = {7 * r, 6 * r, 0};
  const auto moved = [&](const float* p) { return from_floats(p) + at; };
  v.sand.clear();
  v.fill(r, {-11 * r, 3.1 * r, -11 * r}, {11 * r, 13 * r, 11 * r}, [&](double x, double y, double z) {
    return std::max(std::fabs(x - at.x), std::fabs(z)) > 8.1 * r && length(Vec3{x, y, z} - ball) > 5.1 * r;
  });
  for (size_t i = 0; i < inner.sand.size(); i += 3) add_point(&v.sand, moved(&inner.sand[i]));
  for (sandglass_collider c : inner.parts) {
    to_floats(moved(c.position), c.position);
    v.parts.push_back(c);
  }
  v.parts.push_back(cpp::sphere(0, 0, 0, static_cast<float>(4 * r)));
  to_floats(ball, v.parts.back().position);
  return v;
}

double eased(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10.0 + t * (6.0 * t - 15.0));
}
double wave(double hertz, double t) { return t > 0.0 ? std::sin(2.0 * k_pi * hertz * t) : 0.0; }

// Where each is after so many seconds; before, it stands.
Pose turned(double t) {
  const double lift = 0.03 * std::pow(std::sin(k_pi * std::clamp(t / 1.2, 0.0, 1.0)), 2);
  return {{0, k_stand + lift, 0}, k_pi * eased(t / 1.2)};
}
Pose shaken(double t) { return {{t < 2.0 ? 0.05 * wave(2, t) : 0.0, k_stand, 0}}; }
Pose lifted(double t) { return {{0.3 * eased(2 * t - 1), 0.3 * eased(2 * t), 0}}; }
Pose driven(double t) { return {{eased(t), 0.05, 0}}; }
Pose tilted(double t) { return {{0, 0.2, 0}, 0.5 * (eased(2 * t) - eased(2 * t - 2))}; }
Pose pulled(double t) {
  return {{0.2 * eased(t / 0.4), 0.2 + 0.15 * (eased(t / 0.4 - 1.5) - eased(t / 0.4 - 3.5)), 0}};
}
double pushed(double t) { return 0.5 * std::clamp(t, 0.0, 1.0) - 0.25; }
Pose handed(double t) { return {{pushed(t), 0.045, 0}}; }
Pose fingered(double t) { return {{pushed(t), 0.015, 0}}; }
Pose rocked(double t) { return {{0.06 * wave(1.5, t), 0.1 * eased(t), 0}, 1.2 * eased(t)}; }
Pose spooned(double t) { return {{0.3 * eased((t - 0.4) / 0.8), 0.1 * eased(t / 0.4), 0}, 0.1 * eased(t)}; }
Pose marked(double t) {  // by a hand that tilts the marker about a point half a metre away
  const double angle = 0.06 * wave(0.5, t);
  return {Vec3{-0.5, 0.2, 0} + rotate(rotation_by({0, 0, angle}), {0.5, 0, 0}), angle};
}
Pose rising(double t) { return {{0, k_stand + 0.05 * std::max(t, 0.0), 0}, k_pi}; }

const CarriedScene k_scenes[] = {
    {"glass", k_fine, glass, turned, k_stays, true, true, {2.669, 1.438, 0.696, 0.276, 0.112, 0.061}},
    {"shaken", k_fine, glass, shaken, k_stays, false, false, {2.683, 1.053, 0.446, 0.247, 0.13, 0.065}},
    {"cup", 0.006, cup, lifted, k_rests, false, false, {2.563, 0.947, 0.272, 0.15, 0.079, 0.048}},
    {"bucket", 0.006, bucket, lifted, k_rests, true, true, {2.667, 0.796, 0.319, 0.155, 0.086, 0.046}},
    {"car", 0.006, bucket, driven, k_rests, true, false, {2.54, 0.936, 0.381, 0.208, 0.11, 0.055}},
    {"tray", 0.006, tray, tilted, k_spills, false, false, {2.683, 1.516, 0.7, 0.345, 0.181, 0.098}},
    {"plate", 0.006, plate, pulled, k_spills, false, false, {2.683, 1.411, 0.563, 0.265, 0.139, 0.079}},
    {"hand", 0.006, hand, handed, k_rests, false, false, {2.6, 1.293, 0.328, 0.172, 0.09, 0.045}},
    {"finger", 0.006, finger, fingered, k_rests, false, false, {2.667, 1.374, 0.465, 0.21, 0.117, 0.053}},
    {"jar4", 0.004, jar, rocked, k_stays, true, false, {2.683, 1.083, 0.404, 0.189, 0.092, 0.058}},
    {"jar10", 0.010, jar, rocked, k_stays, false, false, {2.631, 0.944, 0.44, 0.21, 0.104, 0.06}},
    {"spoon", 0.004, spoon, spooned, k_rests, false, false, {2.448, 1.089, 0.453, 0.227, 0.076, 0.06}},
    {"marker", 0.006, tray, marked, k_rests, false, false, {2.498, 1.263, 0.605, 0.307, 0.125, 0.114}},
};
Pose stands(double) { return {{0, k_stand, 0}, k_pi}; }

}  // namespace

// The same with walls, so that there is room beside it; its lower end is open.
Vessel open_glass(double r) {
  Vessel v = glass(r);
  Profile outline = {{0.0, k_glass}}, line = glass_line();
  outline.insert(outline.end(), line.rbegin(), line.rend());
  for (const auto& at : line) outline.push_back({at[0] + 2 * r, at[1]});
  outline.push_back({0.0, k_glass + 2 * r});
  v.room = [](Vec3) { return 0.0; };  // nobody asks
  v.field = vessel(outline, r, SANDGLASS_SOLID_INSIDE);
  v.parts = {cpp::field_at(v.field, 0, 0, 0)};
  return v;
}

std::span<const CarriedScene> carried_scenes() { return k_scenes; }

const CarriedScene k_rising = {"rising", k_fine, glass, rising, k_stays, false, false, {}};
const CarriedScene k_alone = {"alone", k_fine, open_glass, stands, k_stays, false, false, {}};
const CarriedScene k_two_jars = {"two jars", k_fine, nested_jars, rocked, k_stays, false, false, {}};

}  // namespace sandglass::host

#include "tests/laboratory/relief/depth_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/math/random.h"

namespace sandglass::host {

namespace {

// The nearest surface met so far.
struct Meeting {
  double depth = 0;
  void offer(double t) {
    if (t > 0 && (depth == 0 || t < depth)) depth = t;
  }
};

Vec3 turned(Vec3 v, double yaw) {
  const double s = std::sin(yaw), c = std::cos(yaw);
  return {c * v.x - s * v.z, v.y, s * v.x + c * v.z};
}

void meet_box(const Thing& thing, Vec3 from, Vec3 direction, Meeting* meeting) {
  const Vec3 p = turned(from - thing.low_middle - Vec3{0, thing.half.y, 0}, thing.yaw),
             d = turned(direction, thing.yaw);
  const double ps[3] = {p.x, p.y, p.z}, ds[3] = {d.x, d.y, d.z}, hs[3] = {thing.half.x, thing.half.y, thing.half.z};
  double in = -1e9, out = 1e9;
  for (int k = 0; k < 3; ++k) {
    const double a = (-hs[k] - ps[k]) / ds[k], b = (hs[k] - ps[k]) / ds[k];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  if (in <= out) meeting->offer(in);
}

// Where a ray meets an upright cylinder's side: nearer and farther. False: it does not.
bool meet_side(Vec3 p, Vec3 d, double radius, double at[2]) {
  const double a = d.x * d.x + d.z * d.z, b = p.x * d.x + p.z * d.z, c = p.x * p.x + p.z * p.z - radius * radius;
  const double root = b * b - a * c;
  if (root < 0) return false;
  at[0] = (-b - std::sqrt(root)) / a;
  at[1] = (-b + std::sqrt(root)) / a;
  return true;
}

void meet_cylinder(const Thing& thing, Vec3 from, Vec3 direction, Meeting* meeting) {
  const Vec3 p = from - thing.low_middle;
  const double top = 2 * thing.half.y, bottom = thing.inside - thing.low_middle.y;
  double at[2];
  if (!meet_side(p, direction, thing.radius, at)) return;
  const auto height = [&](double t) { return p.y + t * direction.y; };
  const auto aside = [&](double t) { return std::hypot(p.x + t * direction.x, p.z + t * direction.z); };
  if (height(at[0]) >= 0 && height(at[0]) <= top) meeting->offer(at[0]);
  const double rim = (top - p.y) / direction.y, ground = (bottom - p.y) / direction.y;
  if (aside(rim) <= thing.radius && aside(rim) >= thing.hole) meeting->offer(rim);
  if (aside(ground) < thing.hole) meeting->offer(ground);
  if (meet_side(p, direction, thing.hole, at) && height(at[1]) >= bottom && height(at[1]) <= top) meeting->offer(at[1]);
}

// A forearm: a capsule that passes over the table.
void meet_hand(double share, Vec3 from, Vec3 direction, Meeting* meeting) {
  constexpr double k_radius = 0.04;
  const Vec3 a = {-0.5 + share, 0.12, 0.02}, b = a + Vec3{0.1, 0.13, 0.58};
  const double length_ab = length(b - a), dd = dot(direction, direction);
  const Vec3 axis = (b - a) * (1 / length_ab), p = from - a;
  const Vec3 across = direction - axis * dot(direction, axis), aside = p - axis * dot(p, axis);
  const double qa = dot(across, across), qb = dot(across, aside), qc = dot(aside, aside) - k_radius * k_radius;
  if (qb * qb >= qa * qc) {
    const double t = (-qb - std::sqrt(qb * qb - qa * qc)) / qa, along = dot(p + direction * t, axis);
    if (along >= 0 && along <= length_ab) meeting->offer(t);
  }
  for (const Vec3 end : {a, b}) {
    const Vec3 q = from - end;
    const double half = dot(q, direction), root = half * half - dd * (dot(q, q) - k_radius * k_radius);
    if (root >= 0) meeting->offer((-half - std::sqrt(root)) / dd);
  }
}

// Where the device is: it walks about the table and trembles.
struct Standpoint {
  Vec3 position, right, down, ahead;
};
Standpoint standpoint(double t) {
  const double azimuth = 0.61 * std::sin(0.55 * t) + 0.1 * std::sin(1.3 * t), far = 0.70 + 0.10 * std::sin(0.4 * t + 1),
               up = 0.70 + 0.12 * std::sin(0.33 * t);
  Standpoint s;
  s.position = {far * std::cos(up) * std::sin(azimuth) + 0.004 * std::sin(9 * t),
                far * std::sin(up) + 0.004 * std::sin(11 * t + 1),
                far * std::cos(up) * std::cos(azimuth) + 0.004 * std::sin(7.7 * t)};
  const Vec3 at = {0.10 * std::sin(0.9 * t), 0, 0.08 * std::sin(0.6 * t + 0.5)};
  s.ahead = normalised(at - s.position);
  s.right = normalised(cross(s.ahead, {0, 1, 0}));
  s.down = cross(s.ahead, s.right);
  return s;
}

// Of a camera that looks along -z with y up.
void set_pose(const Standpoint& s, Vec3 drift, sandglass_depth_image* image) {
  float matrix[16] = {};
  to_floats(s.right, matrix);
  to_floats(s.down * -1, matrix + 4);
  to_floats(s.ahead * -1, matrix + 8);
  matrix[15] = 1;
  sandglass_camera_orientation(matrix, image->orientation);
  to_floats(s.position + drift, image->position);
}

Vec3 drift_of(double t) {
  const auto way = [t](double much, double fast, double phase) {
    return much * (std::sin(fast * t + phase) - std::sin(phase));
  };
  return {way(0.008, 0.45, 0) + way(0.003, 1.7, 0), way(0.004, 0.6, 1), way(0.008, 0.37, 0.4)};
}

}  // namespace

Thing box_thing(Vec3 low_middle, Vec3 half, double yaw) { return {true, low_middle, half, yaw, 0, 0, 0}; }
Thing cup_thing(Vec3 low_middle, double height, double radius, double wall, double bottom) {
  return {false, low_middle, {radius, 0.5 * height, radius}, 0, radius, radius - wall, low_middle.y + bottom};
}

double Table::height(double x, double z, const TableState& state) const {
  double highest = std::fabs(x) <= k_table[0] && std::fabs(z) <= k_table[1] ? 0 : k_floor;
  const auto add = [&](const Thing& thing) {
    const Vec3 p = turned(Vec3{x, 0, z} - Vec3{thing.low_middle.x, 0, thing.low_middle.z}, thing.yaw);
    const double away = std::hypot(p.x, p.z);
    if (thing.is_box ? std::fabs(p.x) <= thing.half.x && std::fabs(p.z) <= thing.half.z : away <= thing.radius)
      highest = std::max(highest, !thing.is_box && away < thing.hole ? thing.inside : thing.top());
  };
  for (const Thing& thing : things) add(thing);
  if (state.box) add(box);
  return highest;
}

double Table::depth(Vec3 from, Vec3 direction, const TableState& state) const {
  Meeting meeting;
  const auto add = [&](const Thing& thing) {
    if (thing.is_box) meet_box(thing, from, direction, &meeting);
    else meet_cylinder(thing, from, direction, &meeting);
  };
  add(box_thing({0, -0.04, 0}, {k_table[0], 0.02, k_table[1]}));
  meeting.offer((k_floor - from.y) / direction.y);
  for (const Thing& thing : things) add(thing);
  if (state.box) add(box);
  if (state.hand) meet_hand(state.hand_share, from, direction, &meeting);
  return meeting.depth < 4 ? meeting.depth : 0;
}

namespace {

struct Scan {
  std::vector<float> corners;
  void square(const Vec3 (&at)[4]) {
    for (const int i : {0, 1, 2, 0, 2, 3})
      for (const double x : {at[i].x, at[i].y, at[i].z}) corners.push_back(static_cast<float>(x));
  }
  void level(double y, double half_x, double half_z) {
    square({{-half_x, y, -half_z}, {half_x, y, -half_z}, {half_x, y, half_z}, {-half_x, y, half_z}});
  }
  // Between two rings about an axis: a wall, a rim, or a disc where one has no radius.
  void rings(Vec3 middle, const double (&radius)[2], const double (&height)[2]) {
    constexpr int k_sides = 96;
    const auto at = [&](int i, int end) {
      const double angle = 2 * std::numbers::pi * i / k_sides;
      return Vec3{middle.x + radius[end] * std::cos(angle), height[end], middle.z + radius[end] * std::sin(angle)};
    };
    for (int i = 0; i < k_sides; ++i) square({at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1)});
  }
  void box(const Thing& thing) {
    const auto at = [&](int corner, double y) {
      const Vec3 local = {(corner == 0 || corner == 3 ? -1 : 1) * thing.half.x, 0,
                          (corner < 2 ? -1 : 1) * thing.half.z};
      const Vec3 p = turned(local, -thing.yaw) + thing.low_middle;
      return Vec3{p.x, y, p.z};
    };
    const double low = thing.low_middle.y, top = thing.top();
    for (const double y : {low, top}) square({at(0, y), at(1, y), at(2, y), at(3, y)});
    for (int i = 0; i < 4; ++i) square({at(i, low), at((i + 1) % 4, low), at((i + 1) % 4, top), at(i, top)});
  }
};

}  // namespace

std::vector<float> Table::triangles() const {
  Scan scan;
  scan.level(0, k_table[0], k_table[1]);
  scan.level(k_floor, 2, 2);
  scan.level(2.4, 2, 2);
  scan.box(box_thing({0, 0.55, 0}, {0.2, 0.1, 0.2}));  // the lamp
  for (const Thing& thing : things) {
    const double low = thing.low_middle.y, top = thing.top();
    if (thing.is_box) {
      scan.box(thing);
      continue;
    }
    scan.rings(thing.low_middle, {thing.radius, thing.radius}, {low, top});
    scan.rings(thing.low_middle, {thing.radius, thing.hole}, {top, top});
    scan.rings(thing.low_middle, {thing.hole, thing.hole}, {top, thing.inside});
    scan.rings(thing.low_middle, {thing.hole, 0}, {thing.inside, thing.inside});
  }
  return scan.corners;
}

Table usual_table() {
  Table table;
  table.things = {box_thing({-0.25, 0, 0.15}, {0.12, 0.015, 0.085}, 0.35),      // a book of 3 cm
                  box_thing({-0.24, 0.03, 0.15}, {0.10, 0.010, 0.065}, -0.25),  // and one of 2 cm on it
                  box_thing({0.10, 0, 0.25}, {0.10, 0.006, 0.07}, 0.1),         // a thin one
                  box_thing({0.25, 0, -0.15}, {0.09, 0.05, 0.06}, 0.6),         // a carton
                  cup_thing({-0.02, 0, -0.02}, 0.095, 0.04, 0.004, 0.006),      // a cup
                  cup_thing({0.33, 0, 0.12}, 0.065, 0.085, 0.006, 0.009),       // a bowl
                  cup_thing({-0.30, 0, -0.20}, 0.12, 0.07, 0.007, 0.10)};       // a pot of earth
  table.box = box_thing({0.02, 0, -0.25}, {0.05, 0.04, 0.05}, 0.2);
  return table;
}

Table table_with_a_book() {
  Table table;
  table.things = {box_thing({0, 0, 0}, {0.28, 0.015, 0.22})};
  return table;
}

TableState usual_state(double t) {
  constexpr double k_hand[2] = {3.5, 4.7};
  return {t >= k_put && t < k_taken, t >= k_hand[0] && t < k_hand[1], (t - k_hand[0]) / (k_hand[1] - k_hand[0])};
}

DepthRecording record_depth(DepthKind kind, const Table& table, double seconds) {
  const bool lidar = kind == DepthKind::lidar;
  const uint32_t width = lidar ? 256 : 160, height = lidar ? 192 : 90;
  const double view = (lidar ? 60 : 65) * std::numbers::pi / 180;
  DepthRecording recording = {kind, &table, width, height, 0.5 * width / std::tan(0.5 * view), {}};
  for (int i = 0; i < seconds * k_image_rate; ++i) {
    const double t = i / k_image_rate;
    const Standpoint s = standpoint(t);
    std::vector<float>& depths = recording.depths.emplace_back();
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const double a = (x - 0.5 * (width - 1)) / recording.focal, b = (y - 0.5 * (height - 1)) / recording.focal;
        depths.push_back(
            static_cast<float>(table.depth(s.position, s.ahead + s.right * a + s.down * b, usual_state(t))));
      }
  }
  return recording;
}

constexpr uint32_t k_blotch = 6;  // pixels over which noise hangs together

DepthImages::DepthImages(const DepthRecording& recording, const DepthFaults& faults)
    : recording_(recording), faults_(faults), image_(cpp::depth_image()), random_(faults.seed * 7919 + 17) {
  image_.width = recording.width;
  image_.height = recording.height;
  image_.stride = static_cast<int32_t>(2 * recording.width);
  image_.confidence_stride = static_cast<int32_t>(recording.width);
  image_.confidence_min = 128;
  image_.focal_x = image_.focal_y = static_cast<float>(recording.focal);
  image_.centre_x = 0.5f * static_cast<float>(recording.width - 1);
  image_.centre_y = 0.5f * static_cast<float>(recording.height - 1);
  pixels_.resize(size_t{recording.width} * recording.height);
  confidence_.resize(pixels_.size());
  image_.depth = pixels_.data();
  image_.confidence = confidence_.data();
  field_.resize(size_t{recording.width / k_blotch + 3} * (recording.height / k_blotch + 3));
  for (double& f : field_) f = gauss();
}

bool DepthImages::next() {
  if (count_ == recording_.depths.size()) return false;
  seconds_ = static_cast<double>(count_) / k_image_rate;
  drift_ = faults_.drift ? drift_of(seconds_) : Vec3{};
  set_pose(standpoint(seconds_), drift_, &image_);
  image_.timestamp_ns = 1 + static_cast<uint64_t>(1e9 * seconds_);
  add_noise(recording_.depths[count_++]);
  return true;
}

double DepthImages::gauss() {
  Random random{random_};
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  random_ = random.state;
  return sum;
}

void DepthImages::add_noise(const std::vector<float>& exact) {
  constexpr double k_stays = 0.8;  // of a blotch from image to image
  for (double& f : field_) f = k_stays * f + std::sqrt(1 - k_stays * k_stays) * gauss();
  const auto width = static_cast<int>(recording_.width), height = static_cast<int>(recording_.height);
  const bool raw = recording_.kind == DepthKind::raw, lidar = recording_.kind == DepthKind::lidar,
             smoothed = recording_.kind == DepthKind::smoothed;
  const size_t row = recording_.width / k_blotch + 3;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto q = static_cast<size_t>(y * width + x);
      double low = 1e9, high = 0, sum = 0;
      int count = 0;
      const int reach = smoothed ? 2 : 1;
      for (int b = std::max(0, y - reach); b <= std::min(height - 1, y + reach); ++b)
        for (int a = std::max(0, x - reach); a <= std::min(width - 1, x + reach); ++a) {
          const auto v = static_cast<double>(exact[static_cast<size_t>(b * width + a)]);
          if (v <= 0) continue;
          low = std::min(low, v);
          high = std::max(high, v);
          sum += v;
          ++count;
        }
      auto v = static_cast<double>(exact[q]);
      pixels_[q] = confidence_[q] = 0;
      if (v <= 0) continue;
      Random random{random_};
      const double chance = random.uniform(), where = random.uniform();
      random_ = random.state;
      const bool edge = high - low > 0.03;
      if (smoothed) v = sum / count;
      else if (edge && chance < 0.5) v = low + (high - low) * where;  // it flies
      const double gx = static_cast<double>(x) / k_blotch, gy = static_cast<double>(y) / k_blotch;
      const double a = gx - std::floor(gx), b = gy - std::floor(gy);
      const double* f = &field_[static_cast<size_t>(gy) * row + static_cast<size_t>(gx)];
      const double blotch = (1 - a) * (1 - b) * f[0] + a * (1 - b) * f[1] + (1 - a) * b * f[row] + a * b * f[row + 1];
      const double sigma = lidar ? 0.003 * v + 0.001 : 0.01 * v * v;
      v += sigma * (1.17 * blotch + 0.43 * gauss());
      v += lidar ? 0.004 : faults_.bias * static_cast<double>(exact[q]) + 0.006 * std::sin(0.7 * seconds_);
      // Holes of raw depth, 40 % of the picture, move slowly.
      const double hole = std::sin(x * 0.13 + 1.1 * seconds_) + std::sin(y * 0.17 - 0.6 * seconds_) +
                          std::sin((x + y) * 0.09 + 0.3 * seconds_) + 0.7 * blotch;
      if (raw && hole > 0.35) continue;
      const bool doubted = edge && ((raw && chance < 0.5) || (lidar && chance < 0.6));
      confidence_[q] = doubted ? 60 : 255;
      pixels_[q] = static_cast<uint16_t>(std::clamp(1000 * v + 0.5, 0.0, 65535.0));
    }
}

}  // namespace sandglass::host

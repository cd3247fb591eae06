// A room for tests: radiance by direction from the world's origin, a camera that looks at it, and a library's room that
// looks on. No function of the library is used to project or to expose.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/camera_picture.h"

namespace sandglass {

struct Direction {
  double x, y, z;
};
using Radiance = std::function<double(Direction)>;  // grey

inline double degrees(double d) { return d * std::numbers::pi / 180.0; }
// Azimuth from +x to +z.
inline Direction towards(double azimuth_deg, double elevation_deg) {
  const double a = degrees(azimuth_deg), e = degrees(elevation_deg);
  return {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
}
inline double cosine(Direction a, Direction b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double angle_deg(Direction a, Direction b) {
  return std::acos(std::clamp(cosine(a, b), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

inline Direction main_of(const sandglass_room_light& light) {
  const float* d = light.main_direction;
  return {static_cast<double>(d[0]), static_cast<double>(d[1]), static_cast<double>(d[2])};
}

// A dim sphere with one round lamp.
inline Radiance lamp_room(Direction lamp, double half_angle_deg, double radiance, double dim = 0.2) {
  return [=](Direction d) { return angle_deg(d, lamp) < half_angle_deg ? radiance : dim; };
}

struct Photograph {
  sandglass_camera_image image;
  std::vector<uint8_t> bytes;
};

// A phone held upright (portrait), or turned about its lens, whose sensor is stored as it sees.
inline Photograph photograph(const Radiance& radiance, double azimuth_deg, double elevation_deg, double exposure,
                             uint64_t time_ns, double roll_deg = 0) {
  constexpr uint32_t k_width = 96, k_height = 128;
  constexpr double k_focal = 104.0;  // 75 degrees across the diagonal
  const Direction ahead = towards(azimuth_deg, elevation_deg);
  const double a = degrees(azimuth_deg), cosine = std::cos(degrees(roll_deg)), sine = std::sin(degrees(roll_deg));
  const Direction level = {-std::sin(a), 0, std::cos(a)};
  const Direction above = {-level.z * ahead.y, level.z * ahead.x - level.x * ahead.z, level.x * ahead.y};
  const Direction right = {cosine * level.x + sine * above.x, sine * above.y, cosine * level.z + sine * above.z};
  const Direction up = {right.y * ahead.z - right.z * ahead.y, right.z * ahead.x - right.x * ahead.z,
                        right.x * ahead.y - right.y * ahead.x};
  Photograph p;
  p.bytes.resize(3 * k_width * k_height);
  for (uint32_t v = 0; v < k_height; ++v)
    for (uint32_t u = 0; u < k_width; ++u) {
      const double x = (u - 47.5) / k_focal, y = (63.5 - v) / k_focal, n = std::sqrt(1 + x * x + y * y);
      const Direction d = {(ahead.x + x * right.x + y * up.x) / n, (ahead.y + x * right.y + y * up.y) / n,
                           (ahead.z + x * right.z + y * up.z) / n};
      const double linear = std::clamp(radiance(d) * exposure, 0.0, 1.0);
      const double coded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
      for (int c = 0; c < 3; ++c)
        p.bytes[3 * (v * k_width + u) + static_cast<uint32_t>(c)] = static_cast<uint8_t>(std::lround(255 * coded));
    }
  p.image = tests::camera_picture(p.bytes.data(), k_width, k_height, static_cast<float>(k_focal));
  float columns[16] = {};
  for (size_t k = 0; k < 3; ++k) {
    const Direction& axis = k == 0 ? right : k == 1 ? up : ahead;
    const double values[3] = {axis.x, axis.y, axis.z};
    for (size_t row = 0; row < 3; ++row) columns[4 * k + row] = static_cast<float>(k == 2 ? -values[row] : values[row]);
  }
  columns[15] = 1;
  EXPECT_EQ(sandglass_camera_orientation(columns, p.image.orientation), 1);
  p.image.timestamp_ns = time_ns;
  p.image.exposure = static_cast<float>(exposure);
  return p;
}

class MadeUpRoom : public cpp::Room {
 public:
  // `radius`: as the app tells it; 0: it does not.
  explicit MadeUpRoom(float half_life = 1e6f, bool probe = false, bool reflections = false, float radius = 0) {
    sandglass_room_desc desc = cpp::room_desc();
    desc.half_life = half_life;
    desc.radius = radius;
    desc.interval = 0;
    desc.probe = probe ? 1 : 0;
    desc.reflections = reflections ? 1 : 0;
    uint64_t bytes = 0;
    EXPECT_EQ(sandglass_room_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
    EXPECT_LE(bytes, (probe ? 24576u : 16384u) + (reflections ? 98304u : 0u));
    EXPECT_TRUE(create(desc));
  }
  sandglass_room* handle() const { return get(); }

  void look(const Radiance& radiance, double azimuth_deg, double elevation_deg, double exposure = 1.0,
            bool tell_exposure = true, double seconds = 0.1) {
    time_ns_ += static_cast<uint64_t>(seconds * 1e9);
    Photograph p = photograph(radiance, azimuth_deg, elevation_deg, exposure, time_ns_);
    if (!tell_exposure) p.image.exposure = 0;
    show(p.image);
  }
  void show(const sandglass_camera_image& image) {
    ASSERT_EQ(sandglass_room_set_image(get(), &image, &taken_, nullptr), SANDGLASS_OK);
    if (!may_teach_nothing) {
      ASSERT_EQ(taken_, 1);
    }
  }
  bool may_teach_nothing = false;             // whether an image may be refused: black, strange, or of unknown exposure
  bool taken() const { return taken_ == 1; }  // the last image
  void look_everywhere(const Radiance& radiance, double exposure = 1.0) {
    for (int elevation = -80; elevation <= 80; elevation += 40)
      for (int azimuth = 0; azimuth < 360; azimuth += 30) look(radiance, azimuth, elevation, exposure);
  }
  sandglass_room_light light(float x = 0, float y = 0, float z = 0, const sandglass_estimator_light* estimate = nullptr,
                             const sandglass_room_light* shown = nullptr, const float* floor = nullptr) const {
    sandglass_room_light out = {};
    out.struct_size = sizeof out;
    const sandglass_room_place place = {sizeof place, {x, y, z}, estimate, shown, floor, nullptr, nullptr};
    EXPECT_EQ(sandglass_room_get(get(), &place, &out, nullptr), SANDGLASS_OK);
    return out;
  }

 private:
  int32_t taken_ = 0;
  uint64_t time_ns_ = 0;
};

}  // namespace sandglass

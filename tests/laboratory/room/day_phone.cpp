#include "tests/laboratory/room/day_phone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

constexpr double k_wanted = 0.2;  // mean of an image, linear
constexpr uint64_t k_step_ns = 100'000'001;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }
double grey(Vec3 c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

void expect(sandglass_status status, const char* reason) {
  if (status != SANDGLASS_OK) throw Failure(reason);
}

// A tone curve as a camera has it: 17 points (light, value).
constexpr int k_curve_points = 17;
const std::array<float, 2 * k_curve_points> k_curve = [] {
  std::array<float, 2 * k_curve_points> points = {};
  for (int i = 0; i < k_curve_points; ++i) {
    const double light = std::pow(i / double{k_curve_points - 1}, 2);
    points[2 * i] = static_cast<float>(light);
    points[2 * i + 1] = static_cast<float>((1 - std::exp(-3.5 * light)) / (1 - std::exp(-3.5)));
  }
  return points;
}();

// The value, 0..1, that a camera stores for linear light in units of its white: IEC 61966-2-1, and ITU-R BT.2100 with
// the reference white of BT.2408.
double stored(sandglass_transfer transfer, double light) {
  if (transfer == SANDGLASS_TRANSFER_LINEAR) return light;
  if (transfer == SANDGLASS_TRANSFER_HLG) {
    constexpr double k_a = 0.17883277, k_b = 1 - 4 * k_a, k_white = 0.264962560;  // of the scene's light, at 75 %
    static const double c = 0.5 - k_a * std::log(4 * k_a), e = k_white;
    return light * e <= 1.0 / 12 ? std::sqrt(3 * light * e) : k_a * std::log(12 * light * e - k_b) + c;
  }
  if (transfer == SANDGLASS_TRANSFER_PQ) {
    const double root = std::pow(light * 203 / 10000, 2610.0 / 16384);
    return std::pow((3424.0 / 4096 + 2413.0 / 128 * root) / (1 + 2392.0 / 128 * root), 2523.0 / 32);
  }
  if (transfer == SANDGLASS_TRANSFER_CURVE) {
    size_t i = 2;
    while (i + 2 < k_curve.size() && light > static_cast<double>(k_curve[i])) i += 2;
    const auto at = [](size_t k) { return static_cast<double>(k_curve[k]); };
    return at(i - 1) + (at(i + 1) - at(i - 1)) * (light - at(i - 2)) / (at(i) - at(i - 2));
  }
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

// The stored bytes of light up to what PQ can hold, from tables that are far finer than a byte.
constexpr double k_brightest = 10000.0 / 203;
constexpr int k_steps = 1 << 16;
const std::vector<uint8_t>& coded(sandglass_transfer transfer) {
  static const std::vector<std::vector<uint8_t>> tables = [] {
    std::vector<std::vector<uint8_t>> made(SANDGLASS_TRANSFER_CURVE + 1);
    for (size_t t = 0; t < made.size(); ++t)
      for (int i = 0; i <= k_steps; ++i) {
        const double light = k_brightest * std::pow(i / double{k_steps}, 2);  // finer where it is dark
        const double value = stored(static_cast<sandglass_transfer>(t), light);
        made[t].push_back(static_cast<uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))));
      }
    return made;
  }();
  return tables[static_cast<size_t>(transfer)];
}
uint8_t byte_of(const std::vector<uint8_t>& table, double light) {
  return table[static_cast<size_t>(k_steps * std::sqrt(std::clamp(light / k_brightest, 0.0, 1.0)) + 0.5)];
}

}  // namespace

Vec3 direction_of(Gaze gaze) {
  const double a = radians(gaze.azimuth_deg), e = radians(gaze.elevation_deg);
  return {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
}

DayPhone::DayPhone(double speed, bool known, double gain, double radius) : speed_(speed), gain_(gain), known_(known) {
  sandglass_room_desc desc;
  sandglass_room_desc_default(&desc);
  desc.interval = 0;
  desc.radius = static_cast<float>(radius);
  uint64_t bytes = 0;
  const char* reason = nullptr;
  expect(sandglass_room_bytes(&desc, &bytes, &reason), reason);
  block_.resize(bytes / 8 + 16);
  auto at = reinterpret_cast<uintptr_t>(block_.data());
  at += (64 - at % 64) % 64;
  expect(sandglass_room_create(&desc, reinterpret_cast<void*>(at), bytes, &room_, &reason), reason);
}

double DayPhone::take(const World& world, Gaze gaze, double exposure) {
  const Vec3 ahead = direction_of(gaze);
  const double a = radians(gaze.azimuth_deg);
  const Vec3 right = {-std::sin(a), 0, std::cos(a)}, up = cross(right, ahead);
  bytes_.resize(static_cast<size_t>(3 * width * height));
  const std::vector<uint8_t>& table = coded(transfer);
  double sum = 0;
  seen_ = {};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const Vec3 d =
          normalised(ahead + right * ((u - 0.5 * (width - 1)) / focal) + up * ((0.5 * (height - 1) - v) / focal));
      const Vec3 radiance = world(d, position) * exposure;
      const Vec3 c = {radiance.x * gains.x, radiance.y * gains.y, radiance.z * gains.z};
      seen_ = seen_ + Vec3{std::min(radiance.x, 1.0), std::min(radiance.y, 1.0), std::min(radiance.z, 1.0)};
      uint8_t* byte = &bytes_[static_cast<size_t>(3 * (v * width + u))];
      byte[0] = byte_of(table, c.x);
      byte[1] = byte_of(table, c.y);
      byte[2] = byte_of(table, c.z);
      sum += std::min(grey(c), 1.0);
    }
  sandglass_camera_image_default(&image_);
  image_.width = static_cast<uint32_t>(width);
  image_.height = static_cast<uint32_t>(height);
  image_.planes[0] = bytes_.data();
  image_.strides[0] = 3 * width;
  image_.focal_x = image_.focal_y = static_cast<float>(focal);
  image_.centre_x = 0.5f * static_cast<float>(width - 1);
  image_.centre_y = 0.5f * static_cast<float>(height - 1);
  float pose[16] = {};
  to_floats(right, pose);
  to_floats(up, pose + 4);
  to_floats(ahead * -1.0, pose + 8);
  if (sandglass_camera_orientation(pose, image_.orientation) != 1) throw Failure("day: the pose is none");
  to_floats(position, image_.position);
  image_.timestamp_ns = now_ += k_step_ns;
  if (tells_transfer) image_.transfer = transfer;
  if (image_.transfer == SANDGLASS_TRANSFER_CURVE) {
    image_.curve = k_curve.data();
    image_.curve_points = k_curve_points;
  }
  if (tells_gains) to_floats(gains, image_.gains);
  image_.exposure = known_ ? static_cast<float>(exposure) : 0.0f;
  const char* reason = nullptr;
  expect(sandglass_room_set_image(room_, &image_, nullptr, &reason), reason);
  return sum / (width * height);
}

void DayPhone::see(const World& world, Gaze gaze) {
  if (follows > 0 && seen_.x > 0) {
    const double red = std::pow(seen_.y / seen_.x, follows), blue = std::pow(seen_.y / seen_.z, follows);
    gains = gains * 0.9 + Vec3{red, 1, blue} * 0.1;
  }
  const double mean = take(world, gaze, gain_);
  last_gain_ = gain_;
  const double wanted = std::clamp(k_wanted / std::max(mean, 1e-3), 0.02, 50.0);
  gain_ = std::clamp(gain_ * std::exp(speed_ * std::log(wanted)), 1e-4, 1e4);
}

void DayPhone::see_and_obey(const World& world, Gaze gaze) {
  see(world, gaze);
  sandglass_room_light now = light();
  if (now.short_exposure < 1) {
    const sandglass_camera_image ordinary = image_;
    take(world, gaze, last_gain_ * static_cast<double>(now.short_exposure));
    ++shorts;
    image_ = ordinary;
    now = light();
  }
  sandglass_room_fade(&shown, &now, 0.1f);
}

sandglass_room_light DayPhone::light(Vec3 place) const {
  sandglass_room_place at;
  sandglass_room_place_default(&at);
  to_floats(place, at.position);
  if (shown.struct_size != 0) at.shown = &shown;
  sandglass_room_light out = {};
  out.struct_size = sizeof out;
  const char* reason = nullptr;
  expect(sandglass_room_get(room_, &at, &out, &reason), reason);
  return out;
}

double DayPhone::level(Vec3 place) const {
  const sandglass_room_light now = light(place);
  const Vec3 e = from_floats(now.irradiance);
  return grey(e) * static_cast<double>(sandglass_room_exposure(&now, &image_)) / last_gain_;
}

double DayPhone::shown_level() const {
  return grey(from_floats(shown.irradiance)) * static_cast<double>(sandglass_room_exposure(&shown, &image_)) /
         last_gain_;
}

double floor_irradiance(const World& world, Vec3 from) {
  constexpr int k_rows = 240, k_columns = 960;
  double sum = 0;
  for (int row = 0; row < k_rows; ++row)
    for (int column = 0; column < k_columns; ++column) {
      const double e = (row + 0.5) / k_rows * std::numbers::pi / 2,
                   a = 2 * std::numbers::pi * (column + 0.5) / k_columns;
      const Vec3 d = {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
      sum += grey(world(d, from)) * d.y * std::cos(e);
    }
  return sum * std::numbers::pi / 2 / k_rows * 2 * std::numbers::pi / k_columns;
}

}  // namespace sandglass::host

// What the example's app has from its platform: its files, a place for what it says, and a camera in place of ARCore's
// or ARKit's. It shows a room with a lamp in its ceiling. A hand lets it look at the floor, then around, then up, then at
// the floor again. It adapts its exposure and clips, as cameras do.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "sandglass/camera.h"

// A file in 8-byte words, as the library wants it aligned. It has no bytes where it cannot be read.
struct Asset {
  explicit Asset(const char* path) {
    std::ostringstream file;
    file << std::ifstream(path, std::ios::binary).rdbuf();
    const std::string content = file.str();
    words.resize(content.size() / 8 + 1);
    bytes = content.size();
    std::copy(content.begin(), content.end(), reinterpret_cast<char*>(words.data()));
  }
  std::vector<uint64_t> words;
  uint64_t bytes;
};

inline bool save(const char* path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary);
  return file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())).good();
}

inline int fails(const char* what, const char* why) {
  std::fprintf(stderr, "%s: %s\n", what, why);
  return 1;
}

class MadeUpCamera {
 public:
  static constexpr int k_frames = 330;  // what the hand does takes so long

  // The camera gives 30 images a second, the display shows 60: null every other time. Valid until the next call.
  const sandglass_camera_image* next_image() {
    if (++frame_ % 2 == 0) return nullptr;
    hold();
    const bool is_short = short_images_ > 0;
    if (is_short) --short_images_;
    sandglass_camera_image_default(&image_);
    image_.exposure = is_short ? exposure_ * shorter_ : exposure_;
    double sum = 0.0;
    for (int i = 0; i < k_width * k_height; ++i) {
      float ray[3], colour[3];
      const float u = (static_cast<float>(i % k_width) + 0.5f - 0.5f * k_width) / k_focal,
                  v = (0.5f * k_height - static_cast<float>(i / k_width) - 0.5f) / k_focal;
      for (int k = 0; k < 3; ++k) ray[k] = pose_[k] * u + pose_[4 + k] * v - pose_[8 + k];
      look(ray, colour);
      sum += static_cast<double>(std::min(colour[1], 2.0f));
      for (int k = 0; k < 3; ++k) pixels_[static_cast<size_t>(3 * i + k)] = srgb_byte(image_.exposure * colour[k]);
    }
    exposure_ += 0.4f * (0.35f * k_width * k_height / static_cast<float>(sum) - exposure_);
    image_.format = SANDGLASS_CAMERA_RGB;
    image_.width = k_width;
    image_.height = k_height;
    image_.planes[0] = pixels_.data();
    image_.strides[0] = 3 * k_width;
    image_.focal_x = image_.focal_y = k_focal;
    image_.centre_x = 0.5f * (k_width - 1);
    image_.centre_y = 0.5f * (k_height - 1);
    sandglass_camera_orientation(pose_, image_.orientation);
    std::copy(pose_ + 12, pose_ + 15, image_.position);
    image_.timestamp_ns = static_cast<uint64_t>(frame_) * 16'666'667u;
    return &image_;
  }

  // The next images are exposed for so much of the time, for a tenth of a second, because the room takes one image in
  // that time (sandglass_room_desc.interval). An app does not show them.
  void expose_shortly(float shorter) {
    shorter_ = shorter;
    short_images_ = 4;
    ++asked;
  }
  int asked = 0;  // how often

 private:
  static constexpr int k_width = 160, k_height = 120;
  static constexpr float k_focal = 150.0f;  // pixels

  static uint8_t srgb_byte(float v) {
    return static_cast<uint8_t>(
        255 * (v < 0.0031308f ? 12.92f * v : 1.055f * std::pow(std::min(v, 1.0f), 1 / 2.4f) - 0.055f) + 0.5f);
  }

  // The pose as ARKit gives it: columns x, y and z of a camera that looks along -z, and its place. Frames 0 to 12 show
  // the floor; 120 frames are a full turn a little upwards, 120 one at 50 degrees.
  void hold() {
    const bool around = frame_ >= 12 && frame_ < 252;
    const float azimuth = around ? 6.2831853f * static_cast<float>(frame_ - 12) / 120.0f : -0.13f;
    const float elevation = !around ? -0.51f : frame_ < 132 ? 0.17f : 0.87f;
    const float s = std::sin(azimuth), c = std::cos(azimuth), rise = std::sin(elevation), flat = std::cos(elevation);
    const float pose[16] = {c, 0, s, 0, -rise * s, flat, rise * c, 0, -flat * s, -rise, flat * c, 0, 0.4f, 1.15f, 1.5f};
    std::copy(pose, pose + 16, pose_);
  }

  // What is seen along a ray: the room is a box, metres and linear radiance.
  void look(const float* ray, float* colour) const {
    constexpr float k_low[3] = {-2.5f, 0.0f, -2.5f}, k_high[3] = {2.5f, 2.6f, 2.5f};
    constexpr float k_wall[3] = {0.50f, 0.48f, 0.44f}, k_floor[3] = {0.52f, 0.38f, 0.26f},
                    k_lamp[3] = {66.0f, 60.0f, 45.0f};
    float to_wall[3];
    for (int k = 0; k < 3; ++k)
      to_wall[k] = ray[k] == 0.0f ? 1e3f : ((ray[k] > 0.0f ? k_high[k] : k_low[k]) - pose_[12 + k]) / ray[k];
    const auto axis = std::min_element(to_wall, to_wall + 3) - to_wall;
    const float along = to_wall[axis];
    const float x = pose_[12] + along * ray[0] - 1.6f, z = pose_[14] + along * ray[2] - 0.2f;  // from below the lamp
    const bool lamp = axis == 1 && ray[1] > 0.0f && std::hypot(x, z) < 0.28f;
    std::copy_n(lamp ? k_lamp : axis == 1 && ray[1] < 0.0f ? k_floor : k_wall, 3, colour);
  }

  int frame_ = 0, short_images_ = 0;
  float shorter_ = 1.0f;
  float exposure_ = 1.0f, pose_[16] = {};
  std::vector<uint8_t> pixels_ = std::vector<uint8_t>(3 * k_width * k_height);
  sandglass_camera_image image_ = {};
};

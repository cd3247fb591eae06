// See made_up_phone.h.
#include "models/examples/made_up_phone.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace {

constexpr int k_width = 480, k_height = 360;
constexpr float k_focal = 470.0f;            // pixels
constexpr float k_far = 1e3f;                // metres
constexpr float k_door[2] = {-1.2f, 0.55f};  // x of its middle, half its width, metres

float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
void normalise(float* v) {
  const float scale = 1.0f / std::sqrt(dot(v, v));
  for (int k = 0; k < 3; ++k) v[k] *= scale;
}
void cross(const float* a, const float* b, float* c) {
  for (int k = 0; k < 3; ++k) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
float luminance(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

uint8_t srgb_byte(float value) {
  const float v = std::clamp(value, 0.0f, 1.0f);
  const float srgb = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
  return static_cast<uint8_t>(255.0f * srgb + 0.5f);
}

}  // namespace

MadeUpPhone::Asset MadeUpPhone::asset(const std::string& path) {
  Asset asset = {std::vector<uint64_t>(1), 0};
  std::error_code none;
  const uint64_t bytes = std::filesystem::file_size(path, none);  // of a folder there is none
  if (none) return asset;
  asset.words.resize(bytes / 8 + 1);
  std::ifstream file(path, std::ios::binary);
  if (file.read(reinterpret_cast<char*>(asset.words.data()), static_cast<std::streamsize>(bytes))) asset.bytes = bytes;
  return asset;
}

const sandglass_camera_image* MadeUpPhone::next_image() {
  see();
  if (++frame_ % 2 == 0) return nullptr;
  pixels_.resize(linear_.size());
  std::transform(linear_.begin(), linear_.end(), pixels_.begin(), srgb_byte);
  sandglass_camera_image_default(&image_);
  image_.format = SANDGLASS_CAMERA_RGB;
  image_.width = k_width, image_.height = k_height;
  image_.planes[0] = pixels_.data(), image_.strides[0] = 3 * k_width;
  image_.focal_x = image_.focal_y = k_focal;
  image_.centre_x = 0.5f * (k_width - 1), image_.centre_y = 0.5f * (k_height - 1);
  // The pose as ARKit gives it: columns x, y and z of a camera that looks along -z.
  float pose[16] = {};
  for (int k = 0; k < 3; ++k) pose[k] = right_[k], pose[4 + k] = up_[k], pose[8 + k] = -forward_[k];
  sandglass_camera_orientation(pose, image_.orientation);
  image_.timestamp_ns = static_cast<uint64_t>(frame_) * 16'666'667u;
  return &image_;
}

void MadeUpPhone::see() {
  const float t = static_cast<float>(frame_) / 60.0f;
  const float eye[3] = {0.5f + 0.02f * std::sin(1.7f * t), 0.95f + 0.01f * std::sin(2.3f * t), 1.6f},
              target[3] = {0.2f, 0.1f, 0.0f}, above[3] = {0.0f, 1.0f, 0.0f};
  for (int k = 0; k < 3; ++k) eye_[k] = eye[k], forward_[k] = target[k] - eye[k];
  normalise(forward_);
  cross(forward_, above, right_);
  normalise(right_);
  cross(right_, forward_, up_);

  // Planks below a plain wall two metres behind the origin, in which is a door of glass.
  linear_.resize(3 * k_width * k_height);
  depth_.assign(k_width * k_height, k_far);
  for (int y = 0; y < k_height; ++y)
    for (int x = 0; x < k_width; ++x) {
      float ray[3];
      const float u = (static_cast<float>(x) + 0.5f - 0.5f * k_width) / k_focal,
                  v = (0.5f * k_height - static_cast<float>(y) - 0.5f) / k_focal;
      for (int k = 0; k < 3; ++k) ray[k] = forward_[k] + u * right_[k] + v * up_[k];
      const float down = ray[1] < 0.0f ? -eye_[1] / ray[1] : k_far, z = eye_[2] + down * ray[2];
      float* pixel = &linear_[3 * static_cast<size_t>(y * k_width + x)];
      if (down < k_far && z > -2.0f) {
        const float at = eye_[0] + down * ray[0], plank = std::floor(at / 0.14f);
        const float from_door = std::hypot(at - k_door[0], z + 2.0f);
        const float tone = (0.8f + 0.12f * std::sin(12.9f * plank)) * (1.0f + 1.5f / (1.0f + from_door * from_door));
        pixel[0] = 0.42f * tone, pixel[1] = 0.30f * tone, pixel[2] = 0.20f * tone;
      } else {
        const float at = eye_[0] - (eye_[2] + 2.0f) / ray[2] * ray[0];
        const bool door = at > k_door[0] - k_door[1] && at < k_door[0] + k_door[1];
        pixel[0] = door ? 0.98f : 0.42f, pixel[1] = door ? 0.99f : 0.41f, pixel[2] = door ? 1.0f : 0.38f;
      }
    }
}

void MadeUpPhone::darken_floor(const sandglass_light_estimate& light, const sandglass_shadow_texture& shadow,
                               float turn) {
  // Of what the floor receives in each colour, the share that the object can take (light.h).
  float opacity[3];
  for (int k = 0; k < 3; ++k) {
    const float direct = light.contrast * light.light[k] / std::max(luminance(light.light), 1e-6f);
    const float rest = (1.0f - light.contrast) * light.ambient[k] / std::max(luminance(light.ambient), 1e-6f);
    opacity[k] = direct > 0.0f ? shadow.opacity * direct / (direct + rest) : 0.0f;
  }
  const float side = SANDGLASS_SHADOW_TEXELS, sine = std::sin(turn), cosine = std::cos(turn);
  for (int y = 0; y < k_height && shadow.valid != 0; ++y)
    for (int x = 0; x < k_width; ++x) {
      float ray[3];
      const float u = (static_cast<float>(x) + 0.5f - 0.5f * k_width) / k_focal,
                  v = (0.5f * k_height - static_cast<float>(y) - 0.5f) / k_focal;
      for (int k = 0; k < 3; ++k) ray[k] = forward_[k] + u * right_[k] + v * up_[k];
      if (ray[1] >= 0.0f) continue;
      const float along = -eye_[1] / ray[1], on_x = eye_[0] + along * ray[0], on_z = eye_[2] + along * ray[2];
      const float own_x = cosine * on_x - sine * on_z, own_z = sine * on_x + cosine * on_z;
      const float column = (own_x - shadow.low[0]) / (shadow.high[0] - shadow.low[0]) * side;
      const float row = (own_z - shadow.low[1]) / (shadow.high[1] - shadow.low[1]) * side;
      if (!(column >= 0.0f && row >= 0.0f && column < side && row < side)) continue;
      const size_t texel = static_cast<size_t>(row) * SANDGLASS_SHADOW_TEXELS + static_cast<size_t>(column);
      const float covered = static_cast<float>(shadow.coverage[texel]) / 255.0f;
      for (int k = 0; k < 3; ++k)
        linear_[3 * static_cast<size_t>(y * k_width + x) + static_cast<size_t>(k)] *= 1.0f - covered * opacity[k];
    }
}

void MadeUpPhone::draw(const sandglass_light_estimate& light, const sandglass_shadow_texture& shadow, float turn,
                       const std::vector<sandglass_grain>& grains, float particle_radius) {
  darken_floor(light, shadow, turn);
  const float radius = 0.45f * particle_radius;
  for (size_t i = 0; i < grains.size(); ++i) {
    float to[3];
    for (int k = 0; k < 3; ++k) to[k] = grains[i].position[k] - eye_[k];
    const float depth = dot(to, forward_);
    if (depth < 0.05f || grains[i].speed < 0.0f) continue;
    const float size = k_focal * radius / depth, x = 0.5f * k_width + k_focal * dot(to, right_) / depth,
                y = 0.5f * k_height - k_focal * dot(to, up_) / depth;
    if (x < size || y < size || x > k_width - size || y > k_height - size) continue;
    const float shade = 0.8f + 0.4f * static_cast<float>(i * 2654435761u % 1024u) / 1024.0f;
    for (int py = static_cast<int>(y - size); py <= static_cast<int>(y + size) && py < k_height; ++py)
      for (int px = static_cast<int>(x - size); px <= static_cast<int>(x + size) && px < k_width; ++px) {
        const float a = (static_cast<float>(px) + 0.5f - x) / size, b = (y - static_cast<float>(py) - 0.5f) / size;
        const size_t at = static_cast<size_t>(py * k_width + px);
        if (a * a + b * b > 1.0f || depth > depth_[at]) continue;
        depth_[at] = depth;
        const float c = std::sqrt(1.0f - a * a - b * b);
        float normal[3];
        for (int k = 0; k < 3; ++k) normal[k] = a * right_[k] + b * up_[k] - c * forward_[k];
        const float facing = light.strength * std::max(0.0f, dot(normal, light.direction));
        const float sand[3] = {0.62f, 0.42f, 0.21f};
        for (size_t k = 0; k < 3; ++k)
          linear_[3 * at + k] = shade * sand[k] * (light.ambient[k] + facing * light.light[k]);
      }
  }
}

bool MadeUpPhone::save(const std::string& path) const {
  std::string bytes = "P6\n480 360\n255\n";
  for (const float value : linear_) bytes += static_cast<char>(srgb_byte(value));
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file.good();
}

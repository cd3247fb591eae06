// See made_up_phone.h.
#include "models/examples/made_up_phone.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace {

constexpr int k_width = 320, k_height = 240;
constexpr float k_focal = 300.0f;  // pixels
constexpr float k_pi = 3.14159265f;

// The room: a box with a lamp in its ceiling and a door of glass in its back wall, metres and linear radiance.
constexpr float k_low[3] = {-2.5f, 0.0f, -2.5f}, k_high[3] = {2.5f, 2.6f, 2.5f};
constexpr float k_lamp[3] = {1.6f, 0.2f, 0.28f};   // x, z, radius
constexpr float k_door[3] = {-1.7f, -0.7f, 2.1f};  // from x to x, height
constexpr float k_lamp_light[3] = {66.0f, 60.0f, 45.0f}, k_door_light[3] = {6.0f, 7.0f, 8.5f};

float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
void normalise(float* v) {
  const float scale = 1.0f / std::sqrt(dot(v, v));
  for (int k = 0; k < 3; ++k) v[k] *= scale;
}
void cross(const float* a, const float* b, float* c) {
  for (int k = 0; k < 3; ++k) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

uint8_t srgb_byte(float value) {
  const float v = std::clamp(value, 0.0f, 1.0f);
  const float srgb = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
  return static_cast<uint8_t>(255.0f * srgb + 0.5f);
}

// What is seen along a ray from a point in the room. Returns how far away it is, in lengths of the ray.
float look(const float* eye, const float* ray, float* colour) {
  float along = 1e3f;
  int axis = 1;
  for (int k = 0; k < 3; ++k) {
    const float to_wall = ray[k] == 0.0f ? 1e3f : ((ray[k] > 0.0f ? k_high[k] : k_low[k]) - eye[k]) / ray[k];
    if (to_wall < along) along = to_wall, axis = k;
  }
  const float x = eye[0] + along * ray[0], y = eye[1] + along * ray[1], z = eye[2] + along * ray[2];
  float tone[3] = {0.50f, 0.48f, 0.44f};
  const float* shown = tone;
  if (axis == 1 && ray[1] < 0.0f) {
    const float plank = 1.0f + 0.12f * std::sin(12.9f * std::floor(x / 0.14f));
    tone[0] = 0.52f * plank, tone[1] = 0.38f * plank, tone[2] = 0.26f * plank;
  } else if (axis == 1 && std::hypot(x - k_lamp[0], z - k_lamp[1]) < k_lamp[2]) {
    shown = k_lamp_light;
  } else if (axis == 2 && ray[2] < 0.0f && x > k_door[0] && x < k_door[1] && y < k_door[2]) {
    shown = k_door_light;
  }
  std::copy(shown, shown + 3, colour);
  return along;
}

// Points on the chair that the shadow was baked for: on each face of its 14 boxes one every 7 mm.
void cover_chair(std::vector<float>* positions, std::vector<float>* normals) {
  constexpr float k_boxes[][6] = {
      {-0.22f, 0.43f, -0.22f, 0.22f, 0.46f, 0.22f},   {-0.21f, 0.0f, 0.17f, -0.17f, 0.43f, 0.21f},
      {0.17f, 0.0f, 0.17f, 0.21f, 0.43f, 0.21f},      {-0.21f, 0.0f, -0.21f, -0.17f, 0.43f, -0.17f},
      {0.17f, 0.0f, -0.21f, 0.21f, 0.43f, -0.17f},    {-0.21f, 0.46f, -0.21f, -0.17f, 0.90f, -0.17f},
      {0.17f, 0.46f, -0.21f, 0.21f, 0.90f, -0.17f},   {-0.17f, 0.82f, -0.20f, 0.17f, 0.89f, -0.18f},
      {-0.11f, 0.46f, -0.20f, -0.07f, 0.82f, -0.18f}, {-0.02f, 0.46f, -0.20f, 0.02f, 0.82f, -0.18f},
      {0.07f, 0.46f, -0.20f, 0.11f, 0.82f, -0.18f},   {-0.17f, 0.15f, -0.20f, 0.17f, 0.18f, -0.18f},
      {-0.20f, 0.20f, -0.17f, -0.18f, 0.23f, 0.17f},  {0.18f, 0.20f, -0.17f, 0.20f, 0.23f, 0.17f}};
  constexpr float k_spacing = 0.007f;
  for (const auto& box : k_boxes)
    for (int face = 0; face < 6; ++face) {
      const int n = face % 3, u = (n + 1) % 3, v = (n + 2) % 3;
      const auto steps = [&box](int k) { return static_cast<int>(std::ceil((box[k + 3] - box[k]) / k_spacing)); };
      for (int i = 0; i < steps(u); ++i)
        for (int j = 0; j < steps(v); ++j) {
          float at[3], normal[3] = {};
          at[n] = face < 3 ? box[n] : box[n + 3], normal[n] = face < 3 ? -1.0f : 1.0f;
          at[u] = box[u] + (static_cast<float>(i) + 0.5f) / static_cast<float>(steps(u)) * (box[u + 3] - box[u]);
          at[v] = box[v] + (static_cast<float>(j) + 0.5f) / static_cast<float>(steps(v)) * (box[v + 3] - box[v]);
          positions->insert(positions->end(), at, at + 3), normals->insert(normals->end(), normal, normal + 3);
        }
    }
}

// A texture of bytes over low..high, 0..1; `beyond` outside.
float texel(const uint8_t* bytes, uint32_t side, const float* low, const float* high, float x, float z, float beyond) {
  const auto size = static_cast<float>(side);
  const float u = (x - low[0]) / (high[0] - low[0]) * size, v = (z - low[1]) / (high[1] - low[1]) * size;
  if (bytes == nullptr || !(u >= 0.0f && v >= 0.0f && u < size && v < size)) return beyond;
  return static_cast<float>(bytes[static_cast<uint32_t>(v) * side + static_cast<uint32_t>(u)]) / 255.0f;
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

bool MadeUpPhone::save(const std::string& path, const void* data, uint64_t bytes) {
  std::ofstream file(path, std::ios::binary);
  return file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes)).good();
}

MadeUpPhone::MadeUpPhone() { cover_chair(&chair, &chair_normals); }

// Frames 0 to 12 show the chair's place; 120 frames are a full turn a little upwards, 120 one at 50 degrees.
void MadeUpPhone::hold() {
  const float t = static_cast<float>(frame_) / 60.0f, above[3] = {0.0f, 1.0f, 0.0f};
  const float eye[3] = {0.4f + 0.02f * std::sin(1.7f * t), 1.15f + 0.01f * std::sin(2.3f * t), 1.5f};
  const float target[3] = {0.2f, 0.3f, 0.0f};
  const bool around = frame_ >= 12 && frame_ < 252;
  const float azimuth = 2.0f * k_pi * static_cast<float>(frame_ - 12) / 120.0f;
  const float elevation = frame_ < 132 ? 0.17f : 0.87f;
  const float away[3] = {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                         -std::cos(elevation) * std::cos(azimuth)};
  for (int k = 0; k < 3; ++k) eye_[k] = eye[k], forward_[k] = around ? away[k] : target[k] - eye[k];
  normalise(forward_);
  cross(forward_, above, right_);
  normalise(right_);
  cross(right_, forward_, up_);
}

void MadeUpPhone::see() {
  linear_.resize(3 * k_width * k_height);
  depth_.resize(k_width * k_height);
  double sum = 0.0;
  for (size_t i = 0; i < depth_.size(); ++i) {
    float ray[3];
    const float u = (static_cast<float>(i % k_width) + 0.5f - 0.5f * k_width) / k_focal,
                v = (0.5f * k_height - static_cast<float>(i / k_width) - 0.5f) / k_focal;
    for (int k = 0; k < 3; ++k) ray[k] = forward_[k] + u * right_[k] + v * up_[k];
    depth_[i] = look(eye_, ray, &linear_[3 * i]);
    sum += static_cast<double>(std::min(linear_[3 * i + 1], 2.0f));
  }
  const float wanted = 0.35f * static_cast<float>(depth_.size()) / static_cast<float>(sum);
  exposure_ += 0.2f * (wanted - exposure_);  // as cameras adapt
}

const sandglass_camera_image* MadeUpPhone::next_image() {
  hold();
  see();
  const bool is_new = ++frame_ % 2 != 0;
  if (is_new) {
    const float exposure = short_images_ > 0 ? exposure_ / 64.0f : exposure_;
    if (short_images_ > 0) --short_images_;
    pixels_.resize(linear_.size());
    for (size_t i = 0; i < linear_.size(); ++i) pixels_[i] = srgb_byte(exposure * linear_[i]);
    sandglass_camera_image_default(&image_);
    image_.exposure = exposure;
    image_.format = SANDGLASS_CAMERA_RGB;
    image_.width = k_width, image_.height = k_height;
    image_.planes[0] = pixels_.data(), image_.strides[0] = 3 * k_width;
    image_.focal_x = image_.focal_y = k_focal;
    image_.centre_x = 0.5f * (k_width - 1), image_.centre_y = 0.5f * (k_height - 1);
    // The pose as ARKit gives it: columns x, y and z of a camera that looks along -z.
    float pose[16] = {};
    for (int k = 0; k < 3; ++k) pose[k] = right_[k], pose[4 + k] = up_[k], pose[8 + k] = -forward_[k];
    sandglass_camera_orientation(pose, image_.orientation);
    std::copy(eye_, eye_ + 3, image_.position);
    image_.timestamp_ns = static_cast<uint64_t>(frame_) * 16'666'667u;
  }
  for (float& value : linear_) value = std::min(value * exposure_, 1.0f);  // what the display shows
  return is_new ? &image_ : nullptr;
}

void MadeUpPhone::darken_floor(const RoomDrawing& d) {
  const float sine = std::sin(d.chair_turn), cosine = std::cos(d.chair_turn), share = d.light.main_share;
  for (size_t i = 0; i < depth_.size(); ++i) {
    const float u = (static_cast<float>(i % k_width) + 0.5f - 0.5f * k_width) / k_focal,
                v = (0.5f * k_height - static_cast<float>(i / k_width) - 0.5f) / k_focal;
    const float x = eye_[0] + depth_[i] * (forward_[0] + u * right_[0] + v * up_[0]);
    const float y = eye_[1] + depth_[i] * (forward_[1] + u * right_[1] + v * up_[1]);
    const float z = eye_[2] + depth_[i] * (forward_[2] + u * right_[2] + v * up_[2]);
    if (y > 1e-3f) continue;
    const float own_x = cosine * x - sine * z, own_z = sine * x + cosine * z;
    const sandglass_shadow_ambient& a = d.chair_ambient;
    const sandglass_shadow_texture& c = d.chair_sharp;
    const sandglass_pile_shadow_sky& sky = d.sand_sky;
    const sandglass_pile_shadow_texture& s = d.sand_sharp;
    // Of the light, the ambient shadow leaves A; a sharp shadow takes away the main light's share.
    const float by_chair =
        texel(a.visibility, a.side, a.low, a.high, own_x, own_z, 1.0f) -
        share * c.opacity * texel(c.coverage, SANDGLASS_SHADOW_TEXELS, c.low, c.high, own_x, own_z, 0.0f);
    const float by_sand = texel(sky.floor, sky.texels, sky.low, sky.high, x, z, 1.0f) -
                          share * s.opacity * texel(s.coverage, s.texels, s.low, s.high, x, z, 0.0f);
    for (size_t k = 0; k < 3; ++k) linear_[3 * i + k] *= std::max(by_chair, 0.0f) * std::max(by_sand, 0.0f);
  }
}

// A square of `size` metres that faces the camera.
void MadeUpPhone::splat(const float* at, float size, const float* colour) {
  float to[3];
  for (int k = 0; k < 3; ++k) to[k] = at[k] - eye_[k];
  const float depth = dot(to, forward_);
  if (depth < 0.05f) return;
  const float half = 0.5f * k_focal * size / depth, x = 0.5f * k_width + k_focal * dot(to, right_) / depth,
              y = 0.5f * k_height - k_focal * dot(to, up_) / depth;
  const auto first = [](float v) { return std::max(0, static_cast<int>(std::ceil(v - 0.5f))); };
  const int rows = std::min(first(y + half), k_height), columns = std::min(first(x + half), k_width);
  for (int py = first(y - half); py < rows; ++py)
    for (int px = first(x - half); px < columns; ++px) {
      const auto i = static_cast<size_t>(py * k_width + px);
      if (depth > depth_[i]) continue;
      depth_[i] = depth;
      std::copy(colour, colour + 3, &linear_[3 * i]);
    }
}

void MadeUpPhone::draw_chair(const RoomDrawing& d) {
  const float above[3] = {0.0f, 1.0f, 0.0f}, wood[3] = {0.40f, 0.23f, 0.12f};
  const float sine = std::sin(d.chair_turn), cosine = std::cos(d.chair_turn);
  float rotation[4], sh[27];
  sandglass_rotation_about(above, d.chair_turn, rotation);
  if (sandglass_shadow_turn_harmonics(d.light.sh, rotation, sh, nullptr) != SANDGLASS_OK) return;
  for (size_t i = 0; i < chair_transfer.size() / 9; ++i) {
    const float *p = &chair[3 * i], *n = &chair_normals[3 * i];
    const float at[3] = {cosine * p[0] + sine * p[2], p[1], cosine * p[2] - sine * p[0]};
    const float facing[3] = {cosine * n[0] + sine * n[2], n[1], cosine * n[2] - sine * n[0]};
    float from[3], colour[3] = {};
    for (int k = 0; k < 3; ++k) from[k] = at[k] - eye_[k];
    if (dot(from, facing) > 0.0f) continue;
    // What a vertex shader does: nine products a colour (runtime/shadow/README.md).
    for (size_t j = 0; j < 27; ++j) colour[j % 3] += chair_transfer[9 * i + j / 3] * sh[j];
    for (int k = 0; k < 3; ++k) colour[k] = exposure_ * d.light.white * wood[k] * std::max(colour[k], 0.0f);
    splat(at, 0.011f, colour);
  }
}

// In the terms of a renderer: harmonics of all light but the main one, and that one as a directional light.
void MadeUpPhone::draw_sand(const RoomDrawing& d, const std::vector<sandglass_grain>& grains, float particle_radius) {
  sandglass_light_filament lights = {};
  lights.struct_size = sizeof lights;
  if (sandglass_room_to_filament(&d.light, SANDGLASS_LIGHT_MODEL_AMBIENT, 1.0f, &lights, nullptr) != SANDGLASS_OK)
    return;
  const sandglass_pile_shadow_sky& sky = d.sand_sky;
  const sandglass_pile_shadow_texture& sharp = d.sand_sharp;
  const float up = std::max(-lights.direction[1], 0.0f), scale = exposure_ * d.light.white;
  for (size_t i = 0; i < grains.size(); ++i) {
    if (grains[i].speed < 0.0f) continue;
    const float *at = grains[i].position, sand[3] = {0.62f, 0.42f, 0.21f};
    const float left = texel(sky.on_sand, sky.texels, sky.low, sky.high, at[0], at[2], 1.0f);
    const float hidden = sharp.opacity * texel(sharp.on_sand, sharp.texels, sharp.low, sharp.high, at[0], at[2], 0.0f);
    const float shade = 0.8f + 0.4f * static_cast<float>(i * 2654435761u % 1024u) / 1024.0f;
    float colour[3];
    for (int k = 0; k < 3; ++k) {
      const float rest = lights.sh[k] + lights.sh[3 + k] - lights.sh[18 + k] - lights.sh[24 + k];  // facing up
      const float main = lights.intensity * lights.colour[k] * up / k_pi;
      colour[k] = scale * shade * sand[k] * (left * std::max(rest, 0.0f) + (1.0f - hidden) * main);
    }
    splat(at, 0.9f * particle_radius, colour);
  }
}

// The room's light is in the scale of the image that it was taken from; the display shows another exposure. So it is
// multiplied by exposure_ * white.
void MadeUpPhone::draw(const RoomDrawing& d, const std::vector<sandglass_grain>& grains, float particle_radius) {
  darken_floor(d);
  draw_chair(d);
  draw_sand(d, grains, particle_radius);
}

void MadeUpPhone::draw_arrow(const float direction[3]) {
  float x = dot(direction, right_), y = -dot(direction, up_);
  const float length = std::max(std::hypot(x, y), 1e-3f);
  x /= length, y /= length;
  for (int i = 0; i < 60; ++i)
    for (int side = -i / 3; side <= i / 3; ++side) {
      const float along = 110.0f - 0.7f * static_cast<float>(i), aside = 0.6f * static_cast<float>(side);
      const int px = static_cast<int>(0.5f * k_width + along * x - aside * y);
      const int py = static_cast<int>(0.5f * k_height + along * y + aside * x);
      for (int k = 0; k < 3; ++k) linear_[static_cast<size_t>(3 * (py * k_width + px) + k)] = k == 2 ? 0.1f : 0.8f;
    }
}

bool MadeUpPhone::save_picture(const std::string& path) const {
  std::string bytes = "P6\n320 240\n255\n";
  for (const float value : linear_) bytes += static_cast<char>(srgb_byte(value));
  return save(path, bytes.data(), bytes.size());
}

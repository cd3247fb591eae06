// The block of packed grains that the sand kit draws with: two 3D textures that repeat in space, of 64^3 texels, with their
// coarser levels. One: a grain's linear albedo, and how far inside it a place is (0: between grains). Two: where its surface
// faces (0.5: 0), and a number of its own. RGBA8; x runs fastest, then y, then z. The levels come from the finest to 1 texel,
// of each the first texture, then the second.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sandglass::kit {

inline constexpr int k_side = 64, k_cells = 14;    // texels, and cells with a grain each, along a side
inline constexpr int k_faces = 7;                  // that are broken off a grain
inline constexpr std::array k_gains{1.2f, 1.45f};  // of levels: a plane cuts fewer grains than a level's cubes hold
inline constexpr float k_last_gain = 1.5f;

struct Vec {
  float x, y, z;
};
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Mineral {
  float albedo[3], share;
};
// Sand of a beach.
inline constexpr Mineral k_beach[4] = {
    {{.80f, .66f, .46f}, .62f}, {{.90f, .83f, .72f}, .24f}, {{.58f, .34f, .17f}, .09f}, {{.13f, .115f, .10f}, .05f}};

struct Grain {
  Vec middle;
  float albedo[3], lot, radius;  // the radius in cells
  Vec faces[k_faces];            // normals over their distance in radii
};

struct Random {
  uint32_t state = 12345;
  float operator()() {
    state = (state ^ state >> 15) * 0x2c1b3c6du + 0x9e3779b9u;
    state = (state ^ state >> 12) * 0x297a2d39u;
    return static_cast<float>((state ^ state >> 15) >> 8) / 16777216.0f;
  }
};

inline std::vector<Grain> packed_grains(const Mineral* minerals) {
  std::vector<Grain> grains;
  Random random;
  for (int i = 0; i < k_cells * k_cells * k_cells; ++i) {
    const int x = i % k_cells, y = i / k_cells % k_cells, z = i / k_cells / k_cells;
    const float odd = (y & 1) ? 0.7f : 0.2f;
    Grain grain{};
    grain.middle.x = static_cast<float>(x) + odd + 0.65f * random();
    grain.middle.y = static_cast<float>(y) + 0.18f + 0.65f * random();
    grain.middle.z = static_cast<float>(z) + odd + 0.65f * random();
    float kind = random();
    int m = 0;
    while (m < 3 && kind > minerals[m].share) kind -= minerals[m++].share;
    const float light = 0.8f + 0.4f * random();
    for (int k = 0; k < 3; ++k) grain.albedo[k] = minerals[m].albedo[k] * light;
    grain.lot = random(), grain.radius = 0.40f + 0.22f * random();
    for (Vec& face : grain.faces) {
      const float height = 2 * random() - 1, turn = 6.2831853f * random(), across = std::sqrt(1 - height * height);
      const float near = 1 / (0.72f + 0.35f * random());
      face = {across * std::cos(turn) * near, height * near, across * std::sin(turn) * near};
    }
    grains.push_back(grain);
  }
  return grains;
}

using Texel = std::array<float, 8>;  // of both textures
using Level = std::vector<Texel>;

// What lies at a place, in cells: the grain whose surface is nearest, or the one that the place is deepest in.
inline Texel looked_up(const std::vector<Grain>& grains, Vec at) {
  const auto wrapped = [](int i) { return (i + k_cells) % k_cells; };
  const int x = static_cast<int>(at.x), y = static_cast<int>(at.y), z = static_cast<int>(at.z);
  const Grain* nearest = nullptr;
  Vec normal{};
  float least = 9;
  for (int k = z - 1; k <= z + 1; ++k)
    for (int j = y - 1; j <= y + 1; ++j)
      for (int i = x - 2; i <= x + 1; ++i) {
        const int wx = wrapped(i), wy = wrapped(j), wz = wrapped(k), cell = wx + k_cells * (wy + k_cells * wz);
        const Grain& grain = grains[static_cast<size_t>(cell)];
        const Vec from{at.x - grain.middle.x - static_cast<float>(i - wx),
                       at.y - grain.middle.y - static_cast<float>(j - wy),
                       at.z - grain.middle.z - static_cast<float>(k - wz)};
        const float length = std::sqrt(dot(from, from));
        if (0.8f * length - grain.radius > least) continue;
        float far = 0.8f * length;
        Vec facing{from.x / length, from.y / length, from.z / length};
        for (const Vec& face : grain.faces)
          if (const float d = dot(from, face); d > far) far = d, facing = face;
        if (far - grain.radius >= least) continue;
        least = far - grain.radius, nearest = &grain;
        normal = {0.35f * from.x / length + facing.x, 0.35f * from.y / length + facing.y,
                  0.35f * from.z / length + facing.z};
      }
  const float scale = 0.5f / std::sqrt(std::max(dot(normal, normal), 1e-12f));
  const float deep = std::clamp(0.5f - least / nearest->radius * 1.1f, 0.0f, 1.0f);
  return {nearest->albedo[0],      nearest->albedo[1],      nearest->albedo[2],      deep,
          0.5f + scale * normal.x, 0.5f + scale * normal.y, 0.5f + scale * normal.z, nearest->lot};
}

inline Level coarser(const Level& fine, int side, const Texel& mean, float gain) {
  const int half = side / 2;
  Level out(static_cast<size_t>(half * half * half));
  for (int i = 0; i < half * half * half; ++i) {
    const int x = 2 * (i % half), y = 2 * (i / half % half), z = 2 * (i / half / half);
    Texel sum{};
    for (int c = 0; c < 8; ++c) {
      const int from = x + (c & 1) + side * (y + (c >> 1 & 1) + side * (z + (c >> 2)));
      for (size_t k = 0; k < 8; ++k) sum[k] += fine[static_cast<size_t>(from)][k];
    }
    for (size_t k = 0; k < 8; ++k) out[static_cast<size_t>(i)][k] = mean[k] + gain * (sum[k] / 8 - mean[k]);
  }
  return out;
}

inline std::vector<uint8_t> sand_block(const Mineral* minerals) {
  const std::vector<Grain> grains = packed_grains(minerals);
  Level level;
  for (int i = 0; i < k_side * k_side * k_side; ++i) {
    constexpr float k_cell = static_cast<float>(k_cells) / k_side;
    const int x = i % k_side, y = i / k_side % k_side, z = i / k_side / k_side;
    level.push_back(looked_up(grains, {(static_cast<float>(x) + 0.5f) * k_cell, (static_cast<float>(y) + 0.5f) * k_cell,
                                       (static_cast<float>(z) + 0.5f) * k_cell}));
  }
  std::array<double, 8> sum{};
  for (const Texel& texel : level)
    for (size_t k = 0; k < 8; ++k) sum[k] += static_cast<double>(texel[k]) / static_cast<double>(level.size());
  Texel mean;
  for (size_t k = 0; k < 8; ++k) mean[k] = static_cast<float>(sum[k]);
  std::vector<uint8_t> bytes;
  size_t step = 0;
  for (int side = k_side;; side /= 2, ++step) {
    for (size_t texture = 0; texture < 2; ++texture)
      for (const Texel& texel : level)
        for (size_t k = 0; k < 4; ++k)
          bytes.push_back(static_cast<uint8_t>(std::lround(255 * std::clamp(texel[4 * texture + k], 0.0f, 1.0f))));
    if (side == 1) return bytes;
    level = coarser(level, side, mean, step < k_gains.size() ? k_gains[step] : k_last_gain);
  }
}

}  // namespace sandglass::kit

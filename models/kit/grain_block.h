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
inline constexpr std::array k_gains{1.2f, 1.25f};  // of levels: a plane cuts fewer grains than a level's cubes hold
inline constexpr float k_last_gain = 1.2f;

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

// The grains, by the cell that their middle lies in.
struct Packing {
  Vec size;  // in cells
  std::vector<Grain> grains = {};
  std::vector<std::vector<int>> cells = std::vector<std::vector<int>>(static_cast<size_t>(size.x * size.y * size.z));

  std::vector<int>& at(int x, int y, int z) {
    const int wide = static_cast<int>(size.x), high = static_cast<int>(size.y), deep = static_cast<int>(size.z);
    return cells[static_cast<size_t>((x + wide) % wide + wide * ((y + high) % high + high * ((z + deep) % deep)))];
  }
  void sort() {
    for (std::vector<int>& cell : cells) cell.clear();
    for (size_t i = 0; i < grains.size(); ++i) {
      const Vec m = grains[i].middle;
      at(static_cast<int>(m.x), static_cast<int>(m.y), static_cast<int>(m.z)).push_back(static_cast<int>(i));
    }
  }
  // Calls what(number) for every grain whose middle is less than a cell away, and some others.
  template <class What>
  void near(Vec place, const What& what) {
    const int x = static_cast<int>(place.x), y = static_cast<int>(place.y), z = static_cast<int>(place.z);
    for (int c = 0; c < 27; ++c)
      for (const int i : at(x + c % 3 - 1, y + c / 3 % 3 - 1, z + c / 9 - 1)) what(i);
  }
  // From one place to another, the short way round.
  Vec between(Vec from, Vec to) const {
    const auto across = [](float d, float n) { return d - n * std::round(d / n); };
    return {across(to.x - from.x, size.x), across(to.y - from.y, size.y), across(to.z - from.z, size.z)};
  }
  // Grains that overlap push each other away.
  void separate() {
    sort();
    for (size_t i = 0; i < grains.size(); ++i)
      near(grains[i].middle, [&](int k) {
        Grain &a = grains[i], &b = grains[static_cast<size_t>(k)];
        const Vec to = between(a.middle, b.middle);
        const float length = std::sqrt(dot(to, to)), overlap = a.radius + b.radius - length;
        if (&a == &b || overlap <= 0 || length == 0) return;
        const float half = 0.5f * overlap / length;
        a.middle = moved(a.middle, to, -half);
        b.middle = moved(b.middle, to, half);
      });
  }
  Vec moved(Vec from, Vec by, float times) const {
    const auto inside = [](float v, float n) { return v - n * std::floor(v / n); };
    return {inside(from.x + times * by.x, size.x), inside(from.y + times * by.y, size.y),
            inside(from.z + times * by.z, size.z)};
  }
};

inline Packing packed_grains(const Mineral* minerals, Vec size) {
  constexpr int k_rounds = 30;
  Packing packing{size};
  Random random;
  for (size_t i = 0; i < packing.cells.size(); ++i) {
    Grain grain{};
    grain.middle.x = size.x * random();
    grain.middle.y = size.y * random();
    grain.middle.z = size.z * random();
    float kind = random();
    int m = 0;
    while (m < 3 && kind > minerals[m].share) kind -= minerals[m++].share;
    const float light = 0.8f + 0.4f * random();
    for (int k = 0; k < 3; ++k) grain.albedo[k] = minerals[m].albedo[k] * light;
    grain.lot = random();
    grain.radius = 0.40f + 0.22f * random();
    for (Vec& face : grain.faces) {
      const float height = 2 * random() - 1, turn = 6.2831853f * random(), across = std::sqrt(1 - height * height);
      const float near = 1 / (0.72f + 0.35f * random());
      face = {across * std::cos(turn) * near, height * near, across * std::sin(turn) * near};
    }
    packing.grains.push_back(grain);
  }
  for (int i = 0; i < k_rounds; ++i) packing.separate();
  packing.sort();
  return packing;
}

using Texel = std::array<float, 8>;  // of both textures
using Level = std::vector<Texel>;

// What lies at a place, in cells: the grain whose surface is nearest, or the one that the place is deepest in.
inline Texel looked_up(Packing& packing, Vec at) {
  const Grain* nearest = nullptr;
  Vec normal{};
  float gap_min = 9;
  packing.near(at, [&](int i) {
    const Grain& grain = packing.grains[static_cast<size_t>(i)];
    const Vec from = packing.between(grain.middle, at);
    const float length = std::sqrt(dot(from, from));
    if (0.8f * length - grain.radius > gap_min) return;
    float far = 0.8f * length;
    Vec facing{from.x / length, from.y / length, from.z / length};
    for (const Vec& face : grain.faces)
      if (const float d = dot(from, face); d > far) {
        far = d;
        facing = face;
      }
    if (far - grain.radius >= gap_min) return;
    gap_min = far - grain.radius;
    nearest = &grain;
    normal = {0.35f * from.x / length + facing.x, 0.35f * from.y / length + facing.y,
              0.35f * from.z / length + facing.z};
  });
  if (nearest == nullptr) nearest = packing.grains.data();  // far from all: between grains
  const float scale = 0.5f / std::sqrt(std::max(dot(normal, normal), 1e-12f));
  const float deep = std::clamp(0.5f - gap_min / nearest->radius * 1.1f, 0.0f, 1.0f);
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
  Packing packing = packed_grains(minerals, {k_cells, k_cells, k_cells});
  Level level;
  for (int i = 0; i < k_side * k_side * k_side; ++i) {
    constexpr float k_cell = static_cast<float>(k_cells) / k_side;
    const int x = i % k_side, y = i / k_side % k_side, z = i / k_side / k_side;
    level.push_back(
        looked_up(packing, {(static_cast<float>(x) + 0.5f) * k_cell, (static_cast<float>(y) + 0.5f) * k_cell,
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

inline constexpr int k_bed_side = 512, k_bed_blocks = 4;  // texels; sides of the block

// A bed of grains seen from above, for a material without the kit: a texture that repeats, of a heap's linear albedo, and
// darker down between grains. Three numbers a texel.
inline std::vector<float> bed_of_grains(const Mineral* minerals) {
  constexpr float k_wide = k_bed_blocks * k_cells, k_cell = k_wide / k_bed_side, k_top = 3, k_step = 0.05f;
  Packing packing = packed_grains(minerals, {k_wide, 2 * k_top, k_wide});
  std::erase_if(packing.grains, [](const Grain& grain) { return grain.middle.y > k_top; });
  packing.sort();
  float mean[3] = {};
  for (const Grain& grain : packing.grains)
    for (int k = 0; k < 3; ++k) mean[k] += grain.albedo[k] / static_cast<float>(packing.grains.size());
  std::vector<float> out;
  for (int i = 0; i < k_bed_side * k_bed_side; ++i) {
    const float column = static_cast<float>(i % k_bed_side), row = static_cast<float>(i / k_bed_side);
    Vec at{(column + 0.5f) * k_cell, k_top + 1, (row + 0.5f) * k_cell};
    Texel seen = looked_up(packing, at);
    for (; seen[3] < 0.5f && at.y > 1; seen = looked_up(packing, at)) at.y -= k_step;
    const float lit = std::clamp(1 + 0.5f * (at.y - k_top), 0.2f, 1.2f) * (0.3f + 1.4f * (seen[5] - 0.5f));
    for (size_t k = 0; k < 3; ++k) out.push_back(lit * seen[k] * std::pow(mean[k], 0.28f));  // as sand_albedo does
  }
  return out;
}

}  // namespace sandglass::kit

// The shadow of the sand is that of its skin, and of what is in the air.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/skin/skin_mesh.h"

namespace {

// The heights that the pile's shadow is made of are those of the mesh, under each texel's middle; and at rest it costs
// nothing.
TEST(Skin, ThePileShadowIsOfWhatIsDrawn) {
  Sand sand(rough(1600));
  sand.lie(block(10, 16, 10));
  sand.throw_shadow();
  sand.until_rested();
  const Mesh mesh = mesh_of(sand.skin);
  const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_HEIGHTS);
  const sandglass_skin_mesh now = sand.skin.mesh();
  const uint32_t n = sky.side;
  const float texel = sky.along[0] / static_cast<float>(n);
  std::vector<float> truth(n * n, 0.0f);
  for (size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Point p[3];
    for (size_t k = 0; k < 3; ++k) p[k] = place(mesh.vertices[mesh.triangles[t + k]]);
    const auto first = static_cast<uint32_t>((p[0][2] - 0.05f - sky.corner[2]) / texel);  // rows near it
    for (uint32_t at = first * n; at < n * n && at < (first + n / 8) * n; ++at) {
      const uint32_t column = at % n, row = at / n;
      const float x = sky.corner[0] + (static_cast<float>(column) + 0.5f) * texel;
      const float z = sky.corner[2] + (static_cast<float>(row) + 0.5f) * texel;
      const auto side = [&](size_t k) {
        const Point &a = p[k], &b = p[(k + 1) % 3];
        return (b[2] - a[2]) * (x - a[0]) - (b[0] - a[0]) * (z - a[2]);
      };
      const float w[3] = {side(1), side(2), side(0)}, sum = w[0] + w[1] + w[2];
      if (sum > 0 && w[0] >= 0 && w[1] >= 0 && w[2] >= 0)
        truth[at] = std::max(truth[at], (w[0] * p[0][1] + w[1] * p[1][1] + w[2] * p[2][1]) / sum);
    }
  }
  uint32_t wrong = 0, high = 0;
  for (uint32_t at = 0; at < n * n; ++at) {
    high += truth[at] > 0.05f ? 1 : 0;
    wrong += std::abs(static_cast<float>(sky.bytes[at]) * sky.scale / 255 - truth[at]) > sky.scale / 255 ? 1 : 0;
  }
  EXPECT_GT(high, 100u);
  EXPECT_LE(wrong, now.flying_count + now.lying_count);  // loose sand has a column each
}

// Sand on a seat leaves the floor below it the light from beside: all but the form factor of a square of 0.13 m to the
// seat's 0.2, as low as a brick below the seat or the seat, 0.28 to 0.05; the texture's own error is 0.02. Sand on the
// floor, in the same chunk, leaves none.
TEST(Skin, BelowASeatTheFloorIsLit) {
  Sand sand(rough(400));
  sand.scene.add_floor();
  sand.scene.colliders.push_back(sandglass::box(0.12f, 0.30f, 0.12f, 0.1f, 0.01f, 0.1f));  // the seat
  sand.scene.add(shifted(block(6, 2, 6), 0.12f, 0.31f, 0.12f));
  sand.scene.add(shifted(block(6, 5, 6), 0.36f, 0.0f, 0.3f));
  sand.throw_shadow();
  sand.until_rested();
  const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR);
  const auto left = [&](float x, float z) {
    const auto texel = [&](float from, float extent) {
      return static_cast<uint32_t>(from / extent * static_cast<float>(sky.side));
    };
    return sky.bytes[texel(z - sky.corner[2], sky.across[2]) * sky.side + texel(x - sky.corner[0], sky.along[0])] /
           255.0;
  };
  EXPECT_GT(left(0.12f, 0.12f), 0.70);
  EXPECT_LT(left(0.12f, 0.12f), 0.95);
  EXPECT_LT(left(0.36f, 0.3f), 0.1);
}

// Two particles fall, one over a heap at rest, one over the floor. Each takes from the light what its share of its
// outline takes, k_loose of pi r^2 / sine of the elevation; and does so where its ray ends, on the heap or on the
// floor.
TEST(Skin, SandInTheAirThrowsItsOwnShadow) {
  constexpr float k_loose = 0.3f;  // pile_shadow.h: three tenths of a particle's outline
  Sand sand(rough(1600));
  sand.scene.add_floor();
  sand.scene.add(shifted(block(8, 9, 8), -0.25f, 0, 0));
  sand.throw_shadow();
  accept(sand.pile.set_light({0.36f, 0.8f, 0.48f}, 0.02f));
  const uint32_t n = sandglass::pile_shadow_desc().texels;
  const float texel = 1.0f / static_cast<float>(n);
  const auto textures = [&] {
    const uint8_t *floor = sand.pile.texture().bytes, *upper = sand.pile.texture(SANDGLASS_PILE_SHADOW_SAND).bytes;
    std::vector<int> all(floor, floor + n * n);
    all.insert(all.end(), upper, upper + n * n);
    return all;
  };
  sand.until_rested();
  const std::vector<int> before = textures();
  sand.scene.add({-0.115f, 0.42f, 0.18f, 0.25f, 0.42f, -0.1f});
  for (int i = 0; i < 6; ++i) sand.frame();
  for (int i = 0; i < 3; ++i) sand.frame(0);
  const std::vector<int> after = textures();
  const sandglass_skin_mesh mesh = sand.skin.mesh();
  ASSERT_EQ(mesh.flying_count, 2u);
  for (uint32_t k = 0; k < 2; ++k) {
    const sandglass_skin_loose& loose = mesh.loose[k];
    const bool on_heap = loose.position[0] < 0;
    double sum = 0, x = 0, z = 0;
    for (uint32_t i = 0; i < n * n; ++i) {  // of the texture that is drawn there
      if ((static_cast<float>(i % n) < 0.5f * static_cast<float>(n)) != on_heap) continue;
      const uint32_t at = on_heap ? n * n + i : i;
      const double passed = (255.0 - after[at]) / (255.0 - before[at]);
      if (before[at] > 128) continue;
      sum += 1 - passed;
      x += (1 - passed) * (i % n + 0.5);
      z += (1 - passed) * (i / n + 0.5);
    }
    const double outline = k_loose * M_PI * k_radius * k_radius / 0.8 / (texel * texel);
    EXPECT_NEAR(sum, static_cast<double>(loose.weight) * outline, 0.06 * outline) << on_heap;
    // How far its shadow fell, by where it is: down to the heap, or to the floor.
    const double fell_x = (loose.position[0] - (x / sum * texel - 0.5)) / (0.36 / 0.8);
    const double fell_z = (loose.position[2] - (z / sum * texel - 0.5)) / (0.48 / 0.8);
    EXPECT_NEAR(fell_x, fell_z, 1.5 * texel);
    const sandglass_texture sky = sand.pile.texture(SANDGLASS_PILE_SHADOW_HEIGHTS);
    const auto at = static_cast<uint32_t>(x / sum) + n * static_cast<uint32_t>(z / sum);
    const double top = static_cast<double>(sky.bytes[at]) * static_cast<double>(sky.scale) / 255;
    EXPECT_EQ(top > 0.03, on_heap);
    EXPECT_NEAR(fell_z, loose.position[1] - top, (on_heap ? 1.5 : 0.5) * texel);
  }
}

}  // namespace

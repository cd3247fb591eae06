// The light of the room that the sand leaves: against rays cast at its spheres, the promises of its header, and its
// place among the units of the sand's shadow.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "models/tracing/sphere_caster.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"
#include "tests/measured.h"
#include "tests/reason.h"
#include "tests/shadow/pile_fixture.h"

namespace {

using sandglass::host::SphereCaster;
using sandglass::host::SphereHit;
using sandglass::host::Vec3;
using sandglass::test::measured;
using namespace sandglass::tests;
using Cells = std::array<float, SANDGLASS_LIGHT_CELLS>;

constexpr uint32_t k_texels = 128, k_sky = 64;

Cells even_sky() {
  Cells cells;
  cells.fill(1.0f / SANDGLASS_LIGHT_CELLS);
  return cells;
}
Cells single_cell(uint32_t cell) {
  Cells cells{};
  cells[cell] = 1;
  return cells;
}
Cells turned(const Cells& cells, const std::function<uint32_t(uint32_t)>& sector_of) {
  Cells out{};
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) out[i / 16 * 16 + sector_of(i % 16) % 16] = cells[i];
  return out;
}

sandglass_pile_shadow_desc description(uint32_t sky = k_sky) {
  sandglass_pile_shadow_desc desc = sandglass::pile_shadow_desc();
  desc.texels = k_texels;
  desc.sky_texels = sky;
  return desc;
}

// ---- sand

// Grains in `inside`: a lattice that is shaken by a third of a radius, so that its surface is rough.
std::vector<float> grains_in(const std::function<bool(const float*)>& inside) {
  std::vector<float> points = spheres_in(inside, k_grain, 0.2f, 0.3f);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (size_t i = 0; i < points.size(); ++i) {
    const float shaken = 0.35f * k_grain * unit(random);
    if (i % 3 != 1 || points[i] > 1.5f * k_grain) points[i] += shaken;
  }
  return points;
}
std::vector<float> heap() {
  return grains_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.16f - 1.8f * p[1]; });
}
std::vector<float> wall() {
  return grains_in([](const float* p) {
    return std::fabs(p[0] * 0.9f + p[2] * 0.3f) < 0.012f && std::fabs(p[2] * 0.9f - p[0] * 0.3f) < 0.15f &&
           p[1] < 0.07f;
  });
}
// Grains of a scene, after a block of sand has fallen and come to rest.
std::vector<float> poured() {
  const float radius = 0.01f;
  const sandglass::Box box{{-0.08f, radius, -0.08f}, {0.08f, 0.2f, 0.08f}};
  const auto inside = [](const float* p) { return std::hypot(p[0], p[2]) < 0.075f; };
  std::vector<float> particles, grains;
  EXPECT_TRUE(sandglass::sample_lattice(box, 2.02f * radius, inside, &particles));
  for (size_t i = 0; i < particles.size(); i += 3)
    for (int k = 0; k < 16; ++k)
      for (size_t axis = 0; axis < 3; ++axis)
        grains.push_back(particles[i + axis] +
                         0.004f * (static_cast<float>(k >> axis & 1) - 0.5f * static_cast<float>(k >> 3)));
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  desc.granular.grain_radius = k_grain;
  SandOnTheFloor falling(desc);
  EXPECT_TRUE(falling.scene.add(particles, grains));
  for (int frame = 0; frame < 120; ++frame) falling.frame();
  sandglass_scene_grains(falling.scene.get(), grains.data(), nullptr);
  return grains;
}

// ---- rays

using Visibility = std::array<double, SANDGLASS_LIGHT_CELLS>;

// The share of the light of each cell that a surface with this normal receives, and what it would receive with nothing
// in the way. Both are 1 for an open floor.
struct Received {
  Visibility light{}, open{};
};
Received cast(const SphereCaster& sand, const Vec3& point, const Vec3& normal) {
  constexpr int k_side = 3;
  Received received;
  for (uint32_t cell = 0; cell < SANDGLASS_LIGHT_CELLS; ++cell)
    for (int i = 0; i < k_side * k_side; ++i) {
      // Equal parts of a cell are even in the azimuth and in sin^2 of the elevation.
      const double turn = (cell % 16 + (i % k_side + 0.5) / k_side) * std::numbers::pi / 8;
      const double square = (cell / 16 + (i / k_side + 0.5) / k_side) / 4, flat = std::sqrt(1 - square);
      const Vec3 ray = {flat * std::cos(turn), std::sqrt(square), flat * std::sin(turn)};
      const double light = std::max(dot(ray, normal), 0.0) / ray.y / (k_side * k_side);
      received.open[cell] += light;
      if (light > 0 && !sand.occluded(point, ray, 10)) received.light[cell] += light;
    }
  return received;
}
double lit(const Visibility& light, const Cells& cells) {
  double sum = 0;
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) sum += static_cast<double>(cells[i]) * light[i];
  return sum;
}

// A place with the truth: a point of the floor, one of the sand that is seen from above, or the centre of a grain. The
// truth of a grain is that of its topmost point.
struct Receiver {
  std::array<float, 3> at;
  Received truth;
};

constexpr Vec3 k_up = {0, 1, 0};
Receiver floor_point(const SphereCaster& caster, double x, double z) {
  return {{static_cast<float>(x), 0, static_cast<float>(z)}, cast(caster, {x, 1e-5, z}, k_up)};
}

struct Sand {
  std::string name;
  std::vector<float> spheres;
  std::vector<Receiver> floor, seen, grains;

  Sand(const char* n, const std::vector<float>& s) : name(n), spheres(s) {
    const SphereCaster caster(spheres, k_grain);
    for (int i = 0; i < 32; ++i)
      for (int j = 0; j < 32; ++j) {
        const double x = 0.02 * (i - 15.63), z = 0.02 * (j - 15.39);
        if (!caster.occluded({x, 0, z}, k_up, 2 * double{k_grain})) floor.push_back(floor_point(caster, x, z));
      }
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-0.2, 0.2);
    std::set<uint32_t> taken;
    for (int i = 0; i < 20000 && seen.size() < 500; ++i) {
      SphereHit hit;
      hit.distance = 10;
      const double x = unit(random), z = unit(random);
      if (!caster.closest({x, 5, z}, {0, -1, 0}, &hit)) continue;
      const float* c = spheres.data() + 3 * size_t{hit.index};
      const Vec3 centre = {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
      const Vec3 point = {x, 5 - hit.distance, z}, normal = (point - centre) * (1 / double{k_grain});
      seen.push_back({{static_cast<float>(x), static_cast<float>(point.y), static_cast<float>(z)},
                      cast(caster, point + normal * 1e-5, normal)});
      const Vec3 top = centre + k_up * (double{k_grain} + 1e-5);
      if (taken.insert(hit.index).second) grains.push_back({{c[0], c[1], c[2]}, cast(caster, top, k_up)});
    }
  }
};

// ---- what the textures show

constexpr sandglass_pile_shadow_part k_floor = SANDGLASS_PILE_SHADOW_SKY_FLOOR,
                                     k_upper = SANDGLASS_PILE_SHADOW_SKY_SAND,
                                     k_heights = SANDGLASS_PILE_SHADOW_HEIGHTS;

// Between the middles of the texels, as a GPU samples.
double sampled(const sandglass_texture& t, const std::array<float, 3>& at) {
  const float low[2] = {t.corner[0], t.corner[2]}, extents[2] = {t.along[0], t.across[2]};
  const uint32_t texels = t.side;
  uint32_t texel[2];
  double beyond[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const double place =
        static_cast<double>(at[2 * axis] - low[axis]) / static_cast<double>(extents[axis]) * texels - 0.5;
    texel[axis] = static_cast<uint32_t>(std::min(std::max(place, 0.0), texels - 2.0));
    beyond[axis] = std::min(std::max(place - texel[axis], 0.0), 1.0);
  }
  const uint8_t* row = t.bytes + texel[1] * texels + texel[0];
  const auto along = [&](const uint8_t* p) { return p[0] * (1 - beyond[0]) + p[1] * beyond[0]; };
  return (along(row) * (1 - beyond[1]) + along(row + texels) * beyond[1]) / 255;
}

struct Error {
  double rmse = 0, without = 0;  // of the light, with the texture and with nothing hidden
  int count = 0;
  void add(double truth, double shown) {
    rmse += (shown - truth) * (shown - truth);
    without += (1 - truth) * (1 - truth);
    ++count;
  }
  void finish() {
    rmse = std::sqrt(rmse / count);
    without = std::sqrt(without / count);
  }
};
struct Errors {
  Error floor, seen, grains;
};

sandglass::PileShadow made(const std::vector<float>& sand, const Cells& cells) {
  sandglass::PileShadow shadow;
  EXPECT_TRUE(shadow.create(description()));
  EXPECT_TRUE(shadow.set_cells(cells));
  shadow.run(sand, k_grain);
  EXPECT_EQ(shadow.texture(k_floor).valid, 1u);
  return shadow;
}

// What the shader of the README gives a point of the sand.
double shaded(const sandglass::PileShadow& shadow, float floor, const std::array<float, 3>& point) {
  const sandglass_texture heights = shadow.texture(k_heights);
  const double surface = sampled(heights, point) * static_cast<double>(heights.scale);
  const double below = std::max((surface - static_cast<double>(point[1] - floor)) / static_cast<double>(k_grain), 0.0);
  return sampled(shadow.texture(k_upper), point) / (1 + 0.9 * below);
}

// The error where the room has light `truth` and the texture is made for light `drawn`.
Errors errors_of(const Sand& sand, const Cells& truth, const Cells& drawn) {
  const sandglass::PileShadow shadow = made(sand.spheres, drawn);
  Errors errors;
  for (const Receiver& r : sand.floor) {
    const double real = lit(r.truth.light, truth), shown = sampled(shadow.texture(k_floor), r.at);
    if (real < 0.999 || shown < 0.999) errors.floor.add(real, shown);
  }
  for (const Receiver& r : sand.seen) {
    const double open = lit(r.truth.open, truth);
    if (open > 0.05) errors.seen.add(lit(r.truth.light, truth) / open, shaded(shadow, 0, r.at));
  }
  std::vector<float> centres;
  for (const Receiver& r : sand.grains) centres.insert(centres.end(), r.at.begin(), r.at.end());
  std::vector<uint8_t> shown(sand.grains.size());
  shadow.light_grains(centres, k_grain, shown.data());
  for (size_t i = 0; i < shown.size(); ++i) errors.grains.add(lit(sand.grains[i].truth.light, truth), shown[i] / 255.0);
  errors.floor.finish();
  errors.seen.finish();
  errors.grains.finish();
  return errors;
}

void expect_half(const std::string& what, const Error& error) {
  ASSERT_GT(error.count, 50) << what;
  EXPECT_LT(error.rmse, 0.5 * error.without) << what;
  measured(what, "rmse", error.rmse);
  measured(what, "without", error.without);
}

// ---- truth

TEST(PileSky, IsHalfAsWrongAsLeavingItOutUnderAnEvenSky) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "millions of rays";
  for (const Sand& sand : {Sand("heap", heap()), Sand("poured sand", poured()), Sand("wall", wall()),
                           Sand("scattered grains", scattered())}) {
    const Errors errors = errors_of(sand, even_sky(), even_sky());
    expect_half(sand.name + ", floor", errors.floor);
    if (sand.name == "heap" || sand.name == "poured sand") expect_half(sand.name + ", the sand seen", errors.seen);
    if (sand.name == "heap" || sand.name == "wall") expect_half(sand.name + ", its grains", errors.grains);
    if (sand.name != "scattered grains") continue;
    EXPECT_LT(errors.grains.rmse, 0.02) << "their tops hide nothing from each other";
  }
}

// Light and shadow from a high cell are finer than grains, so on the sand only low cells are promised.
TEST(PileSky, IsHalfAsWrongAsLeavingItOutUnderOneBrightCell) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "millions of rays";
  for (const Sand& sand : {Sand("heap", heap()), Sand("wall", wall())})
    for (const uint32_t cell : {0u, 5u, 11u, 18u, 25u}) {
      const Errors errors = errors_of(sand, single_cell(cell), single_cell(cell));
      expect_half(sand.name + ", floor, cell " + std::to_string(cell), errors.floor);
      if (sand.name != "heap" || cell >= 16) continue;
      expect_half("heap, the sand seen, cell " + std::to_string(cell), errors.seen);
      expect_half("heap, its grains, cell " + std::to_string(cell), errors.grains);
    }
}

// Negative controls: the same light from another side.
TEST(PileSky, MirroredOrTurnedLightFails) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "millions of rays";
  const Sand sand("heap", heap());
  const Cells light = single_cell(5);
  const Cells mirrored = turned(light, [](uint32_t sector) { return 15 - sector; });
  const Cells quarter = turned(light, [](uint32_t sector) { return sector + 4; });
  for (const Cells& wrong : {mirrored, quarter}) {
    const Errors errors = errors_of(sand, light, wrong);
    EXPECT_GT(errors.floor.rmse, 0.8 * errors.floor.without);
    EXPECT_GT(errors.grains.rmse, 0.6 * errors.grains.without);
  }
}

// The formula that the header and the README's shader state.
TEST(PileSky, AShaderGivesGrainsTheSameLight) {
  sandglass_pile_shadow_desc desc = description();
  desc.floor = 0.3f;
  sandglass::PileShadow shadow;
  ASSERT_TRUE(shadow.create(desc));
  std::vector<float> sand = heap();
  for (size_t i = 1; i < sand.size(); i += 3) sand[i] += desc.floor;
  shadow.run(sand, k_grain);
  std::vector<uint8_t> light(sand.size() / 3);
  shadow.light_grains(sand, k_grain, light.data());
  for (size_t i = 0; i < light.size(); ++i)
    ASSERT_NEAR(light[i], 255 * shaded(shadow, desc.floor, {sand[3 * i], sand[3 * i + 1] + k_grain, sand[3 * i + 2]}),
                0.52)
        << i;
}

// ---- promises

TEST(PileSky, OneHashForAllKernelsAndAllDivisions) {
  const std::vector<float> sand = heap();
  uint64_t first = 0;
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_AVX512; ++isa) {
    if (sandglass_isa_available(isa) == 0) continue;
    for (const uint32_t units : {1u, 7u, 100000u}) {
      sandglass_pile_shadow_desc desc = description();
      desc.isa = isa;
      sandglass::PileShadow shadow;
      ASSERT_TRUE(shadow.create(desc));
      ASSERT_TRUE(shadow.set_light({0.5f, 0.7f, -0.3f}));
      while (shadow.run(sand, k_grain, units) != 0) {
      }
      const uint64_t hash = shadow.hash();
      if (first == 0) first = hash;
      EXPECT_EQ(hash, first) << sandglass_isa_name(isa) << ", " << units << " units at a time";
    }
  }
  EXPECT_EQ(first, 6673195605050295366ull) << "of shadow and sky, the same on every machine";
}

// Counts the units that asking for something takes.
TEST(PileSky, MakesOnlyWhatIsAskedFor) {
  const std::vector<float> sand = heap();
  sandglass::PileShadow shadow, without;
  ASSERT_TRUE(shadow.create(description()));
  ASSERT_TRUE(without.create(description(0)));
  EXPECT_EQ(without.run(sand, k_grain), 0u) << "no light and no cells: nothing to make";
  EXPECT_EQ(shadow.texture(k_floor).valid, 0u);
  const uint32_t of_sky = shadow.run(sand, k_grain);
  EXPECT_GT(of_sky, 0u) << "a room that nobody has seen has light, too";
  EXPECT_EQ(shadow.texture(k_floor).valid, 1u);
  EXPECT_EQ(shadow.texture().valid, 0u);
  EXPECT_EQ(shadow.run(sand, k_grain), 0u) << "nothing has changed";

  Cells cells = even_sky();
  cells[7] += 0.002f;
  cells[50] -= 0.002f;
  ASSERT_TRUE(shadow.set_cells(cells));
  EXPECT_EQ(shadow.run(sand, k_grain), 0u) << "a change below one step of a byte";
  cells[7] += 0.004f;
  cells[50] -= 0.004f;
  ASSERT_TRUE(shadow.set_cells(cells));
  EXPECT_EQ(shadow.run(sand, k_grain), of_sky) << "the cells ask for their texture only";

  const std::array<float, 3> light = {0.6f, 0.5f, 0.2f}, set = {1, -0.2f, 0};
  ASSERT_TRUE(without.set_light(light));
  ASSERT_TRUE(shadow.set_light(light));
  const uint32_t of_light = without.run(sand, k_grain);
  EXPECT_EQ(shadow.run(sand, k_grain), of_light) << "the light asks for its textures only";
  EXPECT_EQ(without.hash() == shadow.hash(), false) << "the hash covers the sky";
  EXPECT_EQ(std::memcmp(without.texture().bytes, shadow.texture().bytes, k_texels * k_texels), 0);

  shadow.refresh();
  EXPECT_GT(shadow.run(sand, k_grain), std::max(of_light, of_sky)) << "moved sand asks for all";
  ASSERT_TRUE(shadow.set_light(set));
  shadow.refresh();
  EXPECT_EQ(shadow.run(sand, k_grain), of_sky) << "below the horizon only the room's light is left";
}

TEST(PileSky, WithoutSandHidesNothing) {
  for (const uint32_t texels : {128u, 64u, 32u}) {
    sandglass::PileShadow shadow;
    ASSERT_TRUE(shadow.create(description(texels)));
    const std::vector<float> heap_of_sand = heap();
    shadow.run(heap_of_sand, k_grain);
    shadow.refresh();
    // Spheres that are not finite, far away or below the floor are left out.
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                wild[] = {nan, 0, 0, 1e30f, 0.1f, 0, 0, -5, 0, 0, 0.1f, nan};
    shadow.run({wild, 4}, k_grain);
    const uint8_t *floor = shadow.texture(k_floor).bytes, *upper = shadow.texture(k_upper).bytes;
    for (uint32_t i = 0; i < texels * texels; ++i) ASSERT_EQ(floor[i] & upper[i], 255) << i;
    for (uint32_t i = 0; i < k_texels * k_texels; ++i) ASSERT_EQ(shadow.texture(k_heights).bytes[i], 0) << i;
    uint8_t light[4];
    shadow.light_grains({wild, 4}, k_grain, light);
  }
}

TEST(PileSky, RefusesWithASentence) {
  const std::pair<uint32_t, uint32_t> wrong[] = {{128, 48}, {128, 256}, {32, 8}, {256, 256}};
  for (const auto& [texels, sky] : wrong) {
    sandglass_pile_shadow_desc desc = description(sky);
    desc.texels = texels;
    uint64_t bytes = 0;
    expect_refused("sky_texels", [&](const char** why) { return sandglass_pile_shadow_bytes(&desc, &bytes, why); });
  }
  sandglass::PileShadow shadow, without;
  ASSERT_TRUE(shadow.create(description()));
  ASSERT_TRUE(without.create(description(0)));
  const auto takes = [&](float first, float rest) {
    Cells cells;
    cells.fill(rest);
    cells[0] = first;
    return shadow.set_cells(cells).code == SANDGLASS_OK;
  };
  EXPECT_TRUE(takes(0, 0));
  EXPECT_TRUE(takes(1, 0));
  EXPECT_FALSE(takes(-0.01f, 0));
  EXPECT_FALSE(takes(NAN, 0));
  EXPECT_FALSE(takes(INFINITY, 0));
  EXPECT_FALSE(takes(0.5f, 0.01f)) << "more than 1 together";
  EXPECT_EQ(without.set_cells(even_sky()).code, SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(without.texture(k_floor).side, 0u);
  EXPECT_EQ(without.texture(k_floor).bytes, nullptr);
}

TEST(PileSky, StaysWithinItsBlock) {
  for (const uint32_t sky : {0u, 32u, 64u, 128u}) {
    const sandglass_pile_shadow_desc desc = description(sky);
    uint64_t bytes = 0;
    ASSERT_EQ(sandglass_pile_shadow_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
    sandglass::test::GuardedBlock block(bytes);
    sandglass_pile_shadow* handle = nullptr;
    ASSERT_EQ(sandglass_pile_shadow_create(&desc, block.data(), bytes, &handle, nullptr), SANDGLASS_OK);
    const float light[3] = {0.3f, 0.8f, 0};
    ASSERT_EQ(sandglass_pile_shadow_set_light(handle, light, 0, nullptr), SANDGLASS_OK);
    // Sand up to and beyond all edges.
    const std::vector<float> sand = grains_in([](const float* p) { return p[1] < 0.05f; });
    std::vector<float> wide;
    for (const float x : sand) wide.push_back(3 * x);
    sandglass_pile_shadow_run(handle, wide.data(), static_cast<uint32_t>(wide.size() / 3), 3 * k_grain, 1000000);
    EXPECT_TRUE(block.guards_intact());
  }
}

}  // namespace

// The ambient shadow through its C API: what a texture is, in which order textures come, how cells turn, and what is
// refused. The components are random; tests/shadow/ambient_truth_test.cpp tests baked ones against rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "runtime/asset/shadow_asset.h"
#include "runtime/math/hash.h"
#include "runtime/shadow/receiver/cells.h"
#include "sandglass/sandglass.hpp"
#include "tests/int8_kernels.h"
#include "tests/shadow/shadow_fixture.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

constexpr uint32_t k_cells_of_light = SANDGLASS_LIGHT_CELLS;
constexpr float k_sector = 6.28318531f / k_cell_sectors;  // radians
using Cells = std::array<float, k_cells_of_light>;

// The same on all instruction sets, compilers and machines: of cells that rise evenly, turned by 1 radian.
constexpr uint64_t k_golden = 0x6d0cb9242644581aull;

RandomShadow shape(uint32_t side = 128, uint32_t components = 23) {
  RandomShadow what = {32, 1, 2, 1, 4};
  what.version = 2;
  what.ambient_side = side;
  what.components = components;
  what.surface_vertices = 6;
  return what;
}

Cells rising() {
  Cells cells;
  for (uint32_t i = 0; i < k_cells_of_light; ++i)
    cells[i] = static_cast<float>(i) / (k_cells_of_light * (k_cells_of_light - 1) / 2);
  return cells;
}

Cells only(uint32_t cell, float share = 1) {
  Cells cells = {};
  cells[cell] = share;
  return cells;
}

struct Ambient : LiveShadow {
  explicit Ambient(const AssetFile& file, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC)
      : LiveShadow(describe(file, isa)) {}
  void cells(const Cells& q, float yaw = 0) {
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_shadow_set_cells(shadow, q.data(), yaw, &reason), SANDGLASS_OK) << reason;
  }
  sandglass_texture now() const {
    sandglass_texture ambient = {};
    ambient.struct_size = sizeof ambient;
    sandglass_shadow_get_ambient(shadow, &ambient);
    return ambient;
  }
  std::vector<uint8_t> texture() const {
    const sandglass_texture ambient = now();
    return {ambient.bytes, ambient.bytes + ambient.side * ambient.side};
  }
  std::vector<uint8_t> mixed(const Cells& q, float yaw = 0) {
    cells(q, yaw);
    finish();
    return texture();
  }
  uint32_t run(uint32_t units) { return sandglass_shadow_run(&shadow, 1, units); }
};

TEST(AmbientShadow, OneHashOnEveryInstructionSet) {
  const AssetFile file = make_shadow_file(shape());
  for (const sandglass_isa isa : golden_sets()) {
    Ambient shadow(file, isa);
    const std::vector<uint8_t> texture = shadow.mixed(rising(), 1);
    EXPECT_EQ(hash_bytes(texture.data(), texture.size()), k_golden) << isa;
    EXPECT_GT(std::set<uint8_t>(texture.begin(), texture.end()).size(), 100u);
    EXPECT_TRUE(shadow.block.guards_intact());
  }
}

// In double. A weight is rounded to a part of a step that all components together cannot make one of, so a texel is off
// by its own rounding and little more.
TEST(AmbientShadow, ATexelIsTheSumOfItsComponents) {
  for (const RandomShadow& what : {shape(), shape(48, 1), shape(16, 32)}) {
    const AssetFile file = make_shadow_file(what);
    ShadowAsset asset;
    ASSERT_EQ(open_shadow_asset(file.data(), file.bytes, &asset, nullptr), SANDGLASS_OK);
    Ambient shadow(file);
    const Cells q = rising();
    const std::vector<uint8_t> texture = shadow.mixed(q);
    const uint32_t size = what.ambient_side * what.ambient_side;
    double worst = 0;
    for (uint32_t t = 0; t < size; ++t) {
      double dark = 0;
      for (uint32_t k = 0; k < what.components; ++k)
        for (uint32_t i = 0; i < k_cells_of_light; ++i)
          dark += static_cast<double>(asset.ambient.mixing[k * k_cells_of_light + i]) * static_cast<double>(q[i]) *
                  asset.ambient.texels[k * size + t];
      worst = std::max(worst, std::fabs(texture[t] - 255 * (1 - std::clamp(dark, 0.0, 1.0))));
    }
    // Weights are counted in 2^-13 of a step or finer: the largest is 1 / 127, and 255 / 127 * 2^13 < 32767.
    EXPECT_LE(worst, 0.5 + 0.5 * what.components * 127 / std::pow(2.0, 13)) << what.ambient_side;
  }
}

TEST(AmbientShadow, OneUnitAFrameGivesTheSameTextureLater) {
  const AssetFile file = make_shadow_file(shape());
  Ambient whole(file), pieces(file);
  const std::vector<uint8_t> expected = whole.mixed(rising());
  pieces.finish();
  const std::vector<uint8_t> before = pieces.texture();
  ASSERT_NE(before, expected);
  pieces.cells(rising());
  uint32_t left = sandglass_shadow_units_left(pieces.shadow), units = 0;
  EXPECT_EQ(left, 4u);  // of 4096 texels
  for (; left > 0; ++units) {
    EXPECT_EQ(pieces.texture(), before);  // the old texture stays complete
    EXPECT_EQ(pieces.now().behind, 1u);
    EXPECT_EQ(pieces.now().version, 1u);
    ASSERT_EQ(pieces.run(1), 1u);
    ASSERT_EQ(sandglass_shadow_units_left(pieces.shadow), --left);
  }
  EXPECT_EQ(pieces.texture(), expected);
  EXPECT_EQ(pieces.now().behind, 0u);
  EXPECT_EQ(pieces.now().version, 2u);
  EXPECT_EQ(pieces.run(1), 0u);
}

TEST(AmbientShadow, StandsUnderTheObjectFromTheFirstUnitsOnInTheExpectedLight) {
  Ambient shadow(make_shadow_file(shape()));
  EXPECT_EQ(shadow.now().valid, 0u);
  const std::vector<uint8_t> empty = shadow.texture();
  EXPECT_EQ(std::count(empty.begin(), empty.end(), 255), 128 * 128);
  shadow.light(0.3f, 1, 0.2f);
  EXPECT_EQ(shadow.run(4), 4u);
  EXPECT_EQ(shadow.now().valid, 1u);  // before the first unit of the light's texture
  const std::vector<uint8_t> first = shadow.texture();
  Cells prior;
  for (uint32_t i = 0; i < k_cells_of_light; ++i) prior[i] = k_prior_ring_shares[i / k_cell_sectors];
  shadow.mixed(only(3));
  EXPECT_NE(shadow.texture(), first);
  EXPECT_EQ(shadow.mixed(prior), first);
}

// The app turns the light and changes the cells before every unit.
TEST(AmbientShadow, NeitherLightsNorCellsThatNeverRestStarveTheOther) {
  Ambient shadow(make_shadow_file(shape(64)));
  uint32_t of_lights = 0, of_cells = 0;
  std::vector<uint8_t> light = shadow.coverage(), ambient = shadow.texture();
  for (int frame = 0; frame < 3000; ++frame) {
    shadow.light(std::sin(0.02f * static_cast<float>(frame)), 1, 0.3f);
    shadow.cells(only(static_cast<uint32_t>(frame) % k_cells_of_light));
    ASSERT_EQ(shadow.run(1), 1u);
    if (shadow.coverage() != light) {
      ++of_lights;
      light = shadow.coverage();
    }
    if (shadow.texture() != ambient) {
      ++of_cells;
      ambient = shadow.texture();
    }
  }
  EXPECT_GT(of_lights, 10u);
  EXPECT_LE(of_cells, of_lights + 2);  // they take turns
  EXPECT_GE(of_cells + 2, of_lights);
}

TEST(AmbientShadow, AChangeThatNoTexelCanShowStartsNoTexture) {
  Ambient shadow(make_shadow_file(shape()));
  Cells q = only(5, 0.5f);
  q[9] = 0.4f;
  shadow.mixed(q);
  q[5] += 0.9f / 255;
  q[9] -= 0.9f / 255;
  shadow.cells(q);
  EXPECT_EQ(shadow.run(1), 0u);
  EXPECT_EQ(shadow.now().behind, 0u);
  q[6] += 0.2f / 255;  // the changes add up since the texture that is shown
  shadow.cells(q);
  EXPECT_EQ(shadow.run(1), 1u);
}

TEST(AmbientShadow, YawMovesCellsRoundAndKeepsTheirSum) {
  const AssetFile file = make_shadow_file(shape());
  Ambient shadow(file);
  // Turned by one sector, the object sees the light of sector 4 in sector 5.
  const std::vector<uint8_t> in_5 = shadow.mixed(only(16 + 5)), in_6 = shadow.mixed(only(16 + 6));
  EXPECT_EQ(shadow.mixed(only(16 + 4), k_sector), in_5);
  EXPECT_EQ(shadow.mixed(only(16 + 7), -k_sector), in_6);
  EXPECT_EQ(shadow.mixed(only(16 + 15), 6 * k_sector), in_5);
  EXPECT_EQ(shadow.mixed(only(16 + 4), k_sector + 100 * 6.28318531f - 100 * 6.28318531f), in_5);
  Cells between = {};
  between[16 + 5] = 0.75f;
  between[16 + 6] = 0.25f;
  const std::vector<uint8_t> mixed = shadow.mixed(between), turned = shadow.mixed(only(16 + 4), 1.25f * k_sector);
  for (size_t t = 0; t < mixed.size(); ++t) ASSERT_LE(std::abs(mixed[t] - turned[t]), 1) << t;
  double world[k_cells_of_light], object[k_cells_of_light];
  for (uint32_t i = 0; i < k_cells_of_light; ++i) world[i] = i * i;
  for (const double yaw : {0.0, 0.1, -3.0, 17.3, -1e6, 1e6}) {
    turn_cells(world, yaw, object);
    for (uint32_t ring = 0; ring < k_cell_rings; ++ring) {
      double before = 0, after = 0;
      for (uint32_t s = 0; s < k_cell_sectors; ++s) {
        before += world[ring * k_cell_sectors + s];
        after += object[ring * k_cell_sectors + s];
      }
      EXPECT_NEAR(after, before, 1e-9 * before) << yaw;
    }
  }
}

TEST(AmbientShadow, RefusesCellsThatAreNoSharesOfLight) {
  Ambient shadow(make_shadow_file(shape()));
  shadow.finish();
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto refused = [&](const Cells& q, float yaw, const char* part) {
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_shadow_set_cells(shadow.shadow, q.data(), yaw, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
    ASSERT_NE(reason, nullptr);
    EXPECT_NE(std::string(reason).find(part), std::string::npos) << reason;
  };
  refused(only(0, nan), 0, "not finite");
  refused(only(63, inf), 0, "not finite");
  refused(only(3, -1e-6f), 0, "negative");
  refused(only(3, 1.002f), 0, "more than 1");
  refused(only(3), nan, "yaw");
  refused(only(3), -inf, "yaw");
  refused(only(3), 1.1e6f, "yaw");
  EXPECT_EQ(shadow.run(1), 0u);  // nothing was taken over
  shadow.cells(only(3, 1.0009f));
  shadow.cells({});
}

TEST(AmbientShadow, AFileOfVersionOneHasNone) {
  RandomShadow old = shape();
  old.version = 1;
  Ambient shadow(make_shadow_file(old));
  const uint64_t hash = sandglass_shadow_hash(shadow.shadow);
  EXPECT_EQ(shadow.now().bytes, nullptr);
  EXPECT_EQ(shadow.now().side, 0u);
  EXPECT_EQ(shadow.now().valid, 0u);
  shadow.cells(only(3));
  EXPECT_EQ(sandglass_shadow_units_left(shadow.shadow), 0u);
  EXPECT_EQ(shadow.run(1), 0u);
  EXPECT_EQ(sandglass_shadow_hash(shadow.shadow), hash);
}

TEST(AmbientShadow, TheHashCoversIt) {
  const AssetFile file = make_shadow_file(shape());
  Ambient mixed_shadow(file), other(file);
  mixed_shadow.mixed(only(3));
  other.mixed(only(3));
  EXPECT_EQ(sandglass_shadow_hash(mixed_shadow.shadow), sandglass_shadow_hash(other.shadow));
  other.mixed(only(4));
  EXPECT_NE(sandglass_shadow_hash(mixed_shadow.shadow), sandglass_shadow_hash(other.shadow));
}

// The nearest point in double, by looking at all of them; among those at one place the one with the nearest normal.
TEST(ShadowSurface, GivesEachVertexTheCoefficientsOfTheNearestPoint) {
  RandomShadow what = shape();
  what.surface_vertices = 300;
  const AssetFile file = make_shadow_file(what);
  ShadowAsset asset;
  ASSERT_EQ(open_shadow_asset(file.data(), file.bytes, &asset, nullptr), SANDGLASS_OK);
  const SurfaceAsset& surface = asset.surface;
  std::vector<float> positions, normals;
  std::vector<uint32_t> expected;
  for (uint32_t i = 0; i < surface.vertices; ++i) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      positions.push_back(surface.low[axis] + surface.step * surface.positions[3 * i + axis]);
      normals.push_back(surface.normals[3 * i + axis]);
    }
    expected.push_back(i);
  }
  for (int far = 0; far < 500; ++far) {  // places anywhere, beyond the object too, without a normal
    double p[3], best = 1e300;
    uint32_t nearest = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double steps = -20000 + 200.0 * ((static_cast<uint32_t>(far) * 7919 + axis * 104729) % 1000);
      positions.push_back(
          static_cast<float>(static_cast<double>(surface.low[axis]) + steps * static_cast<double>(surface.step)));
      p[axis] = (static_cast<double>(positions.back()) - static_cast<double>(surface.low[axis])) /
                static_cast<double>(surface.step);
      normals.push_back(0);
    }
    for (uint32_t i = 0; i < surface.vertices; ++i) {
      const double d = std::hypot(p[0] - surface.positions[3 * i], p[1] - surface.positions[3 * i + 1],
                                  p[2] - surface.positions[3 * i + 2]);
      if (d < best) {
        best = d;
        nearest = i;
      }
    }
    expected.push_back(nearest);
  }
  const uint32_t count = static_cast<uint32_t>(expected.size());
  std::vector<float> transfer(9 * count + 1, 7.0f);
  ASSERT_EQ(sandglass_shadow_transfer(file.data(), file.bytes, positions.data(), normals.data(), count, transfer.data(),
                                      nullptr),
            SANDGLASS_OK);
  EXPECT_EQ(transfer[9 * count], 7.0f);
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = 0; j < 9; ++j)
      ASSERT_EQ(transfer[9 * i + j], surface.steps[j] * static_cast<float>(surface.transfer[9 * expected[i] + j])) << i;
}

TEST(ShadowSurface, RefusesNumbersThatAreNoPlacesAndFilesWithoutASurface) {
  const AssetFile file = make_shadow_file(shape()), old = make_shadow_file({32, 1, 2, 1, 4});
  float place[3] = {}, transfer[9];
  const char* reason = nullptr;
  EXPECT_EQ(sandglass_shadow_transfer(old.data(), old.bytes, place, nullptr, 1, transfer, &reason),
            SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(reason).find("bake it again"), std::string::npos);
  EXPECT_EQ(sandglass_shadow_transfer(file.data(), file.bytes, nullptr, nullptr, 0, nullptr, nullptr), SANDGLASS_OK);
  place[1] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(sandglass_shadow_transfer(file.data(), file.bytes, place, nullptr, 1, transfer, nullptr),
            SANDGLASS_ERROR_INVALID_ARGUMENT);
  const float good[3] = {};
  EXPECT_EQ(sandglass_shadow_transfer(file.data(), file.bytes, good, place, 1, transfer, nullptr),
            SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_shadow_transfer(file.data(), file.bytes, good, good, 1, transfer, nullptr), SANDGLASS_OK);
}

// The basis of sandglass_estimator_light.sh, written out from estimator.h.
double radiance(const float* sh, uint32_t colour, const double d[3]) {
  const double x = d[0], y = d[1], z = d[2];
  const double basis[9] = {0.28209479177387814,
                           0.48860251190291992 * y,
                           0.48860251190291992 * z,
                           0.48860251190291992 * x,
                           1.0925484305920792 * x * y,
                           1.0925484305920792 * y * z,
                           0.31539156525252005 * (3 * z * z - 1),
                           1.0925484305920792 * x * z,
                           0.54627421529603959 * (x * x - y * y)};
  double sum = 0;
  for (uint32_t j = 0; j < 9; ++j) sum += basis[j] * static_cast<double>(sh[3 * j + colour]);
  return sum;
}

TEST(Harmonics, TurnedAreTheRoomAsTheObjectSeesIt) {
  uint64_t state = 5;
  const auto next = [&] {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(static_cast<int64_t>(state) >> 11) * 0x1p-52;
  };
  for (int trial = 0; trial < 100; ++trial) {
    float sh[27], turned[27], q[4];
    for (float& x : sh) x = static_cast<float>(next());
    for (float& x : q) x = static_cast<float>(3 * next());
    ASSERT_EQ(sandglass_harmonics_turn(sh, q, turned, nullptr), SANDGLASS_OK);
    double d[3] = {next(), next(), next()};
    const double length = std::hypot(d[0], d[1], d[2]);
    for (double& x : d) x /= length;
    // q d q*, by the formula d + 2 w (v x d) + 2 v x (v x d) for a unit quaternion (v, w).
    double u[4], norm = 0;
    for (int i = 0; i < 4; ++i) norm += static_cast<double>(q[i]) * static_cast<double>(q[i]);
    for (int i = 0; i < 4; ++i) u[i] = static_cast<double>(q[i]) / std::sqrt(norm);
    const auto cross = [&](const double b[3], double out[3]) {
      for (int i = 0; i < 3; ++i) out[i] = u[(i + 1) % 3] * b[(i + 2) % 3] - u[(i + 2) % 3] * b[(i + 1) % 3];
    };
    double once[3], twice[3], world[3];
    cross(d, once);
    cross(once, twice);
    for (int i = 0; i < 3; ++i) world[i] = d[i] + 2 * u[3] * once[i] + 2 * twice[i];
    for (uint32_t colour = 0; colour < 3; ++colour)
      ASSERT_NEAR(radiance(turned, colour, d), radiance(sh, colour, world), 1e-5) << trial;
  }
  float sh[27] = {}, turned[27] = {1};
  const float zero[4] = {}, upright[4] = {0, 0, 0, 1};
  EXPECT_EQ(sandglass_harmonics_turn(sh, zero, turned, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  sh[5] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(sandglass_harmonics_turn(sh, upright, turned, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(turned[0], 1);
}

}  // namespace

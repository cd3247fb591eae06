// The shipped chair against ray tracing: the errors that its file states, the limits for bytes and for the adaptive
// grid, two lights together, and where the shadow lies.
#include <gtest/gtest.h>

#include <cmath>

#include "models/baking/network.h"
#include "models/baking/shadow_runner.h"
#include "models/baking/training_set.h"
#include "models/files/aligned_bytes.h"
#include "models/mesh/generated.h"
#include "runtime/asset/shadow_asset.h"

namespace {

using namespace sandglass;
using namespace sandglass::host;

constexpr uint32_t k_size = SANDGLASS_SHADOW_TEXELS;

struct Chair {
  std::string bytes = read_file(SANDGLASS_SHADOWS_DIR "/chair.shadow", "baked shadow");
  AlignedBytes aligned{file()};
  ShadowAsset asset = {};
  LightGeometry geometry;
  FloatNetwork network;
  std::unique_ptr<ShadowCaster> caster;

  Chair() {
    const char* reason = nullptr;
    EXPECT_EQ(open_shadow_asset(aligned.data(), bytes.size(), &asset, &reason), SANDGLASS_OK) << reason;
    geometry.object = stand_on_plane(make_chair(), "chair");
    geometry.plane = asset.plane;
    geometry.half_angle = 0.5 * asset.angular_diameter;
    geometry.polar_max = asset.polar_max;
    network = {{asset.width, asset.layers},
               {asset.float_parameters, asset.float_parameters + asset.float_parameter_count}};
    caster = std::make_unique<ShadowCaster>(geometry.object.mesh, geometry.half_angle, SampleCounts{}, 99);
  }
  std::span<const uint8_t> file() const { return {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}; }
};

// One texel in 8 x 8, a different one for every light.
std::vector<uint32_t> some_texels(uint32_t light) {
  std::vector<uint32_t> uv;
  for (uint32_t v = light % 8; v < k_size; v += 8)
    for (uint32_t u = light * 3 % 8; u < k_size; u += 8) uv.insert(uv.end(), {u, v});
  return uv;
}

TEST(ShippedChair, IsAsCloseToRayTracingAsItsFileSays) {
  const Chair chair;
  ShadowRunner full(chair.file(), "chair", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_FULL);
  ShadowRunner adaptive(chair.file(), "chair", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  constexpr uint32_t k_lights = 40;  // none of them trained on: a ring of another count has other directions
  double rmse[3] = {};
  const std::vector<Direction> lights = ring_directions(chair.geometry.polar_max, k_lights);
  for (uint32_t l = 0; l < k_lights; ++l) {
    const std::vector<uint32_t> uv = some_texels(l);
    const uint32_t count = static_cast<uint32_t>(uv.size() / 2);
    std::vector<float> truth(count), values(count);
    chair.caster->texels(chair.geometry.rectangle(lights[l]), lights[l], 1000 + l, k_size, k_size, uv.data(), count,
                         truth.data());
    evaluate_texels(chair.network, lights[l], k_size, uv.data(), count, values.data());
    const uint8_t* textures[2] = {full.texture(lights[l]).bytes, adaptive.texture(lights[l]).bytes};
    double squares[3] = {};
    for (uint32_t i = 0; i < count; ++i) {
      const size_t at = size_t{uv[2 * i + 1]} * k_size + uv[2 * i];
      const double t = static_cast<double>(truth[i]);
      squares[0] += std::pow(static_cast<double>(values[i]) - t, 2);
      for (int m = 0; m < 2; ++m) squares[1 + m] += std::pow(1 - textures[m][at] / 255.0 - t, 2);
    }
    for (int m = 0; m < 3; ++m) rmse[m] += std::sqrt(squares[m] / count) / k_lights;
  }
  EXPECT_LE(rmse[0], 0.02);
  EXPECT_NEAR(rmse[0], static_cast<double>(chair.asset.rmse_float), 0.002);
  EXPECT_NEAR(rmse[1], static_cast<double>(chair.asset.rmse_int8), 0.002);
  EXPECT_LE(rmse[1], rmse[0] + 0.003);  // bytes may add this much to the float network's error
  EXPECT_LE(rmse[2], rmse[1] + 0.002);
  std::printf("RMSE over %u lights: float %.4f, int8 %.4f, adaptive %.4f\n", k_lights, rmse[0], rmse[1], rmse[2]);
}

// A sun with twice the irradiance of the lamp. The truth is the irradiance that arrives from both, divided by the
// irradiance without the object, traced at points of the floor that are texel centres of neither texture.
TEST(ShippedChair, TwoLightsAddUpAsRayTracingSays) {
  const Chair chair;
  const Direction lights[2] = {{0.6, 0.7, -0.387}, {-0.5, 0.8, 0.331}};
  const double irradiance[2] = {2, 1};
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.asset = chair.aligned.data();
  desc.asset_bytes = chair.bytes.size();
  desc.light_count = 2;
  cpp::Shadow shadow;
  ASSERT_TRUE(shadow.create(desc));
  for (uint32_t l = 0; l < 2; ++l) {
    const std::array<float, 3> d = {static_cast<float>(lights[l][0]), static_cast<float>(lights[l][1]),
                                    static_cast<float>(lights[l][2])};
    ASSERT_TRUE(shadow.set_light(d, static_cast<float>(irradiance[l]), l));
  }
  shadow.run();
  constexpr uint32_t k_out = 96;
  std::vector<uint8_t> combined(k_out * k_out);
  float low[2], high[2];
  ASSERT_EQ(sandglass_shadow_combine(shadow.get(), combined.data(), k_out, low, high, nullptr), SANDGLASS_OK);

  const StandingObject& object = chair.geometry.object;
  const ShadowRectangle rectangle = {(static_cast<double>(low[0]) - object.origin[0]) / object.scale,
                                     (static_cast<double>(low[1]) - object.origin[2]) / object.scale,
                                     (static_cast<double>(high[0]) - object.origin[0]) / object.scale,
                                     (static_cast<double>(high[1]) - object.origin[2]) / object.scale};
  std::vector<float> traced[2];
  ThreadPool pool(1);
  for (uint32_t l = 0; l < 2; ++l) {
    const double length = std::hypot(lights[l][0], lights[l][1], lights[l][2]);
    const Direction unit = {lights[l][0] / length, lights[l][1] / length, lights[l][2] / length};
    traced[l] = chair.caster->texture(rectangle, unit, 2000 + l, k_out, pool);
  }
  double squares = 0, dark = 0;
  for (size_t i = 0; i < combined.size(); ++i) {
    // The light that arrives, divided by the light without the object.
    const double arrives =
        irradiance[0] * static_cast<double>(traced[0][i]) + irradiance[1] * static_cast<double>(traced[1][i]);
    const double truth = arrives / (irradiance[0] + irradiance[1]);
    squares += std::pow(1 - combined[i] / 255.0 - truth, 2);
    dark += 1 - truth;
  }
  EXPECT_LE(std::sqrt(squares / static_cast<double>(combined.size())), 0.02);
  EXPECT_GT(dark / static_cast<double>(combined.size()), 0.05);  // enough shadow for an error to show
}

// The floor is dark under every leg, and the shadow is on the side away from the light.
TEST(ShippedChair, ShadowIsAttachedAndOnTheRightSide) {
  const Chair chair;
  ShadowRunner runner(chair.file(), "chair", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  const double polar = 50 * k_pi / 180;
  for (const double azimuth : {0.0, 0.25, 0.5, 0.75}) {
    const double x = std::cos(2 * k_pi * azimuth), z = std::sin(2 * k_pi * azimuth);
    const sandglass_texture t = runner.texture({std::sin(polar) * x, std::cos(polar), std::sin(polar) * z});
    const auto at = [&](double px, double pz) {
      const double u = (px - static_cast<double>(t.corner[0])) / static_cast<double>(t.along[0]) * k_size;
      const double v = (pz - static_cast<double>(t.corner[2])) / static_cast<double>(t.across[2]) * k_size;
      const bool inside = u >= 0 && v >= 0 && u < k_size && v < k_size;
      return inside ? t.bytes[static_cast<size_t>(v) * k_size + static_cast<size_t>(u)] / 255.0 : 0.0;
    };
    for (const double leg_x : {-0.19, 0.19})
      for (const double leg_z : {-0.19, 0.19}) EXPECT_GT(at(leg_x, leg_z), 0.9) << azimuth;
    double towards = 0, away = 0;
    for (int i = 0; i < 40; ++i)
      for (int j = -10; j <= 10; ++j) {
        const double along = 0.3 + 0.02 * i, across = 0.02 * j;
        towards += at(along * x - across * z, along * z + across * x);
        away += at(-along * x - across * z, -along * z + across * x);
      }
    EXPECT_GT(away, 20 * (towards + 1)) << azimuth;
  }
}

}  // namespace

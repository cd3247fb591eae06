// The evaluation's renderer against closed forms on the empty floor, and the image errors against numbers computed by
// hand.
#include "models/rooms/probe_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/compositing/image_errors.h"
#include "models/mesh/generated.h"
#include "tests/lighting/made_panorama.h"

namespace sandglass::host {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr View k_view = {k_pi / 2.0, k_pi / 2.0};

// The lower left corner of the picture: floor, far from the object.
Vec3 floor_colour(const RadianceMap& image) {
  Vec3 sum;
  for (int y = 66; y < 72; ++y)
    for (int x = 0; x < 6; ++x) sum = sum + image.colour(x, y) * (1.0 / 36.0);
  return sum;
}

Mesh small_object() { return make_icosphere(0.5f, 2); }

TEST(ProbeScene, DirectionalLightOnTheFloor) {
  const ProbeScene scene(small_object());
  const Vec3 towards = normalised(Vec3{0.3, 0.8, -0.4});
  // The irradiance on a facing surface is pi, so the floor reflects reflectance * cosine. The mean cosine of the
  // light's cap is that of its axis times a factor that the definition of irradiance already contains.
  const double expected = ProbeScene::k_reflectance * towards.y;
  EXPECT_NEAR(floor_colour(scene.render(ProbeLight::directional(towards), k_view, 64)).x, expected, 0.02 * expected);
}

TEST(ProbeScene, AmbientLightOnTheFloorIsItsReflectance) {
  const ProbeScene scene(small_object());
  EXPECT_NEAR(floor_colour(scene.render(ProbeLight::ambient(), k_view, 64)).x, ProbeScene::k_reflectance,
              0.05 * ProbeScene::k_reflectance);
}

// A panorama that consists of the directional and the ambient light must give the same picture as those two.
TEST(ProbeScene, EnvironmentOfTheTwoLightsIsTheirSum) {
  const View view = choose_views(4)[1];
  const ViewRotation rotation(view);
  const Vec3 towards = normalised(Vec3{0.4, 0.7, 0.5});
  const double sine = std::sin(k_light_half_angle_deg * k_pi / 180.0), cosine = std::sqrt(1.0 - sine * sine);
  const RadianceMap map = tests::panorama_of(1024, [&](Vec3 d) {
    const double red = dot(rotation.to_panorama(d), towards) > cosine ? 0.3 + 2.0 / (sine * sine) : 0.3;
    return Vec3{red, 0.3, 0.3};
  });
  const ProbeScene scene(make_trefoil(0.1f, 0.018f, 100, 12));
  const RadianceMap truth = scene.render(ProbeLight::environment(map, rotation), view, 256);
  const RadianceMap ambient = scene.render(ProbeLight::ambient(), view, 256);
  const auto off_by = [&](const RadianceMap& lamp) {
    RadianceMap sum(ProbeScene::k_width, ProbeScene::k_height);
    for (int y = 0; y < sum.height; ++y)
      for (int x = 0; x < sum.width; ++x)
        sum.set(x, y, product({2, 0, 0}, lamp.colour(x, y)) + ambient.colour(x, y) * 0.3);
    return compare(truth, sum).relative;
  };
  EXPECT_LE(off_by(scene.render(ProbeLight::directional(towards), view, 256)), 0.05);  // noise of 256 paths
  // The control: a wrong light is beyond the same limit.
  EXPECT_GT(off_by(scene.render(ProbeLight::directional(normalised(Vec3{-0.4, 0.7, 0.5})), view, 64)), 0.1);
}

TEST(ProbeScene, ShadowFallsAwayFromTheLight) {
  const ProbeScene scene(small_object());
  // The light comes from the right of the picture. The camera looks along +z, so +x is on the left.
  const RadianceMap image = scene.render(ProbeLight::directional(normalised(Vec3{-1.0, 1.0, 0.0})), k_view, 16);
  const double floor = floor_colour(image).x;
  double left = 0.0, right = 0.0;
  for (int y = 0; y < ProbeScene::k_height; ++y)
    for (int x = 0; x < ProbeScene::k_width; ++x) {
      if (image.colour(x, y).x < 0.1 * floor) (x < ProbeScene::k_width / 2 ? left : right) += 1.0;
    }
  EXPECT_GT(left, 100.0);
  EXPECT_LT(right, 0.1 * left);
}

TEST(ImageErrors, ByHand) {
  RadianceMap truth(2, 1), picture(2, 1);
  truth.set(0, 0, {1, 0, 0}), truth.set(1, 0, {0, 2, 0});
  picture.set(0, 0, {0, 1, 0}), picture.set(1, 0, {0, 2, 0});
  const ImageErrors e = compare(truth, picture);
  EXPECT_NEAR(e.rmse, std::sqrt(2.0 / 6.0), 1e-12);
  EXPECT_NEAR(e.relative, std::sqrt(2.0 / 5.0), 1e-12);
  EXPECT_NEAR(e.scale_invariant, std::sqrt((5.0 - 4.0 * 4.0 / 5.0) / 6.0), 1e-12);
  EXPECT_NEAR(e.logarithmic, std::sqrt(2.0 * std::log(2.0) * std::log(2.0) / 6.0), 1e-12);
  EXPECT_NEAR(e.angle_deg, 45.0, 1e-12);
  EXPECT_EQ(compare(truth, truth).rmse, 0.0);
}

}  // namespace
}  // namespace sandglass::host

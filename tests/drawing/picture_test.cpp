// Pictures are the right way up. Shadows fall away from the sun and touch the thing that casts them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/drawing/render.h"
#include "models/files/image.h"
#include "models/tracing/sphere_caster.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {
namespace {

constexpr int k_width = 160, k_height = 120;

struct Stage {
  std::vector<float> ball = {0.0f, 0.1f, 0.0f};
  sandglass_collider floor = cpp::floor_at(0);
  SceneView view;
  Stage() {
    view.spheres = ball;
    view.radius = 0.1f;
    view.colliders = {&floor, 1};
    view.bounds.add({-0.2, 0.0, -0.2});
    view.bounds.add({0.2, 0.2, 0.2});
    view.camera.eye = {0.0, 0.5, 1.2};
    view.camera.target = {0.0, 0.1, 0.0};
  }
  Picture draw(bool coin = false) const {
    RenderOptions options;
    options.width = k_width;
    options.height = k_height;
    options.samples = 3;
    options.threads = 2;
    options.coin = coin;
    return render(view, options);
  }
  const uint8_t* pixel(const Picture& picture, Vec3 point) const {
    const PixelPlace at = project(view.camera, k_width, k_height, point);
    return picture.at(static_cast<int>(at.x), static_cast<int>(at.y));
  }
  // The mean of the three channels in the 3x3 pixels around a point of the world.
  double brightness(const Picture& picture, Vec3 point) const {
    const PixelPlace at = project(view.camera, k_width, k_height, point);
    double sum = 0.0;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const uint8_t* pixel = picture.at(static_cast<int>(at.x) + x, static_cast<int>(at.y) + y);
        sum += pixel[0] + pixel[1] + pixel[2];
      }
    return sum / 27.0;
  }
};

TEST(Render, IsNotUpsideDown) {
  const Stage stage;
  const PixelPlace top = project(stage.view.camera, k_width, k_height, {0.0, 0.2, 0.0});
  const PixelPlace foot = project(stage.view.camera, k_width, k_height, {0.0, 0.0, 0.0});
  const PixelPlace right = project(stage.view.camera, k_width, k_height, {0.1, 0.1, 0.0});
  EXPECT_LT(top.y, foot.y);
  EXPECT_GT(right.x, foot.x);
  // Sand is redder than the grey floor. So the ball is where it should be, lit from above.
  const Picture picture = stage.draw();
  const uint8_t* ball = stage.pixel(picture, {0.0, 0.1, 0.0});
  EXPECT_GT(ball[0], ball[2] + 30);
  EXPECT_GT(stage.brightness(picture, {-0.03, 0.18, 0.03}), stage.brightness(picture, {0.06, 0.03, 0.08}) + 20.0);
}

TEST(Render, TheShadowFallsAwayFromTheSunAndBeginsAtTheFoot) {
  Stage stage;
  const Picture picture = stage.draw();
  // The sun stands to the left and in front, so the shadow lies to the right and behind.
  const double shadow = stage.brightness(picture, {0.13, 0.0, -0.05}),
               lit = stage.brightness(picture, {-0.30, 0.0, 0.05});
  EXPECT_LT(shadow, 0.8 * lit);
  // No gap of light between the ball and its shadow.
  EXPECT_LT(stage.brightness(picture, {0.07, 0.0, 0.02}), 0.8 * lit);
  stage.view.spheres = {};
  EXPECT_GT(stage.brightness(stage.draw(), {0.13, 0.0, -0.05}), shadow + 15.0) << "without the ball there is none";
}

TEST(Render, RepeatsToTheByteOnAnyNumberOfThreads) {
  const Stage stage;
  RenderOptions one_thread, three_threads;
  one_thread.width = three_threads.width = 64;
  one_thread.height = three_threads.height = 48;
  one_thread.threads = 1;
  three_threads.threads = 3;
  EXPECT_EQ(render(stage.view, one_thread).rgb, render(stage.view, three_threads).rgb);
}

TEST(Render, DrawsEveryColliderWhereItIs) {
  for (const sandglass_shape shape : {SANDGLASS_SHAPE_SPHERE, SANDGLASS_SHAPE_CAPSULE, SANDGLASS_SHAPE_BOX}) {
    Stage stage;
    stage.view.spheres = {};
    sandglass_collider colliders[2] = {stage.floor, cpp::collider(shape, 0, 0.1f, 0)};
    colliders[1].size[0] = 0.1f;
    colliders[1].size[1] = 0.05f;
    colliders[1].size[2] = 0.1f;
    stage.view.colliders = colliders;
    const Picture picture = stage.draw();
    const uint8_t* pixel = stage.pixel(picture, {0.0, 0.1, 0.0});
    EXPECT_GT(pixel[2], pixel[0] + 20) << shape;  // colliders are blue
  }
}

TEST(Render, SurvivesNoSphereAndSpheresThatAreNotFinite) {
  Stage stage;
  stage.ball = {NAN, 0.0f, 0.0f, 0.0f, 0.1f, 0.0f, INFINITY, 0.0f, 0.0f};
  stage.view.spheres = stage.ball;
  EXPECT_EQ(stage.draw(true).rgb.size(), static_cast<size_t>(k_width * k_height * 3));
  stage.view.spheres = {};
  EXPECT_EQ(stage.draw(true).rgb.size(), static_cast<size_t>(k_width * k_height * 3));
}

TEST(SphereCaster, EachSphereHasItsSize) {
  const std::vector<float> two = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, -3.0f}, sizes = {0.5f, 2.0f};
  const SphereCaster caster(two, 0.5f, sizes);
  SphereHit hit;
  hit.distance = 100.0;
  ASSERT_TRUE(caster.closest({0.2, 0.0, 5.0}, {0.0, 0.0, -1.0}, &hit));
  EXPECT_EQ(hit.index, 0u);
  EXPECT_NEAR(hit.distance, 4.85, 1e-4);  // sqrt(0.25^2 - 0.2^2) = 0.15
  hit.distance = 100.0;
  ASSERT_TRUE(caster.closest({0.6, 0.0, 5.0}, {0.0, 0.0, -1.0}, &hit));
  EXPECT_EQ(hit.index, 1u);
  EXPECT_NEAR(hit.distance, 7.2, 1e-4);  // sqrt(1^2 - 0.6^2) = 0.8
  EXPECT_TRUE(caster.occluded({0.2, 0.0, 5.0}, {0.0, 0.0, -1.0}, 100.0));
  EXPECT_FALSE(caster.occluded({0.2, 0.0, 5.0}, {0.0, 0.0, -1.0}, 4.0));
  EXPECT_FALSE(caster.occluded({1.1, 0.0, 5.0}, {0.0, 0.0, -1.0}, 100.0));
}

TEST(AutomaticCamera, FramesEveryBox) {
  Bounds boxes[2];
  boxes[0].add({-0.1, 0.5, -0.1});
  boxes[0].add({0.1, 0.9, 0.1});
  boxes[1].add({-0.8, 0.0, -0.5});
  boxes[1].add({0.6, 0.1, 0.7});
  const Camera camera = automatic_camera(boxes, 4.0 / 3.0);
  double widest = 0.0;
  for (const Bounds& box : boxes)
    for (int corner = 0; corner < 8; ++corner) {
      const PixelPlace at = project(camera, 400, 300,
                                    {corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                     corner & 4 ? box.high.z : box.low.z});
      EXPECT_GT(at.depth, 0.0);
      EXPECT_TRUE(at.x >= 0.0 && at.x <= 400.0) << at.x;
      EXPECT_TRUE(at.y >= 0.0 && at.y <= 300.0) << at.y;
      widest = std::max({widest, std::fabs(at.x - 200.0) / 200.0, std::fabs(at.y - 150.0) / 150.0});
    }
  EXPECT_GT(widest, 0.7);
}

// The bytes are those of the curve of IEC 61966-2-1, rounded. Values within 1e-9 of a half are left out.
TEST(Picture, BytesOfSrgbAreTheRoundedCurve) {
  for (int i = -50; i <= 20'050; ++i) {
    const double linear = i / 20'000.0, v = std::clamp(linear, 0.0, 1.0);
    const double curve = 255.0 * (v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055);
    if (std::fabs(curve - std::floor(curve) - 0.5) < 1e-9) continue;
    ASSERT_EQ(srgb_byte(linear), std::lround(curve)) << linear;
  }
}

}  // namespace
}  // namespace sandglass::host

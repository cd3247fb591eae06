// The light that rays sample from a panorama, against a closed form.
#include "models/rooms/probe_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "runtime/math/random.h"
#include "tests/light/made_panorama.h"

namespace sandglass::host {
namespace {

// A lamp of 10 degrees and radiance 2 / sin^2 in an even light of 0.3: a surface that faces the lamp receives 2 pi of
// the one and 0.3 pi of the other.
TEST(ProbeLight, SamplesGiveTheIrradianceOfALampAndOfTheRest) {
  constexpr double k_pi = std::numbers::pi;
  constexpr int k_rays = 20000;
  const ViewRotation rotation(choose_views(4)[1]);
  const Vec3 towards = normalised(Vec3{0.4, 0.7, 0.5});
  const double sine = std::sin(10.0 * k_pi / 180.0), cosine = std::sqrt(1.0 - sine * sine);
  const RadianceMap map = tests::panorama_of(1024, [&](Vec3 d) {
    const double red = dot(rotation.to_panorama(d), towards) > cosine ? 0.3 + 2.0 / (sine * sine) : 0.3;
    return Vec3{red, 0.3, 0.3};
  });
  const ProbeLight light(map, rotation);
  const auto irradiance = [&](Vec3 normal) {
    Random random = random_stream(1, 2);
    Vec3 sum;
    for (int i = 0; i < k_rays; ++i) {
      const double a = random.uniform(), b = random.uniform();
      const ProbeLight::Sample s = light.sample(a, b);
      sum = sum + s.weight * (std::max(0.0, dot(s.direction, normal)) / k_rays);
    }
    return sum;
  };
  const Vec3 facing = irradiance(towards), away = irradiance(towards * -1.0);
  EXPECT_NEAR(facing.x, 2.3 * k_pi, 0.02 * 2.3 * k_pi);
  EXPECT_NEAR(facing.y, 0.3 * k_pi, 0.05 * 0.3 * k_pi);
  EXPECT_NEAR(away.x, 0.3 * k_pi, 0.1 * 0.3 * k_pi) << "the lamp must not shine on its back";
}

}  // namespace
}  // namespace sandglass::host

// A camera that turns in a panorama: its pose against the pictures, and the measure of wander against closed forms.
#include "tests/laboratory/light/turning_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models/rooms/panorama_file.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

constexpr double k_pi = std::numbers::pi;

// In a panorama that looks alike everywhere, the network's output is the same for every view. In the world that light
// turns with the camera, exactly as the pose does.
TEST(TurningCamera, InAnEvenPanoramaTheLightTurnsWithThePose) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "it takes minutes under emulation";
  const tests::TemporaryFolder folder;
  const std::string path = folder / "even.hdr";
  RadianceMap map(64, 32);
  for (float& value : map.rgb) value = 0.5f;
  write_hdr(path, map);
  const Turn turn = turn_camera(SANDGLASS_LIGHTS_DIR "/room.light", LitPanorama(path), 0.3);
  ASSERT_EQ(turn.latest.size(), 31u);
  const Vec3 first = turn.latest.front();
  for (size_t i = 0; i < turn.latest.size(); ++i) {
    const double yaw = static_cast<double>(i) * 3.0 * k_pi / 180.0;
    const Vec3 d = turn.latest[i];
    // The azimuth grows from x to z. The height above the horizon stays.
    EXPECT_NEAR(d.x, std::cos(yaw) * first.x - std::sin(yaw) * first.z, 1e-5) << i;
    EXPECT_NEAR(d.z, std::sin(yaw) * first.x + std::cos(yaw) * first.z, 1e-5) << i;
    EXPECT_NEAR(d.y, first.y, 1e-5) << i;
  }
}

TEST(TurningCamera, WanderIsTheRootMeanSquareAngle) {
  std::vector<Vec3> still(7, normalised(Vec3{1, 2, 3})), level, opposed = {{1, 0, 0}, {-1, 0, 0}};
  for (int i = -15; i <= 15; ++i) level.push_back({std::cos(i * 3 * k_pi / 180), 0.0, std::sin(i * 3 * k_pi / 180)});
  EXPECT_NEAR(wander_deg(still), 0.0, 1e-5);
  EXPECT_NEAR(wander_deg(level), 3.0 * std::sqrt(15.0 * 16.0 / 3.0), 1e-9);  // of k = -15..15
  EXPECT_EQ(wander_deg(opposed), 180.0);
}

}  // namespace
}  // namespace sandglass::host

#include "tests/laboratory/light/turning_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/lighting/room_light.h"

namespace sandglass::host {

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr uint64_t k_between_ns = 250'000'000;

}  // namespace

Turn turn_camera(const std::string& network, const LitPanorama& panorama, double phi) {
  RoomLight light(network, true);
  Turn turn;
  uint64_t time_ns = 0;
  for (int i = -k_standing_estimates; i * k_turn_step_deg <= k_turn_deg; ++i) {
    const double yaw = std::max(0, i) * k_turn_step_deg * k_pi / 180.0;
    const View view = {0.5 * k_pi, phi + yaw};
    const Picture picture = panorama.image(view);
    sandglass_camera_image image = camera_image_of(picture, k_excerpt_fov_deg);
    const double about_y = -view.phi - 0.5 * k_pi;  // at 0 the camera looks along -z
    image.orientation[0] = image.orientation[2] = 0.0f;
    image.orientation[1] = static_cast<float>(std::sin(0.5 * about_y));
    image.orientation[3] = static_cast<float>(std::cos(0.5 * about_y));
    image.timestamp_ns = time_ns += k_between_ns;
    const FollowedLight followed = light.follow(image);
    if (i < 0) continue;
    const auto vector = [](const float* v) { return Vec3{v[0], v[1], v[2]}; };
    turn.filtered.push_back(vector(followed.filtered.direction));
    turn.latest.push_back(vector(followed.latest.direction));
    const Vec3 first = turn.filtered.front();
    const double c = std::cos(yaw), s = std::sin(yaw);
    turn.fixed.push_back({c * first.x - s * first.z, first.y, s * first.x + c * first.z});
    if (i % k_label_steps == 0)
      turn.labels.push_back(ViewRotation(view).to_panorama(camera_to_rotated(panorama.cut(view).labels.direction)));
  }
  return turn;
}

double wander_deg(const std::vector<Vec3>& directions) {
  Vec3 mean;
  for (const Vec3 d : directions) mean = mean + d;
  if (!(length(mean) > 0.0)) return 180.0;
  mean = normalised(mean);
  double squares = 0.0;
  for (const Vec3 d : directions) squares += std::pow(std::acos(std::clamp(dot(mean, d), -1.0, 1.0)), 2);
  return std::sqrt(squares / static_cast<double>(directions.size())) * 180.0 / k_pi;
}

}  // namespace sandglass::host

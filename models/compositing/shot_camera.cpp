#include "models/compositing/shot_camera.h"

#include <cmath>
#include <numbers>

#include "models/files/failure.h"

namespace sandglass::host {

void ShotCamera::pose(sandglass_camera_image* image) const {
  // The columns of the pose of a camera that looks along its own -z with y up.
  float matrix[16] = {};
  const Vec3 axes[3] = {right, up, forward * -1.0};
  for (int i = 0; i < 3; ++i) to_floats(axes[i], matrix + 4 * i);
  matrix[15] = 1.0f;
  if (sandglass_camera_orientation(matrix, image->orientation) == 0)
    throw cannot("read", "camera", "its pose is no rotation", "Correct \"eye\" and \"target\"");
  to_floats(eye, image->position);
}

ShotCamera held_camera(const Camera& camera, const ShotTrack& track, double seconds, double share) {
  constexpr double k_degree = std::numbers::pi / 180.0;
  // Each axis sways by the sum of two slow waves. Their periods share no beat within a shot. The spectrum is about that
  // of a hand.
  const auto wave = [&](double slow, double quick, double phase) {
    return track.sway_deg * k_degree * (0.7 * std::sin(slow * seconds + phase) + 0.3 * std::sin(quick * seconds));
  };
  const double yaw = track.turn_deg * k_degree * (share - 0.5) + wave(1.7, 5.3, 0.4);
  const double pitch = 0.7 * wave(2.3, 6.1, 1.9), roll = 0.5 * wave(1.3, 4.7, 3.1);
  ShotCamera shot = resting_camera(camera);
  const Quaternion turn =
      multiply(rotation_by({0, yaw, 0}), multiply(rotation_by(shot.right * pitch), rotation_by(shot.forward * roll)));
  shot.right = rotate(turn, shot.right);
  shot.up = rotate(turn, shot.up);
  shot.forward = rotate(turn, shot.forward);
  return shot;
}

}  // namespace sandglass::host

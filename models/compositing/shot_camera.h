// The camera of a shot: a phone in a hand. It turns slowly and sways a little about all three axes. It does not move,
// because a panorama is what is seen from one place.
#pragma once

#include "models/geometry/camera.h"
#include "models/geometry/vec3.h"
#include "models/simulation/scene_file.h"
#include "sandglass/camera.h"

namespace sandglass::host {

struct ShotCamera : CameraFrame {
  // In the camera's axes of lighting: x right, y down, z forward.
  Vec3 to_camera(Vec3 d) const { return {dot(d, right), -dot(d, up), dot(d, forward)}; }
  Vec3 to_scene(Vec3 d) const { return right * d.x - up * d.y + forward * d.z; }
  // Into the image's orientation and position.
  void pose(sandglass_camera_image* image) const;
};

// The camera of the scene, at rest.
inline ShotCamera resting_camera(const Camera& camera) { return {frame_of(camera)}; }

// The camera at `seconds`, when `share` (0..1) of the run is over.
ShotCamera held_camera(const Camera& camera, const ShotTrack& track, double seconds, double share);

}  // namespace sandglass::host

// The runtime's light on a workstation: one whole estimate an image, through the library's own functions.
#pragma once

#include <cstdint>
#include <string>

#include "models/files/aligned_bytes.h"
#include "models/files/image.h"
#include "models/work/block.h"
#include "sandglass/light.h"

namespace sandglass::host {

// What an app has after an image: the light, and the last estimate before the filter.
struct FollowedLight {
  sandglass_light_estimate filtered, latest;
};

class RoomLight {
 public:
  // The network's file by its path; without `filter`, every estimate is taken whole. A Failure names the file.
  explicit RoomLight(const std::string& path, bool filter = false);

  // World frame: that of `orientation`, a level camera looking along -z where it is the identity.
  sandglass_light_estimate estimate(const sandglass_camera_image& image);
  // The next image of a camera that was here before; its timestamp and pose count.
  FollowedLight follow(const sandglass_camera_image& image);

 private:
  AlignedBytes file_;
  Block block_;
  sandglass_light* light_ = nullptr;
};

// The picture as a camera's image; its bytes stay the picture's. `diagonal_deg`: field of view across the diagonal.
sandglass_camera_image camera_image_of(const Picture& picture, double diagonal_deg);

// The estimate with its direction in the camera's frame (x right, y down, z forward) of an image without a pose.
sandglass_light_estimate in_camera_frame(sandglass_light_estimate estimate);

}  // namespace sandglass::host

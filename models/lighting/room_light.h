// The runtime's light on a workstation: a whole estimate for each image, by the library's own functions.
#pragma once

#include <cstdint>
#include <string>

#include "models/files/aligned_bytes.h"
#include "models/files/image.h"
#include "models/work/block.h"
#include "sandglass/estimator.h"

namespace sandglass::host {

// What an app has after an image: the light, and the last estimate before the filter.
struct FollowedLight {
  sandglass_estimator_light filtered, latest;
};

class RoomLight {
 public:
  // Opens the network's file. Without `filter` every estimate is taken whole. A Failure names the file.
  explicit RoomLight(const std::string& path, bool filter = false, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC);

  // The world's frame is that of `orientation`: with the identity, a level camera that looks along -z.
  sandglass_estimator_light estimate(const sandglass_camera_image& image);
  // The next image of the same camera; its timestamp and pose are used.
  FollowedLight follow(const sandglass_camera_image& image);
  // The light and the newest estimate, of the images so far.
  FollowedLight now() const;
  sandglass_estimator* handle() const { return light_; }

 private:
  AlignedBytes file_;
  Block block_;
  sandglass_estimator* light_ = nullptr;
};

// The picture as a camera's image, which refers to the picture's bytes. `diagonal_deg` is the field of view across the
// diagonal.
sandglass_camera_image camera_image_of(const Picture& picture, double diagonal_deg);

// The estimate of an image without a pose, with its direction in the camera's frame (x right, y down, z forward).
sandglass_estimator_light in_camera_frame(sandglass_estimator_light estimate);

}  // namespace sandglass::host

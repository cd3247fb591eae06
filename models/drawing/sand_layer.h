// Sand in a picture, drawn as a GPU draws it: triangles, points and lines, each covering some of a pixel's samples and shaded
// once a pixel. What else is in the picture is put together with it by depth, sample by sample.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "models/drawing/kit_shading.h"

namespace sandglass::host {

class SandLayer {
 public:
  struct Size {
    int width, height;
    int samples;  // a pixel and axis
  };
  struct Sample {
    float depth = std::numeric_limits<float>::infinity();  // metres along the camera's axis
    float radiance[3] = {};
  };

  // Equal arguments give equal bits on any number of threads.
  SandLayer(const SandShape& shape, const SandLight& light, const CameraFrame& camera, Size size, uint32_t threads,
            const KitChange& change = {});

  // Sample i lies in column i % samples and row i / samples of the pixel.
  const Sample& at(int x, int y, int i) const {
    const auto pixel = static_cast<size_t>(y) * static_cast<size_t>(size_.width) + static_cast<size_t>(x);
    return samples_[pixel * static_cast<size_t>(size_.samples * size_.samples) + static_cast<size_t>(i)];
  }

 private:
  struct Band;
  Size size_;
  std::vector<Sample> samples_;
};

}  // namespace sandglass::host

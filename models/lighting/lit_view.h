// A panorama that is ready for cutting, and a view of it as the data set and the evaluation use it: the camera's image,
// and the labels of the light at the place where an object would be put, in the camera's frame.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "models/files/image.h"
#include "models/files/npy.h"
#include "models/lighting/labels.h"
#include "models/rooms/excerpt.h"

namespace sandglass::host {

struct LitView {
  double radius;  // of the insertion point, in panorama radii
  LightLabels labels;
  Picture image;  // 256 x 192, tone mapped with the whole panorama's exposure, sRGB
};

class LitPanorama {
 public:
  // Reads the panorama, and the depth map NAME_depth.npy beside it if there is one.
  explicit LitPanorama(const std::string& path);
  LitView cut(View view) const;

 private:
  RadianceMap radiance_, mapped_;
  NpyArray depth_;
  double white_;
};

// "room_7" of "rooms/room_7.hdr".
std::string stem_of(const std::string& path);

uint64_t hash_of_name(const std::string& name, uint64_t seed);

// The eight views of the data set, a function of the panorama's name and the seed.
std::array<View, k_excerpts> views_of(const std::string& path, uint64_t seed);

}  // namespace sandglass::host

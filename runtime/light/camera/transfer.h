// What the stored values of an image mean: light, by the transfer function that the app names.
#pragma once

#include "runtime/light/camera/camera_image.h"

namespace sandglass {

// Linear light of an sRGB value; 1 is white.
double srgb_light(uint8_t value);

// Linear light of each stored value of R, G and B; 1 is the reference white, which HLG and PQ exceed. NULL for a curve.
const float* camera_light_table(const CameraImage& image);

// The same of one value, by that table.
float camera_light(const CameraImage& image, const float* table, uint8_t value);

// Stored values become the sRGB values of the same light, of at most 1.
void camera_to_srgb(const CameraImage& image, uint8_t* values, uint32_t count);

}  // namespace sandglass

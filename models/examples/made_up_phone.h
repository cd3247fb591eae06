// What the example's app has from its platform: its own files, a camera that looks at a room's floor, held by a hand
// that sways, and something that draws over its image. 480 x 360 pixels; the same on every machine but for libm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/light.h"
#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"

class MadeUpPhone {
 public:
  // A file of the app, in 8-byte words, as the library wants it aligned. It has no bytes where it cannot be read.
  struct Asset {
    std::vector<uint64_t> words;
    uint64_t bytes;
  };
  static Asset asset(const std::string& path);

  // The camera gives 30 images a second, the display shows 60: null every other time. Valid until the next call.
  const sandglass_camera_image* next_image();
  // Draws over the image, in linear values: first the shadow on the floor of an object that is turned about y by `turn`
  // radians, in each colour by the light's share of it; then the grains.
  void draw(const sandglass_light_estimate& light, const sandglass_shadow_texture& shadow, float turn,
            const std::vector<sandglass_grain>& grains, float particle_radius);
  bool save(const std::string& path) const;  // PPM

 private:
  void see();
  void darken_floor(const sandglass_light_estimate& light, const sandglass_shadow_texture& shadow, float turn);

  int frame_ = 0;
  float eye_[3] = {}, right_[3] = {}, up_[3] = {}, forward_[3] = {};
  std::vector<float> linear_, depth_;  // RGB, 0..1; metres along `forward`
  std::vector<uint8_t> pixels_;        // of the camera, sRGB
  sandglass_camera_image image_ = {};
};

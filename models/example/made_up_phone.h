// What the example's app has from its platform: a camera that looks at a room's floor, held by a hand that sways, and
// something that draws over its image. 480 x 360 pixels; the same on every machine but for libm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"

class MadeUpPhone {
 public:
  void next_image();
  // The shadow multiplied onto the floor in linear light, then the grains, lit from `to_light`.
  void draw(const sandglass_shadow_texture& shadow, const std::vector<sandglass_grain>& grains, float particle_radius,
            const float to_light[3]);
  bool save(const std::string& path) const;  // PPM

 private:
  int frame_ = 0;
  float eye_[3] = {}, right_[3] = {}, up_[3] = {}, forward_[3] = {};
  std::vector<float> linear_, depth_;  // RGB, 0..1; metres along `forward`
};

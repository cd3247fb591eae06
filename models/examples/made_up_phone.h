// What the example's app has from its platform: its own files, a camera that adapts and clips, held by a hand that
// looks at the floor, then around the room, then at the floor again; and something that draws over its image. 320 x 240
// pixels; the same on every machine but for libm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/light.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/room.h"
#include "sandglass/sandglass.h"
#include "sandglass/shadow.h"

// What the app draws with in a frame.
struct RoomDrawing {
  const sandglass_room_light& light;  // as it is shown now
  float chair_turn;                   // radians about +y; the chair stands at the world's origin
  sandglass_shadow_ambient chair_ambient;
  sandglass_shadow_texture chair_sharp;
  sandglass_pile_shadow_sky sand_sky;
  sandglass_pile_shadow_texture sand_sharp;
};

class MadeUpPhone {
 public:
  static constexpr int k_frames = 330;  // what the hand does takes so long

  // A file of the app, in 8-byte words, as the library wants it aligned. It has no bytes where it cannot be read.
  struct Asset {
    std::vector<uint64_t> words;
    uint64_t bytes;
  };
  static Asset asset(const std::string& path);
  static bool save(const std::string& path, const void* data, uint64_t bytes);

  MadeUpPhone();
  // The app's own mesh: points of the chair's surface, and the side that they face.
  std::vector<float> chair, chair_normals;
  std::vector<float> chair_transfer;  // nine for each, by sandglass_shadow_surface

  // The camera gives 30 images a second, the display shows 60: null every other time. Valid until the next call.
  const sandglass_camera_image* next_image();
  // The next images are taken with a sixty-fourth of the exposure, for a tenth of a second, because the room takes one
  // image in that time (sandglass_room_desc.interval). They are not shown.
  void expose_shortly() { short_images_ = 4; }
  // Draws over the image: floor, chair and sand in the light of the room, then, where the app asks its user to look
  // somewhere, an arrow to there.
  void draw(const RoomDrawing& drawing, const std::vector<sandglass_grain>& grains, float particle_radius);
  void draw_arrow(const float direction[3]);
  bool save_picture(const std::string& path) const;  // PPM

 private:
  void hold();
  void see();
  void darken_floor(const RoomDrawing& drawing);
  void draw_chair(const RoomDrawing& drawing);
  void draw_sand(const RoomDrawing& drawing, const std::vector<sandglass_grain>& grains, float particle_radius);
  void splat(const float* at, float size, const float* colour);

  int frame_ = 0;
  int short_images_ = 0;
  float exposure_ = 1.0f;
  float eye_[3] = {}, right_[3] = {}, up_[3] = {}, forward_[3] = {};
  std::vector<float> linear_, depth_;  // RGB as displayed, linear; metres along `forward`
  std::vector<uint8_t> pixels_;        // of the camera, sRGB
  sandglass_camera_image image_ = {};
};

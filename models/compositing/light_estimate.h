// What the library makes of a shot's light: the camera's images go into a room and a network, and one light comes out,
// in the picture's scale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "models/compositing/phone.h"
#include "models/compositing/shot_light.h"
#include "models/compositing/surroundings.h"
#include "models/files/shipped_file.h"
#include "models/lighting/room_light.h"
#include "models/work/block.h"
#include "sandglass/room.h"

namespace sandglass::host {

// One light by the network alone, from what the picture's camera sees.
class LightEstimate {
 public:
  LightEstimate(const std::string& file, sandglass_isa isa) : light_(file, true, isa) {}

  // What the camera sees of its surroundings, taken at a time; valid until the next call.
  const sandglass_camera_image* take(const Surroundings& room, const ShotCamera& camera, uint64_t time_ns);
  // Runs the estimate of the image taken last to its end.
  void finish() { light_.follow(taken_.image); }

  sandglass_estimator* handle() const { return light_.handle(); }
  sandglass_estimator_light now() const { return light_.now().filtered; }
  bool valid() const { return now().valid != 0; }
  ShotLight light() const { return scaled(one_light(now()), scale_); }

 private:
  RoomLight light_;
  PhoneImage taken_;
  double scale_ = 1.0;
};

// The light of the room as a session has seen it: a phone beside the picture's camera looks around, an image at a time,
// while the picture's camera stays with the object.
class SeenLight {
 public:
  // `standing`: where the object is. The room is as large as the surroundings say. `between_ns`: from image to image.
  SeenLight(const Surroundings& room, const ShotCamera& at_rest, Vec3 standing, std::vector<SessionImage> images,
            uint64_t between_ns);

  // Before anything is placed: the phone looks around once.
  void look_around(const Surroundings& room);
  // The phone's image at a time, for the frame that begins then; null between images. After the last one it turns again,
  // unless there was only one.
  const sandglass_camera_image* take(const Surroundings& room, uint64_t time_ns);
  // Moves *shown, from {} on, towards what is known now of the light where a thing stands now, and gives it in the
  // picture's scale. `estimate`: the network's, or null.
  ShotLight follow(Vec3 standing, double seconds, const sandglass_estimator_light* estimate,
                   sandglass_room_light* shown);

  // What is seen of the room from there, so high above the floor, in the picture's scale, as the library's cube has it now.
  Reflected reflected(Vec3 place, double height, const sandglass_room_light& shown) const;

  sandglass_room* handle() const { return room_; }

 private:
  Block block_;
  sandglass_room* room_ = nullptr;
  ShotCamera camera_;
  double azimuth_, exposure_;
  std::vector<SessionImage> images_;
  uint64_t between_ns_;
  size_t next_ = 0;
  uint64_t before_ns_ = 0;  // that looking around took
  PhoneImage image_;
};

// The shipped network, or empty where there is none.
inline std::string shipped_light_network() { return shipped_file("lights", "room.light"); }

}  // namespace sandglass::host

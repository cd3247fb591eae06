// A phone in a known world, as a day shows it: a camera that adapts its exposure, in any direction, through a room of
// the library with an app's own calls. No function of the library is used to project or to expose.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/geometry/vec3.h"
#include "sandglass/camera.h"
#include "sandglass/room.h"

namespace sandglass::host {

// Linear radiance, by direction and by where the camera stands.
using World = std::function<Vec3(Vec3 direction, Vec3 from)>;

struct Gaze {
  double azimuth_deg, elevation_deg;  // from +x to +z; above the horizon
};
Vec3 direction_of(Gaze gaze);

class DayPhone {
 public:
  // `speed`: the share of the way to the wanted exposure that each image goes. `known`: exposures are.
  // `radius`: as the app tells it; 0: it does not.
  DayPhone(double speed, bool known, double gain = 0.7, double radius = 0);

  // An image, a tenth of a second after the one before.
  void see(const World& world, Gaze gaze);
  // The same, then one of `short_exposure` where the library asks for it; and what is shown fades.
  void see_and_obey(const World& world, Gaze gaze);
  // The known light at the feet, or at `place`.
  sandglass_room_light light(Vec3 place = {}) const;
  sandglass_room_light shown = {};
  // Irradiance of the floor that is drawn over the last image, over that image's exposure: comparable with the world's.
  double level(Vec3 place = {}) const;
  // The same of the light that is shown.
  double shown_level() const;
  sandglass_room* handle() const { return room_; }

  Vec3 position = {};
  // White balance: a share of what would make an image grey, reached in a second; whether it is told; what it is now.
  double follows = 0;
  bool tells_gains = false;
  Vec3 gains = {1, 1, 1};
  int width = 96, height = 72;
  double focal = 75;
  void resolve(int wide, int high, double far) {
    width = wide;
    height = high;
    focal = far;
  }
  sandglass_transfer transfer = SANDGLASS_TRANSFER_SRGB;  // what its values mean, and whether it says so
  bool tells_transfer = true;
  uint32_t shorts = 0;  // images that the library has asked for

 private:
  DayPhone(const DayPhone&) = delete;
  DayPhone& operator=(const DayPhone&) = delete;
  double take(const World& world, Gaze gaze, double exposure);

  std::vector<uint64_t> block_;
  sandglass_room* room_ = nullptr;
  double speed_, gain_, last_gain_ = 1;
  bool known_;
  uint64_t now_ = 1;
  Vec3 seen_ = {};  // mean of the last image, without its balance
  sandglass_camera_image image_ = {};
  std::vector<uint8_t> bytes_;
};

// Of a level floor at `from`: from all that is above the horizon.
double floor_irradiance(const World& world, Vec3 from = {});

}  // namespace sandglass::host

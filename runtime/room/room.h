// The state behind the C API of sandglass/room.h: what the camera has seen, in parts of a sphere.
//
// The sphere is aligned with gravity and stands around the place where the first image was taken. Its parts are 16
// rows of elevation by 32 columns of azimuth, as in a map. What a part shows counts as lying on the sphere, `radius`
// away. So an image taken elsewhere, and an object that stands elsewhere, see the same part in another direction.
//
//   image.cpp     an image into parts, unit by unit
//   estimate.cpp  the light at a place
//   fade.cpp      from the light that is shown to the one that is known
//   save.cpp      to bytes and back
//   room.cpp      the C API, and the room's part in a frame
#pragma once

#include <cstdint>

#include "runtime/camera/camera_image.h"
#include "runtime/core/governor.h"
#include "runtime/core/light_cells.h"
#include "sandglass/room.h"

namespace sandglass {

constexpr uint32_t k_room_rows = 16, k_room_columns = 32, k_room_parts = k_room_rows * k_room_columns;
constexpr uint32_t k_room_unit_parts = 64;  // what a work unit looks at

// What was seen of one part of the sphere.
struct RoomPart {
  float radiance[3];  // the mean, linear; a lower bound where `clipped` is above 0
  float clipped;      // 0..1: the share of its pixels that were clipped
  float weight;       // how many images have shown it, as far as they still count
  float seen;         // 0..1: the share of it that was ever in the picture
  float stamp;        // when it was seen last, seconds since the first image
};

enum class RoomPhase : uint32_t {
  idle,
  overlap,  // how this image is exposed, from parts that were seen before
  gather    // the image into the parts
};

// The image under way, as the gathering needs it.
struct RoomView {
  CameraImage image;
  double to_camera[3][3];      // from the sphere's frame to the stored image's: x right, y down, z forward
  double position[3];          // of the camera, in the sphere's frame, in radii
  double most_cosine;          // parts farther from the optical axis than this are not in the picture
  double scale;                // radiance of a pixel of linear value 1
  double log_sum, log_weight;  // of the overlap: how much brighter memory is than the image
  double votes;                // of log_weight: what became darker less what became brighter
  bool renews;                 // the light has changed: the image is gathered once more, and believed
  float stamp;
};

struct Room {
  double radius, half_life;
  uint64_t interval_ns, last_ns;
  uint32_t images;
  bool exposure_known;  // by the app, since the first image
  double centre[3];     // of the sphere, in the world
  double yaw;           // turns: the sphere's azimuth 0 is at this azimuth of the world
  double scale;         // of the last image
  RoomPhase phase;
  uint32_t cursor;  // the next part
  RoomView view;
  RoomPart parts[k_room_parts];
};

// The directions of a part: `row` and `column` count from its first corner and may have fractions. Row 0 is below.
void room_direction(double row, double column, double direction[3]);
// A direction of the world in the sphere's frame.
void room_to_sphere(const Room& room, const double world[3], double sphere[3]);
// A place of the world in the sphere's frame, in radii.
void room_place(const Room& room, const double world[3], double sphere[3]);
// What counts of a part that was seen `age` seconds ago, 0..1.
double room_memory(const Room& room, const RoomPart& part);

void room_reset(Room* room);
// Takes an image that has passed sandglass_camera_check, if one is due. The image must stay until the units have run.
bool room_take_image(Room* room, const CameraImage& image);
uint32_t room_units_left(const Room& room);
void room_run_unit(Room* room);

// What is fitted: how the light that was not seen follows from what was. See estimate.cpp.
struct RoomModel {
  double boost;         // a part whose pixels are all clipped is 1 + boost times as bright as white
  double fill;          // brightness of an unseen part above the horizon, beside the geometric mean of what was seen
  double fill_below;    // the same below it
  double network;       // how much brighter the unseen is where the network says that light comes from
  double sharp;         // how much of what stands out is drawn as a sharp light
  double albedo;        // of the floor
  double floor_trust;   // how much the floor's own brightness counts for the level where nothing above was seen
  double unseen_level;  // logarithm of what unseen lamps add to the level
};
extern const RoomModel k_room_model;

void room_estimate(const Room& room, const RoomModel& model, const double position[3],
                   const sandglass_light_estimate* network, sandglass_room_light* light);

// Creation leaves this table in every room, and the scene calls through it. So the linker drops the room from an app
// that never creates one.
struct RoomFunctions {
  Stage (*begin_frame)(sandglass_room* room, const sandglass_camera_image* image, const char** refused);
  void (*end_frame)(sandglass_room* room);
};
extern const RoomFunctions k_room_functions;
constexpr uint32_t k_room_kinds = 1;

}  // namespace sandglass

struct sandglass_room {
  const sandglass::RoomFunctions* functions;
  sandglass::Room room;
};

// The state behind the C API of sandglass/room.h: what the camera has seen, in parts of a sphere.
//
// The sphere is aligned with gravity and stands around the place where the first image was taken. Its parts are 16
// rows of elevation by 32 columns of azimuth, as in a map. What a part shows counts as lying on the sphere, `radius`
// away. So an image taken elsewhere, and an object that stands elsewhere, see the same part in another direction.
//
//   sphere.cpp    where it stands and how large it is
//   image.cpp     an image into parts, by its exposure, unit by unit
//   search.cpp    small bright spots of an image
//   exposure.cpp  what an image says of its exposure and balance, and of the light of the whole room
//   lamp.cpp      how large a lamp is, of an image that shows it unclipped
//   texels.cpp    an image into the texels of a cube, for reflections, and the cube that is seen from a place
//   probe.cpp     a cube or harmonics of another system, into a layer below what the camera has seen
//   sums.cpp      what was seen, and what is to be expected elsewhere, summed up at a place
//   estimate.cpp  the light there
//   fade.cpp      from the light that is shown to the one that is known
//   save.cpp      to bytes and back
//   room.cpp      the C API, and the room's part in a frame
#pragma once

#include <cstdint>

#include "runtime/frame/capability.h"
#include "runtime/light/camera/camera_image.h"
#include "runtime/light/light_cells.h"
#include "runtime/math/math.h"
#include "sandglass/room.h"

namespace sandglass {

constexpr uint32_t k_room_rows = 16, k_room_columns = 32, k_room_parts = k_room_rows * k_room_columns;
constexpr uint32_t k_room_below = k_room_parts / 2;  // the parts below the horizon come first
constexpr uint32_t k_room_unit_parts = 64;           // what a work unit looks at

// A share, 0..1, in two bytes.
class RoomShare {
 public:
  RoomShare& operator=(double share) {
    steps_ = static_cast<uint16_t>(share * k_steps + 0.5);
    return *this;
  }
  operator double() const { return steps_ / k_steps; }

 private:
  static constexpr double k_steps = 65535;
  uint16_t steps_;
};

// What was seen of one part of the sphere.
struct RoomPart {
  // The mean, linear, divided by the room's `light`. A lower bound where `clipped` is above 0.
  float radiance[3];
  // How many images have shown the part, each as far as it still counts.
  float weight;
  // Shares: of its pixels that were clipped; of the part that was ever in the picture.
  RoomShare clipped;
  RoomShare seen;
  // Since it was seen last, in ticks: 2048 are a half-life.
  uint16_t age;
  // Where in the part its light comes from, along rows and along columns: +-127 at the edges.
  int8_t up, aside;
  // Where the camera stood that saw it last; 127 is a radius.
  int8_t from[3];
  // Luminance in the last image: 255 is white, and 16 less an octave less. 0: not known. k_shown_anew: by half or more
  // another radiance than in the image before, of exposures that are told.
  uint8_t shown;
};
constexpr uint8_t k_shown_anew = 1;

// What an image shows of one part.
struct RoomObservation {
  double colour[3];  // linear, 1 is white
  double clipped;    // share of the points
  double covered;    // share of the points that are in the picture
  double up, aside;  // of a lamp, where its light comes from, -1..1 from edge to edge; else 0
  double uneven;     // variance of the points' luminance, over the square of its mean
  double brightest;  // of a lamp, luminance of its brightest point; else the mean luminance
};

// How an image compares with what is remembered of the parts that it shows again. Every part counts with a weight: its
// solid angle, 1 for a part on the horizon. A ratio is the logarithm of shown over remembered luminance. Sums are
// weighted.
constexpr uint32_t k_vote_bins = 36;
// A histogram of ratios: of each bin the weight, and the sum of ratios.
struct RoomRatios {
  float weight[k_vote_bins], sum[k_vote_bins];
};
struct RoomVote {
  RoomRatios ratios;
  // Ratios to what the image before showed, where the exposure is not known.
  RoomRatios steps;
  // Parts that are clipped, or black, and were not expected to be: their weight, and the sum of the ratios that they
  // show at least.
  float brighter, darker;
  float brighter_sum, darker_sum;
  // Of the clipped ones, the weight in the bins of a histogram, and the weight of those that are clipped by half.
  float at_least[k_vote_bins];
  float white;
  // Weight of the parts that became brighter, or darker, by half or more.
  float more, less;
  // Parts of which the ratio is known exactly: their weight; sums of the logarithm of the remembered luminance and of
  // its square, of the ratio and of its square, and of the square of the logarithm of the shown luminance.
  float exact, known, known_squared, error, error_squared, shown_squared;
  // Sums of their colours: as the image shows them, and as they are remembered.
  float now[3], then[3];
  // All parts in the picture: their weight, the weight of the black ones, and the sum of luminance.
  float area, black, shown;
  // Weight of the parts that are compared by hue.
  float hues;
  // They count by how well they show it: the sum of that, and sums of how much redder and bluer they became, beside
  // green, as logarithms.
  float hue, red, blue;
};

// What an image may teach.
enum class RoomLesson : uint32_t {
  all,
  unknown,  // only parts that nobody remembers
  nothing
};

// What another system says of one part, as halves.
struct RoomProbePart {
  uint16_t radiance[3];  // linear, in the system's own unit; a lower bound where `clipped` is above 0
  uint16_t clipped;      // 0..1: the share of its texels that were clipped
};

// Finding parts that have given harmonics, under way (probe.cpp).
struct RoomHarmonics {
  double sh[3][9], mean;  // of each channel; mean radiance
  // Newton's method.
  double target[9], exponents[9], cost;
};

// The main light that is given beside harmonics. It is far: from everywhere it lies in the same direction.
struct RoomFarLight {
  // In the sphere's frame, and as a place on it in rows and columns.
  double direction[3], row, column;
  double irradiance[3];  // of a surface that faces it; 0: there is none
};

enum class RoomProbePhase : uint32_t { idle, cube, entropy, harmonics };

struct Room;
struct RoomProbe {
  double confidence;                  // 0..1; 0: there is none
  double scale;                       // radiance of value 1; 0: unknown
  double dark;                        // values below this are too dark to find the scale by
  double place[3];                    // where it was taken, world
  RoomProbePart parts[k_room_parts];  // without the far light
  RoomFarLight far;
  // Under way.
  RoomProbePhase phase;
  // Set by the function that begins a probe, so that the linker drops it from an app that never calls that.
  void (*run)(Room* room);
  uint32_t cursor, points;
  double confidence_then;
  sandglass_cube cube;
  RoomHarmonics harmonics;
};

// What was seen of one texel of a cube around the sphere, in its frame.
constexpr uint32_t k_cube_size = SANDGLASS_ROOM_CUBE_SIZE, k_cube_texels = 6 * k_cube_size * k_cube_size;
constexpr uint32_t k_cube_unit_texels = 4 * k_cube_size;  // what a work unit looks at
struct RoomTexel {
  float radiance[3];  // as of a part
  // As of a part: `clipped` in 255ths, `weight` in 16ths of an image.
  uint8_t clipped, weight;
  uint16_t age;  // as of a part
};

// A lamp whose size was measured.
constexpr uint32_t k_room_lamps = 3;
struct RoomLamp {
  int16_t at[3];        // on the sphere; k_lamp_unit is a radius
  uint8_t images;       // that the size is the mean of; 0: there is no lamp here
  uint8_t clipped;      // 1: it was clipped in all of them
  float across, error;  // radii: its width, and how far that may be off
  float strength;       // its irradiance, to compare it with other lamps; fades
};
constexpr double k_lamp_unit = 32767;

enum class RoomPhase : uint32_t {
  idle,
  compare,  // the image with what is remembered
  gather,   // the image into the parts
  texels    // and into the texels, where there are any
};

// A small spot of an image that is clipped, in a part that is not known to hold a lamp: where it lies, as in RoomPart.
constexpr uint32_t k_room_spots = 6;
struct RoomSpot {
  uint16_t part;
  int8_t up, aside;
};

// The image under way, as the gathering needs it.
struct RoomView {
  CameraImage image;
  double to_camera[3][3];  // from the sphere's frame to the stored image's: x right, y down, z forward
  double position[3];      // of the camera, in the sphere's frame, in radii
  // The picture's four sides, as planes through the camera: a normal that points into it, and what a place has along it
  // at least of which a part of the sphere may be in the picture.
  double sides[4][4];
  double scale;        // radiance of a pixel of linear value 1
  float balance[3];    // of each channel: what a pixel shows, over what it would show at a white balance of 1
  const float* light;  // camera_light_table
  double step;         // seconds since the image before
  bool shows_steps;    // RoomPart::shown is of the image before
  // Nearly all parts changed alike since the image before, as they should by what is remembered.
  bool steps_agree;
  RoomLesson lesson;
  RoomVote vote;
  RoomSpot spots[k_room_spots];
  uint32_t spot_count;
};

struct Room {
  double given_radius;  // 0: the app gave none, and `radius` is found
  double radius, half_life;
  uint64_t interval_ns;
  // Of the last image that was taken, and of the last that was offered.
  uint64_t last_ns;
  uint64_t offered_ns;
  uint64_t rest_ns;  // of the time that ages parts: less than a tick
  uint32_t hasty;    // images in a row that came less than a millisecond after the one before
  uint32_t images;
  uint32_t unit;        // number of the unit of radiance: another one where the unit was set anew
  bool exposure_known;  // the app has given an exposure for one image at least
  // The last image shows a whole lamp, but clipped, whose size is not known.
  bool wants_size : 1;
  // The last image seems to show another room.
  bool strange : 1;
  // What is seen lies so far away that `radius` has become k_far times as large.
  bool far : 1;
  // RoomPart::shown and shown_scale are of the last image.
  bool shows_steps : 1;
  uint8_t size_looks;  // short images that were to show the size of a lamp
  uint8_t grown;       // how often `radius` grew because the camera has left the sphere
  double centre[3];    // of the sphere, in the world
  double yaw;          // turns: the sphere's azimuth 0 is at this azimuth of the world
  double scale;        // of the last image that was exposed for the room
  double shown_scale;  // of the last image
  // White balance of the last image, beside that of all radiance that is kept.
  float balance[3];
  // The gains that the camera reports where `balance` is 1. 0: unknown.
  float gains[3];
  // The light of the whole room, over what it was when its parts were seen: a factor of them all.
  double light;
  // The median of votes while nothing changes. It is not 0, because votes are not taken of all that is remembered.
  double usual;
  double light_before;  // `light` before its last change
  double settled;       // seconds since the light has changed
  double doubted;       // seconds for which images have shown what no change of light explains
  double doubts;        // the median of votes of the last of these images
  double shows;         // mean radiance of those that look like another room; 0: none does
  // How much better images so far are explained if what they show is far: see compare_as_far.
  double farther;
  // The logarithm by which `scale` last grew, where the exposure is not known.
  float brightens;
  // Share of an image's white. A part that shows less, and showed less before, says nothing.
  float tells_from;
  RoomPhase phase;
  uint32_t cursor;  // the next part
  // Parts of this image and of the last one that may hold a lamp.
  uint32_t crowd, crowd_before;
  RoomView view;
  RoomPart parts[k_room_parts];
  // Of each part above the horizon: the white of the image by which its radiance is known, in quarters of an octave. An
  // image of a lower white that is clipped there says less. 0: unknown.
  uint8_t white[k_room_below];
  RoomLamp lamps[k_room_lamps];
  RoomProbe* probe;   // NULL in a room that keeps none
  RoomTexel* texels;  // k_cube_texels, or NULL
};

// The direction of a place on the sphere: `row` and `column` may have fractions. Row 0 is below.
void room_direction(double row, double column, double direction[3]);
// The place of a direction, row 0..16 and column 0..32. Returns the part that lies there.
uint32_t room_part_at(const double direction[3], double* row, double* column);
// A direction of the world in the sphere's frame.
void room_to_sphere(const Room& room, const double world[3], double sphere[3]);
void room_to_world(const Room& room, const double sphere[3], double world[3]);
// A place of the world in the sphere's frame, in radii. A place farther out than `farthest` is moved in to there.
constexpr double k_farthest = 0.8;
void room_place(const Room& room, const double world[3], double sphere[3], double farthest = k_farthest);
// Where a ray from the camera meets the sphere. `ahead`: of length 1. Returns how far that is.
double room_meet(const RoomView& view, const double ahead[3], double at[3]);
float room_bounded_radiance(double radiance);
// Whether the camera reports its white balance, and did before.
inline bool room_knows_gains(const Room& room, const CameraImage& image) {
  return image.gains[1] > 0 && room.gains[1] > 0;
}
// Whether a part is remembered well, and unclipped.
bool room_remembers(const RoomPart& part);
// How much something counts that was seen so many ticks ago, 0..1.
double room_memory(uint32_t age);
// The sphere grows by this factor when the camera leaves it; and by that one where what is seen is far.
constexpr double k_grows = 4, k_far = 64;
constexpr double k_usual_radius = 3;  // metres, where the app gives none
constexpr double k_radius_max = 1000;
constexpr double k_parallax = 0.1;  // radii: two views from places nearer to each other do not tell how far a thing is
// Before an image: makes the sphere as large as it has to be.
void room_fit_sphere(Room* room, const CameraImage& image);
inline double room_fraction(double x) { return x - static_cast<double>(floor_index(x)); }
// Moves `known`, of which 127 is 1, towards `now` by the share `rate`.
inline int8_t room_towards(int8_t known, double now, float rate) {
  const int64_t whole = floor_index(known + static_cast<double>(rate) * (127.0 * now - known) + 0.5);
  return static_cast<int8_t>(whole < -127 ? -127 : whole > 127 ? 127 : whole);
}
inline double room_first_radius(const Room& room) { return room.given_radius > 0 ? room.given_radius : k_usual_radius; }
// False: a direction of the sphere, and all within half a part of it, is out of the picture.
bool room_may_be_seen(const RoomView& view, const double direction[3]);
// A point in a part or a texel, 0..1: another one for each step, spread evenly.
void room_step(uint32_t step, double* down, double* across);
// The pixel that shows a direction of the sphere, or false.
bool room_pixel_of(const RoomView& view, const double direction[3], uint32_t* x, uint32_t* y);
// What is known of a part or a texel before an image. The fields are as in RoomPart and Room.
struct RoomKnown {
  double luminance;
  float clipped, weight;
  float seen;
  uint8_t white;
  bool anew;  // the image before showed it otherwise: this one may be a mistake
};
// Whether an image says nothing of a part, because it is exposed so short that it shows the part in a few steps of a
// byte, and would have before.
bool room_tells_nothing(const Room& room, const RoomKnown& known, const RoomObservation& now);
// Whether the image was exposed so much shorter than the last that it can only be meant for lamps.
bool room_is_short(const Room& room);
// Whether the image is a short one and dark but for lamps. Known once the image was compared.
bool room_shows_lamps_only(const Room& room);
// Radiance in quarters of an octave, 1..255.
uint8_t room_quarter_octaves(double radiance);
// How far what is known moves towards what an image shows, 0..1.
float room_rate(const Room& room, const RoomKnown& known, const RoomObservation& now);
// What an image shows of a unit's texels, into what is known of them.
void room_learn_texels(Room* room, uint32_t first);
// The weight of a part in a vote: its solid angle, 1 on the horizon.
double room_part_weight(uint32_t part);

// Compares one part of an image with what is remembered of it. `area`: what its vote weighs.
void room_vote(Room* room, uint32_t part, double area, const RoomObservation& now);
// Once all parts have voted: decides what the image teaches.
void room_decide(Room* room);

// Searches the share of an image that belongs to a work unit for small spots. The one in a part, or NULL.
void room_search(Room* room, uint32_t unit);
const RoomSpot* room_spot(const RoomView& view, uint32_t part);

// Measures the brightest lamp of an image that was learned, if the image shows it whole.
void room_measure_lamp(Room* room);
// The main light's size as it is seen from a place of the sphere's frame, in radii.
void room_main_size(const Room& room, const double at[3], sandglass_room_light* light);

void room_reset(Room* room);
// Forgets what was seen, around the camera of the image under way. The unit of radiance stays.
void room_leave(Room* room);
// Whether time stamps can be nanoseconds. Called for every image that is offered.
bool room_clock_is_sound(Room* room, uint64_t time_ns);
// Takes an image that has passed sandglass_camera_check, if one is due. The image must stay until the units have run.
bool room_take_image(Room* room, const CameraImage& image);
uint32_t room_units_left(const Room& room);
uint32_t room_texel_units_left(const Room& room);  // of these units
void room_run_unit(Room* room);

// Makes the room's probe of what another system knows of the light, unit by unit (probe.cpp). The texels must stay
// until the units have run. A probe that is dropped before leaves none.
void room_begin_cube(Room* room, const sandglass_cube& cube);
void room_begin_harmonics(Room* room, const sandglass_harmonics& harmonics);
// What a texel of a cube says: its light; that there is at least so much; that there is more than a cube can hold;
// nothing, because it is no number.
enum class RoomCubeTexel : uint32_t { sound, clipped, beyond, none };
// The texel that every graphics API samples for a direction, without filtering.
RoomCubeTexel room_cube_texel(const sandglass_cube& cube, const double direction[3], double colour[3]);
uint32_t room_probe_units_left(const Room& room);
void room_drop_probe_unit(Room* room);
// Radiance of the probe's value 1 in the room's unit, for each channel: found from parts that both show, or as given.
void room_probe_scale(const Room& room, double scale[3]);
// Returns the share of the probe's far light that lies in this part. `radiance`: what the whole part would have to send
// out to give all of that light, in the probe's unit.
double room_far_share(const RoomFarLight& far, uint32_t part, double radiance[3]);
// A part as camera and probe know it together, without the far light where the camera has not seen it. `seen`: how much
// the camera's view of it counts, 0..1.
RoomPart room_known(const Room& room, uint32_t part, const double scale[3], double seen);
// How the probe would fit best to what the camera has seen: after so many quarter turns about y, clockwise seen from
// above, and mirrored or not. False: they share too little to tell.
bool room_probe_fit(const Room& room, uint32_t* quarters, bool* mirrored);

// What is fitted: how the light that was not seen follows from what was. See sums.h and estimate.cpp.
struct RoomModel {
  double boost;         // a part whose pixels are all clipped is 1 + boost times as bright as white
  double fill;          // brightness of an unseen part above the horizon, over the geometric mean of what was seen
  double fill_below;    // the same below the horizon
  double network;       // how much brighter the unseen is where the network says that light comes from
  double sharp;         // how much of what stands out is drawn as a sharp light
  double albedo;        // of the floor
  double floor_trust;   // how much the floor's own brightness counts for the level where nothing above was seen
  double unseen_level;  // logarithm of what unseen lamps add to the level
};
extern const RoomModel k_room_model;

// The radiance that is to be expected from each part, where 1 is what the last image shows as white.
void room_radiance(const Room& room, const RoomModel& model, float parts[k_room_parts][3]);
// A face of the cube that is seen from a place, as halves.
void room_face(const Room& room, const RoomModel& model, const float position[3], float height, uint32_t face,
               bool left_handed, uint16_t* texels);
void room_estimate(const Room& room, const RoomModel& model, const sandglass_room_place& place,
                   sandglass_room_light* light);

extern const Capability k_room_capability;

}  // namespace sandglass

struct sandglass_room {
  sandglass::Member member;
  sandglass::Room room;
  uint64_t version;  // of the light that it reports
};

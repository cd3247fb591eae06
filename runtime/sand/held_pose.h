// The pose that sand meets in place of the one that the app gives. A tracker's pose is never twice the same: a floor
// that trembles by a tenth of a millimetre would shake a pile flat, and one that is corrected would throw it.
//
//   held      as long as the given surface, where sand is, stays within a band of the held one, nothing moves
//   follows   a pose that stays beyond the band for some frames, or moves on there, is followed all the way, never ahead
//             of it. The held velocity is that of the held pose's motion, so sand meets what it sees. Where the given
//             pose moves, it is followed to within the band, hardly faster than it goes; where it has jumped, gently.
//             It is held again once it has stood for a while
//   believed  where the app gives a velocity that keeps its direction, pose and velocity are taken as given
//
// What counts is the surface, not the numbers: a half-space may slide along itself, a ball may turn, and a box that grows
// keeps the faces that sand lies on. Lengths are metres.
#pragma once

#include "kernels/kernels.h"

namespace sandglass {

struct Pose {
  float position[3], rotation[4], size[3];
};

// Where a collider is: as the app gives it, or as it is held.
struct Placement {
  Pose pose;
  float linear[3], angular[3];  // velocities, m/s and rad/s
};

// State that is saved as it is.
struct HeldPose {
  Placement held;
  // The part of the held velocities that does not move the pose: a belt's.
  float slide[6];
  // As the app gave it in the last frame.
  Pose given;
  // While the held pose follows: where it was when it last moved on (k_stand_bands).
  Pose stand;
  // Velocity of the given pose by its last change, m/s and rad/s.
  float pose_velocity[6];
  // The speed that the surface has reached lately in two changes in a row, m/s.
  float speed;
  // The speed of the surface in the last change, m/s.
  float last_speed;
  // Frames from one given pose to the next, smoothed.
  float interval;
  // How far the given velocities have gone lately: a shift and an arc, metres.
  float run[6];
  // While the pose is believed: velocity that its changes show and the given velocities lack, m/s and rad/s.
  float missing_velocity[6];
  // Seconds since the given velocities turned back; without a given velocity; since one came after frames without.
  float since_turn, since_velocity, since_gap;
  float age;          // seconds since the given pose changed
  float stood;        // seconds near `stand`
  uint32_t moved;     // frames with a given velocity since there was none
  uint32_t same;      // frames since the given pose changed
  uint32_t beyond;    // frames in a row in which the given surface was beyond the band, or since it jumped
  uint32_t follows;   // 1: it follows
  uint32_t believed;  // 1: it was taken as given
};

// What the rule depends on besides the poses.
struct HoldRule {
  float band;             // metres; 0: every pose is taken as given
  float low[3], high[3];  // the box that holds the sand
  float leave_speed;      // m/s: at which sand leaves a collider that jumped
  float gentle;           // metres: what jumped further is there at once, else it goes there gently
  float longest;          // seconds; of a longer frame only so much is simulated
  // The first frame after a save was restored. Nobody knows how long ago the save was, so the pose's change since then
  // is no motion. Nor can the given pose be recognised as an outlier: it is followed at once.
  bool returns;
};

// A collider that was not known before is where the app gives it.
void hold_anew(HeldPose* pose, const Placement& given);
// A frame of `step` seconds, above 0. given.pose.rotation has length 1.
void hold(HeldPose* pose, sandglass_shape shape, const Placement& given, float step, const HoldRule& rule);

// When the scene is moved: p becomes rotation * p + shift.
void pose_move(Pose* pose, const float rotation[4], const float shift[3]);
void hold_move(HeldPose* pose, const float rotation[4], const float shift[3]);

// How far the surface of `to` is from that of `from`, at most, where sand is.
float surface_distance(sandglass_shape shape, const Pose& from, const Pose& to, const HoldRule& rule);

// The same of a box as if it had grown: only of faces that sand is in front of.
float box_surface_distance(const Pose& from, const Pose& to, const HoldRule& rule);

bool same_pose(const Pose& a, const Pose& b);
// The same turn up to the sign and the noise of a quaternion.
bool same_turn(const float a[4], const float b[4]);

}  // namespace sandglass

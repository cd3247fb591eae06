// The pose that sand meets in place of the one that the app gives. A tracker's pose is never twice the same: a floor
// that trembles by a tenth of a millimetre would shake a heap flat, and one that is corrected would throw it.
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
  float slide[6];          // the part of the held velocities that does not move the pose: a belt's
  Pose given;              // in the last frame
  Pose stand;              // while it follows: where it stands if it stands
  float pose_velocity[6];  // of the given pose's last motion, m/s and rad/s
  float speed;             // m/s: at which its surface went on lately, in two motions in a row
  float last_speed;        // m/s: of the last motion
  float interval;          // frames from one given pose to the next
  float run[6];            // how far given velocities have gone lately: shift and arc
  float missing_velocity
      [6];               // while it is believed: what the pose's own motion has beside given velocities, m/s and rad/s
  float since_turn;      // seconds since they turned back
  float since_velocity;  // seconds without one
  float since_gap;       // seconds since one came after frames without
  float age;             // seconds since the given pose changed
  float stood;           // seconds near `stand`
  uint32_t moved;        // frames with a velocity since there was none
  uint32_t same;         // frames since the given pose changed
  uint32_t beyond;       // frames in a row in which the given surface was beyond the band, or since it jumped
  uint32_t follows;      // 1: it follows
  uint32_t believed;     // 1: it was taken as given
};

// What the rule depends on besides the poses.
struct HoldRule {
  float band;             // 0: every pose is taken as given
  float low[3], high[3];  // the box that holds the sand
  float leave_speed;      // m/s: at which sand leaves a collider that jumped
  float gentle;           // what jumped no further goes there gently, else it is there at once
  float longest;          // seconds; of a longer frame only so much is simulated
  // The first frame after a save was restored. How long ago that was nobody knows: the difference from there is no
  // motion. Nor whether the given pose is an outlier, because none came before: it is followed at once.
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

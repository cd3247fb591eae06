#include "runtime/sand/held_pose.h"

#include "runtime/sand/pose_surface.h"

namespace sandglass {

namespace {

// Frames in a row; fewer are outliers. At 1 mm of noise a pose in fifty is beyond a band of 3 mm.
constexpr uint32_t k_beyond_frames = 3;
// A pose that follows closes its distance in about this time.
constexpr float k_follow_seconds = 0.25f;
// What stays so near to one place for so long stands. A lift of 0.7 mm/s does not.
constexpr float k_stand_seconds = 1.5f, k_stand_bands = 1.0f / 3.0f;
// Given velocities are remembered for about this time.
constexpr float k_remembered_seconds = 0.25f;
// Noise runs in one direction for so many frames once in sixty times.
constexpr uint32_t k_moved_frames = 4;
// What shakes within the band never runs further in one direction, in bands.
constexpr float k_run_bands = 2.0f;
// A pose that is taken as given from now on catches up in about this time, and is there when it is this near, in
// metres.
constexpr float k_catch_up_seconds = 0.05f, k_caught_up = 1e-4f;
// A time step of less is no clock's: a pose that moved in it has a speed all the same, and a scene that can be saved.
constexpr float k_shortest_seconds = 1e-4f;
// A tracker may be slower than the frames: a pose that is as old as this has stopped.
constexpr float k_still_seconds = 0.1f;
// Metres a second; what is slower does not move.
constexpr float k_slowest = 1e-4f;
// What a given velocity lacks of the pose's displacement, in shares of it. Of a hand that turns or brakes it is less.
constexpr float k_missing_share = 0.25f;
// What a given velocity lacks is smoothed over about this time.
constexpr float k_smooth_seconds = 0.1f;
// Seconds in which a collider may gain the speed at which sand leaves it.
constexpr float k_leave_frame = 1.0f / 60.0f;
// m/s^2: a hand that shakes a jar by 5 cm at 4 Hz reaches 32. What needs more is a jump.
constexpr float k_hand_acceleration = 50.0f;
// A jump that is so many times as long as one that goes gently has no given velocity: an app that cuts a late frame's
// time step gives the whole displacement in it.
constexpr float k_leap = 4.0f;
// What goes on errs by no more than this share of its displacement, if its velocity stays.
constexpr float k_moves_on_share = 0.75f;
// While it is waited for, a pose goes on as it did for no longer than this in a frame: how it did was noise, perhaps.
constexpr float k_goes_on_seconds = 0.05f;
// Frames: no tracker is waited for longer.
constexpr float k_slowest_interval = 12.0f;
// A given speed is remembered for about this time, and what is behind may go by this share faster.
constexpr float k_speed_seconds = 0.25f, k_catch_up_share = 0.25f;

// A held box takes over those faces of the given one that no sand is in front of, and its sizes.
void take_free_faces(HeldPose* p, const HoldRule& rule) {
  const Pose given = p->given, held = p->held.pose;
  float low[3], high[3];
  near_box(SANDGLASS_SHAPE_BOX, held, rule, low, high);
  for (int axis = 0; axis < 3; ++axis) {
    const Face up = face_of(held, axis, 1.0f), down = face_of(held, axis, -1.0f);
    const bool above = sand_beyond(up, face_of(given, axis, 1.0f), low, high);
    const bool below = sand_beyond(down, face_of(given, axis, -1.0f), low, high);
    if (above && below) continue;
    const float half = given.size[axis];
    const float middle = above ? up.offset - half : below ? half - down.offset : dot(given.position, up.n);
    const float shift = middle - dot(held.position, up.n);
    Pose& to = p->held.pose;
    to.size[axis] = half;
    to.position[0] += shift * up.n.x;
    to.position[1] += shift * up.n.y;
    to.position[2] += shift * up.n.z;
  }
}

// A velocity of a collider's own motion, in which the poses' noise is smoothed: what makes less than the band in this
// frame. It gains only so much: a single jump is no motion. Of a turn a point at `lever` counts.
void gain(float velocity[3], const float displacement[3], float seconds, float lever, const HoldRule& rule) {
  constexpr float k_negligible = 1e-9f;  // m/s or rad/s
  float next[3], lacks[3], along = 0.0f;
  for (int k = 0; k < 3; ++k) lacks[k] = displacement[k] / seconds - velocity[k];
  const float noise = rule.band / (seconds * lever),
              gain_max = rule.leave_speed / lever * minimum(seconds / k_leave_frame, 1.0f);
  const float share = maximum(seconds / (k_smooth_seconds + seconds), 1.0f - noise / (length3(lacks) + k_negligible));
  for (int k = 0; k < 3; ++k) next[k] = velocity[k] + share * lacks[k];
  const float speed = length3(next) + k_negligible;
  for (int k = 0; k < 3; ++k) along += velocity[k] * next[k] / speed;
  const float scale = minimum(1.0f, (maximum(along, 0.0f) + gain_max) / speed);
  for (int k = 0; k < 3; ++k) velocity[k] = scale * next[k];
}

// How far a surface goes by a shift and an arc: of a half-space what leads out of it, of a ball no arc.
float run_of_surface(sandglass_shape shape, const Pose& pose, const float run[6]) {
  const float *shift = run, *arc = run + 3;
  float length2 = dot3(shift, shift);
  const bool ball = shape == SANDGLASS_SHAPE_SPHERE;
  if (!ball) length2 += dot3(arc, arc);
  if (shape == SANDGLASS_SHAPE_HALF_SPACE) {
    const FloatVector n = rotated(pose.rotation, {0, 1, 0});
    const float out = dot(shift, n), about = dot(arc, n);
    length2 = out * out + maximum(dot3(arc, arc) - about * about, 0.0f);
  }
  return __builtin_sqrtf(length2);
}

// Whether the given velocities are motion: they have run further than what shakes within the band can, or kept their
// direction for a while.
bool believes(HeldPose* p, sandglass_shape shape, const Placement& given, bool jumped, float reach, float step,
              float band) {
  float displacement[6], length2 = 0.0f, with = 0.0f;
  for (int k = 0; k < 6; ++k) {
    displacement[k] = k < 3 ? given.linear[k] * step : given.angular[k - 3] * reach * step;
    length2 += displacement[k] * displacement[k];
    with += displacement[k] * p->run[k];
  }
  if (!(length2 >= k_slowest * k_slowest * step * step)) {
    p->since_velocity += step;
    if (p->since_velocity < k_still_seconds) return false;
    for (float& r : p->run) r = 0.0f;
    p->since_turn = k_remembered_seconds;
    p->moved = 0;
    return false;
  }
  // Between frames without one, differences of a tracker that is slower than the frames: they are too high.
  if (p->since_velocity > 0.0f && p->since_velocity < k_still_seconds) {
    p->since_gap = p->since_turn = 0.0f;
    for (float& r : p->run) r = 0.0f;
    p->moved = 0;
  }
  const bool outlier = jumped && p->since_velocity > 0.0f;  // or the second pose of a slow tracker
  p->since_velocity = 0.0f;
  if (p->moved < k_moved_frames) ++p->moved;
  const float remembered = with < 0.0f ? 0.0f : maximum(1.0f - step / k_remembered_seconds, 0.0f);
  p->since_turn = with < 0.0f ? 0.0f : minimum(p->since_turn + step, k_remembered_seconds);
  for (int k = 0; k < 6; ++k) p->run[k] = remembered * p->run[k] + displacement[k];
  const bool steady = p->since_turn >= k_remembered_seconds && p->moved == k_moved_frames;
  const bool ran = run_of_surface(shape, given.pose, p->run) > k_run_bands * band;
  return steady || (ran && !outlier && p->since_gap >= k_remembered_seconds);
}

void stop(HeldPose* p) {
  for (int k = 0; k < 3; ++k) p->held.linear[k] = p->held.angular[k] = 0.0f;
  for (float& s : p->slide) s = 0.0f;
}

void begin_following(HeldPose* p) {
  p->follows = 1;
  p->beyond = 0;
  p->stand = p->held.pose;
  p->stood = 0.0f;
}

// Adds to a given velocity what it lacks of the pose's motion: of a belt that is lifted, the lift. Of the velocity,
// so much is the pose's as goes along its displacement; of a belt that stays in place nothing: it slides.
void add_missing(float velocity[3], float missing[3], const float displacement[3], float step, float lever,
                 const HoldRule& rule) {
  float with = 0.0f, given_squared = 0.0f;
  for (int k = 0; k < 3; ++k) with += displacement[k] * velocity[k] * step;
  for (int k = 0; k < 3; ++k) given_squared += velocity[k] * velocity[k] * step * step;
  const float share = given_squared > 0.0f ? minimum(maximum(with / given_squared, 0.0f), 1.0f) : 0.0f;
  float rest[3];
  for (int k = 0; k < 3; ++k) rest[k] = displacement[k] - share * step * velocity[k];
  if (length3(rest) > k_missing_share * length3(displacement)) gain(missing, rest, step, lever, rule);
  else missing[0] = missing[1] = missing[2] = 0.0f;
  for (int k = 0; k < 3; ++k) velocity[k] += missing[k];
}

// The share of a given velocity that the pose does not go.
void find_slide(float slide[3], const float given[3], const float displacement[3]) {
  const float given_squared = dot3(given, given),
              share = given_squared > 0.0f ? 1.0f - dot3(given, displacement) / given_squared : 0.0f;
  for (int k = 0; k < 3; ++k) slide[k] = share > k_missing_share ? minimum(share, 1.0f) * given[k] : 0.0f;
}

// Pose and velocities as given. What was not believed before has been left behind, and catches up smoothly.
void take(HeldPose* p, sandglass_shape shape, const Placement& given, const Pose& was_given, bool jumped, float reach,
          float step, const HoldRule& rule) {
  const Placement before = p->held;
  p->held.pose = given.pose;
  if (jumped && surface_distance(shape, was_given, given.pose, rule) > k_leap * rule.gentle) return;
  p->held = given;
  float shift[3], arc[3];
  motion_between(was_given, given.pose, shift, arc);
  // A pose that has not changed may be a slow tracker's.
  if (p->same == 0 || p->age >= k_still_seconds) {
    find_slide(p->slide, given.linear, p->pose_velocity);
    find_slide(p->slide + 3, given.angular, p->pose_velocity + 3);
  }
  if (rule.band <= 0.0f) {
    const bool alone = dot3(given.linear, given.linear) + dot3(given.angular, given.angular) == 0.0f;
    for (int k = 0; alone && k < 3; ++k) p->held.linear[k] = shift[k] / step;
    for (int k = 0; alone && k < 3; ++k) p->held.angular[k] = arc[k] / step;
    return;
  }
  for (int k = 0; k < 3 && p->believed == 0; ++k) {  // it followed until now
    p->missing_velocity[k] = before.linear[k] - given.linear[k];
    p->missing_velocity[k + 3] = before.angular[k] - given.angular[k];
  }
  add_missing(p->held.linear, p->missing_velocity, shift, step, 1.0f, rule);
  add_missing(p->held.angular, p->missing_velocity + 3, arc, step, maximum(reach, 1e-6f), rule);
  // As far from the given pose as it was in the last frame, but of one that had jumped no further than what goes
  // gently.
  const float lag = surface_distance(shape, before.pose, was_given, rule), lag_max = rule.gentle + p->last_speed * step;
  if (lag <= k_caught_up) return;
  const Pose was_held = lag > lag_max ? between(was_given, before.pose, lag_max / lag) : before.pose;
  Pose behind = was_held;
  const float* w = was_given.rotation;
  const float back[4] = {-w[0], -w[1], -w[2], w[3]};
  float turn[4];
  multiply(given.pose.rotation, back, turn);
  multiply(turn, was_held.rotation, behind.rotation);
  for (int k = 0; k < 3; ++k) behind.position[k] += given.pose.position[k] - was_given.position[k];
  p->held.pose = between(behind, given.pose, step / (k_catch_up_seconds + step));
  motion_between(behind, p->held.pose, shift, arc);
  for (int k = 0; k < 3; ++k) p->held.linear[k] += shift[k] / step;
  for (int k = 0; k < 3; ++k) p->held.angular[k] += arc[k] / step;
}

// What the given pose does: how fast, and in which intervals.
struct Observation {
  bool jumped;  // faster than a hand gets
  bool starts;  // it moves on as it did before, faster than lately
};
Observation observe(HeldPose* p, sandglass_shape shape, const Pose& given, float step, const HoldRule& rule) {
  p->age = minimum(p->age + step, 1.0f);
  ++p->same;
  p->speed *= maximum(1.0f - step / k_speed_seconds, 0.0f);
  const bool stood = p->age >= k_still_seconds && p->same > 1;
  if (same_pose(given, p->given)) {
    for (int k = 0; stood && k < 6; ++k) p->pose_velocity[k] = p->last_speed = 0.0f;
    return {false, false};
  }
  const float frames = static_cast<float>(p->same);
  const float seconds = maximum(stood ? p->interval * step : p->age, k_shortest_seconds);
  if (!stood) p->interval = maximum(frames, 0.5f * (p->interval + frames));
  const float distance = surface_distance(shape, p->given, given, rule), speed = distance / seconds;
  const float error =
      surface_distance(shape, advanced(p->given, p->pose_velocity, p->pose_velocity + 3, seconds), given, rule);
  const float gains = k_hand_acceleration * seconds;
  const bool jumped = error > rule.band + gains * seconds && speed > p->speed + gains;
  const bool moves_on = error <= k_moves_on_share * distance;
  const bool starts = moves_on && speed > (1.0f + k_catch_up_share) * p->speed;
  if (!jumped) p->speed = maximum(p->speed, moves_on ? speed : minimum(speed, p->last_speed));
  if (!rule.returns) {
    p->last_speed = speed;
    motion_between(p->given, given, p->pose_velocity, p->pose_velocity + 3);
    for (float& v : p->pose_velocity) v /= seconds;
  }
  p->age = 0.0f;
  p->same = 0;
  return {jumped, starts};
}

// Where the held pose goes: a half-space into the given plane, and not along itself.
Pose aim_of(const HeldPose& p, sandglass_shape shape) {
  if (shape != SANDGLASS_SHAPE_HALF_SPACE) return p.given;
  return laid(p.held.pose, 1, 1.0f, face_of(p.given, 1, 1.0f));
}

// What has jumped further than goes gently, and than motion is behind, is there at once. Sand takes no part in what a
// table jumped along itself: one that has sand in front of one face alone.
void jump(HeldPose* p, sandglass_shape shape, float step, const HoldRule& rule) {
  Pose& held = p->held.pose;
  const Pose aim = aim_of(*p, shape);
  if (shape == SANDGLASS_SHAPE_BOX) {
    float low[3], high[3];
    near_box(shape, held, rule, low, high);
    int faces = 0, face = 0;
    for (int side = 0; side < 6; ++side) {
      const float up = side % 2 != 0 ? 1.0f : -1.0f;
      if (sand_beyond(face_of(held, side / 2, up), face_of(p->given, side / 2, up), low, high)) {
        ++faces;
        face = side;
      }
    }
    const float up = face % 2 != 0 ? 1.0f : -1.0f;
    if (faces == 1) held = laid(p->given, face / 2, up, face_of(held, face / 2, up));
  }
  if (surface_distance(shape, aim, held, rule) > rule.gentle + p->speed * (p->interval + 1.0f) * step) held = aim;
}

// A frame's motion: to within the band of the given pose, where that moves, hardly faster than it goes; else gently.
void follow(HeldPose* p, sandglass_shape shape, float step, const HoldRule& rule) {
  Pose& held = p->held.pose;
  const Pose aim = aim_of(*p, shape);
  if (shape == SANDGLASS_SHAPE_BOX && grown(held, aim) > 0.0f) take_free_faces(p, rule);
  const Pose before = held;
  const float lag = surface_distance(shape, aim, before, rule), gently = rule.leave_speed * step;
  float share = step / (k_follow_seconds + step);
  if (share * lag > gently) share = gently / lag;
  const Pose slow = between(before, aim, share);
  Pose next = before;
  if (lag > rule.band) next = between(aim, before, rule.band / lag);
  // Evenly until a slow tracker gives the next pose.
  next = between(before, next, 1.0f / maximum(p->interval - static_cast<float>(p->same), 1.0f));
  const float limit = (1.0f + k_catch_up_share) * p->speed * step;
  float distance = surface_distance(shape, before, next, rule);
  if (distance > limit) next = between(before, next, limit / distance);
  distance = minimum(limit, distance);
  if (surface_distance(shape, before, slow, rule) > distance) next = slow;
  motion_between(before, next, p->held.linear, p->held.angular);
  for (float& v : p->held.linear) v /= step;
  for (float& w : p->held.angular) w /= step;
  held = next;
  const bool moves = surface_distance(shape, p->stand, next, rule) > k_stand_bands * rule.band;
  if (moves) p->stand = next;
  p->stood = moves ? 0.0f : p->stood + step;
  if (p->stood < k_stand_seconds) return;
  p->follows = 0;
  stop(p);
}

// After a frame that is longer than what is simulated of it there is nothing to wait for: it is there, and has gone evenly
// along an arc. In what is simulated it goes straight on, by the arc's direction then: parts of one thing stay together.
void arrive(HeldPose* p, sandglass_shape shape, float step, const HoldRule& rule) {
  const Pose before = p->held.pose;
  begin_following(p);
  p->held.pose = aim_of(*p, shape);
  motion_between(before, p->held.pose, p->held.linear, p->held.angular);
  const float *w = p->held.angular, *v = p->held.linear, later = 0.5f * (1.0f - rule.longest / step);
  const FloatVector turned = cross(FloatVector{w[0], w[1], w[2]}, {v[0], v[1], v[2]});
  const float aside[3] = {turned.x, turned.y, turned.z};
  for (int k = 0; k < 3; ++k) p->held.linear[k] = (v[k] + later * aside[k]) / step;
  for (float& about : p->held.angular) about /= step;
}

// Whether a frame more beyond the band is not enough: an outlier of a slow tracker lasts until its next pose.
bool may_return(HeldPose* p, const Observation& observed) {
  const bool motion = ++p->beyond > 1 && observed.starts;
  const float frames = static_cast<float>(p->beyond);
  return (p->beyond < k_beyond_frames || frames <= minimum(p->interval, k_slowest_interval)) && !motion;
}

// Whether a pose that jumped is waited for. Meanwhile it goes on as it did. In a late frame nothing is waited for.
bool waits(HeldPose* p, sandglass_shape shape, const Observation& observed, float step, const HoldRule& rule) {
  if (p->beyond == 0 && !observed.jumped) return false;
  if (step <= rule.longest && may_return(p, observed)) {
    p->held.pose = advanced(p->held.pose, p->held.linear, p->held.angular, minimum(step, k_goes_on_seconds));
    return true;
  }
  p->beyond = 0;
  jump(p, shape, step, rule);
  return false;
}

}  // namespace

void hold_move(HeldPose* p, const float rotation[4], const float shift[3]) {
  Pose* const poses[] = {&p->held.pose, &p->given, &p->stand};
  for (Pose* pose : poses) pose_move(pose, rotation, shift);
  float* const vectors[] = {p->held.linear,      p->held.angular,        p->slide, p->slide + 3,
                            p->pose_velocity,    p->pose_velocity + 3,   p->run,   p->run + 3,
                            p->missing_velocity, p->missing_velocity + 3};
  for (float* v : vectors) {
    const FloatVector turned = rotated(rotation, {v[0], v[1], v[2]});
    v[0] = turned.x;
    v[1] = turned.y;
    v[2] = turned.z;
  }
}

void hold_anew(HeldPose* p, const Placement& given) {
  *p = {};
  p->held = given;
  p->given = p->stand = given.pose;
  p->interval = 1.0f;
  p->since_turn = p->since_gap = k_remembered_seconds;
  p->since_velocity = k_still_seconds;
  // What comes with a velocity is believed, until it turns back.
  for (int k = 0; k < 3; ++k)
    if (given.linear[k] != 0.0f || given.angular[k] != 0.0f) p->believed = 1;
  if (p->believed != 0) p->moved = k_moved_frames;
}

void hold(HeldPose* p, sandglass_shape shape, const Placement& now, float step, const HoldRule& rule) {
  Placement given = now;
  float with = 0.0f;
  for (int k = 0; k < 4; ++k) with += given.pose.rotation[k] * p->held.pose.rotation[k];
  for (float& c : given.pose.rotation) c = with < 0.0f ? -c : c;  // q and -q are one turn
  const Pose was_given = p->given;
  if (rule.returns) p->beyond = static_cast<uint32_t>(k_slowest_interval);
  const Observation observed = observe(p, shape, given.pose, step, rule);
  p->given = given.pose;
  p->since_gap = minimum(p->since_gap + step, k_remembered_seconds);
  const float reach = reach_of(shape, given.pose, rule);
  if (rule.band <= 0.0f || believes(p, shape, given, observed.jumped, reach, step, rule.band)) {
    take(p, shape, given, was_given, observed.jumped, reach, step, rule);
    p->believed = 1;
    begin_following(p);
    return;
  }
  if (p->believed != 0) stop(p);
  p->believed = 0;
  if (step > rule.longest && surface_distance(shape, p->held.pose, given.pose, rule) >= rule.band) {
    arrive(p, shape, step, rule);
    return;
  }
  if (p->follows != 0) {
    if (!waits(p, shape, observed, step, rule)) follow(p, shape, step, rule);
    return;
  }
  stop(p);
  if (same_pose(p->held.pose, given.pose) || surface_distance(shape, p->held.pose, given.pose, rule) < rule.band) {
    p->beyond = 0;
    if (shape == SANDGLASS_SHAPE_BOX && grown(p->held.pose, given.pose) > rule.band) take_free_faces(p, rule);
    return;
  }
  if (may_return(p, observed)) return;
  begin_following(p);
  jump(p, shape, step, rule);
  follow(p, shape, step, rule);
}

}  // namespace sandglass

// The state behind a sandglass_scene: the first region of the app's block. The regions of the sand follow it.
//
//   defaults.cpp         descriptions and inputs as an app starts from
//   create.cpp           check the description, lay out the block, begin and reset
//   material.cpp         what the app adds, removes, changes and moves between frames
//   box_body.cpp         a box as a rigid body
//   save.cpp             to bytes and back
//   frame.cpp            one frame: the stages, under the governor
//   report.cpp           what a frame did, as the app reads it
//   read.cpp             positions and poses by number
//   hash.cpp             the state as one number
//   names.cpp            the version, and names of statuses, instruction sets and quality levels
//   rotation_about.cpp   a rotation from axis and angle
#pragma once

#include "kernels/kernels.h"
#include "runtime/frame/governor.h"
#include "runtime/frame/layout.h"
#include "runtime/sand/granular.h"
#include "sandglass/sandglass.h"

namespace sandglass {
// What closes a frame, whatever the budget: sand goes with the colliders that hold it, the skin with its sand, then grains
// are written. Kinds of unit are those of the parts, at their places.
struct Closing {
  Stage parts[3];
};
}  // namespace sandglass

struct sandglass_scene {
  sandglass_scene_desc desc;
  sandglass::Layout layout;
  sandglass::Governor governor;
  sandglass::Granular granular;
  const sandglass::Kernels* kernels;
  uint64_t frame;
  // The version of the rigid bodies' poses, and the hash that they had then.
  uint64_t body_version, body_hash;
  uint32_t body_count;
  bool bodies_moved;           // in the last frame
  sandglass::Closing closing;  // of the frame under way
};

namespace sandglass {

inline constexpr char k_no_scene[] = "scene is NULL: pass the scene that sandglass_scene_create made.";

// Looks whether a body has moved.
void follow_bodies(sandglass_scene* scene);

// What a frame did. The governor has filled in its part.
void report_scene(const sandglass_scene& scene, sandglass_frame_report* report);

// Writes to the app's log what its developer should know of the last frame.
void log_frame(const sandglass_scene& scene);

}  // namespace sandglass

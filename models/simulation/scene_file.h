// A scene as a JSON file: what is filled with sand, what the sand falls on, how it is solved, how long it runs. An
// unknown key is refused by name. Every number must be finite and in range. models/README.md lists the keys;
// models/scenes holds the scenes that ship.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "models/geometry/camera.h"
#include "models/geometry/vec3.h"
#include "models/mesh/generated.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

enum class BodyShape { trefoil, mesh, box, sphere, lattice, revolved };

struct ProfileExtent {
  double reach = 0.0, bottom = 1e30, top = -1e30;
};
inline ProfileExtent extent_of(const Profile& profile) {
  ProfileExtent e;
  for (const auto& point : profile)
    e = {std::max(e.reach, point[0]), std::min(e.bottom, point[1]), std::max(e.top, point[1])};
  return e;
}

// Signed distance of a point from the solid that the outline makes when it turns about the y axis; above 0 outside.
double revolved_distance(const Profile& profile, Vec3 point);

struct Body {
  BodyShape shape = BodyShape::box;
  // Metres. All shapes but the box have only y, their height. It is 0 when the size follows from other fields.
  Vec3 size;
  uint32_t counts[3] = {0, 0, 0};
  double spacing = 2.02;  // in particle radii
  double jitter = 0.0;    // in particle radii
  uint32_t particles = 0, grains = 0;
  double grain_distance = 0.0;  // metres; 0: it follows from `grains`
  bool grain_grid = false;
  Vec3 position, velocity, spin;  // spin: rad/s, rigid bodies only
  Quaternion rotation = k_no_rotation;
  Profile profile;     // of a revolved body
  double rigid = 0.0;  // density relative to sand; 0: the body is sand
};

struct MotionSegment {
  double start = 0.0, end = 0.0;
  Vec3 linear_velocity, angular_velocity;
};

struct ColliderTrack {
  sandglass_shape shape = SANDGLASS_SHAPE_HALF_SPACE;
  Vec3 position, size;
  Quaternion rotation = k_no_rotation;
  std::vector<MotionSegment> motion;
  Profile profile;  // of a revolved collider; a mesh has none
  // Of a mesh: the name of the generated mesh that is used when --collider-mesh names no file. It may be empty.
  std::string mesh;
  std::string shadow;  // of a mesh: file or name of its baked shadow; empty: none
  bool casts = false;  // of a named mesh: its triangles cast, without a bake
  bool metal = false;  // of one that casts: in a shot it reflects the room
  bool solid_outside = false;
  double field_spacing = 0.0;              // metres; 0: the particle radius
  const sandglass_field* field = nullptr;  // set by CollisionFields
};

// A light that turns evenly over the run.
struct LightTrack {
  double polar_deg[2] = {45, 45}, azimuth_deg[2] = {0, 0};  // at the start and the end of the run
  Vec3 towards(double share) const;                         // after `share` (0..1) of the run
};

struct ShotTrack {
  double turn_deg = 0.0, sway_deg = 0.0, azimuth_deg = 90.0;
  std::string kept;   // the name of a captured room that ships; empty: a made-up one
  uint32_t room = 1;  // its seed
};

struct PileShadowTrack {
  double low[2] = {}, high[2] = {};  // x, z; metres
  uint32_t texels = 128;             // a side
};

struct EmitterTrack {
  sandglass_emitter emitter = {};
  double start = 0.0, end = 1e6;  // seconds
};

// The emitters and sinks of one frame.
struct Flow {
  std::vector<sandglass_emitter> emitters;
  std::vector<sandglass_collider> sinks;
};

struct SceneFile {
  std::string name, source;  // source: what error sentences call the file
  uint32_t frames = 100;
  double frame_step = 0.02, budget_ms = 4.0;
  double particle_radius = 0.0;  // metres; 0: it follows from a body
  float gravity[3] = {0.0f, -9.81f, 0.0f};
  uint64_t seed = 1;
  // The library's defaults, replaced by the file's values. A capacity that the file does not give is 0.
  sandglass_granular_desc granular = {};
  std::vector<Body> bodies;
  std::vector<ColliderTrack> colliders, sinks;
  std::vector<EmitterTrack> emitters;
  std::optional<LightTrack> light;
  std::optional<ShotTrack> shot;
  std::optional<PileShadowTrack> pile_shadow;
  std::optional<Camera> camera;
};

// Reads the text of a scene file. `source` is what error sentences call it.
SceneFile parse_scene(const std::string& text, const std::string& source);

// The path of a scene, from a file's path or from the name of a shipped scene. Shipped scenes are searched in the
// source tree and in the installed share folder.
std::string find_scene(const std::string& name_or_path);
SceneFile load_scene(const std::string& name_or_path);

// The collider during the frame that begins at `time`: its pose at the frame's end, its velocities at the frame's
// middle.
sandglass_collider collider_over_frame(const ColliderTrack& track, double time, double frame_step);

// The emitters that are on when the frame begins at `time`, and all sinks.
Flow flow_over_frame(const SceneFile& scene, double time);

// The radius at which grains are drawn. Together the grains have about three quarters of the particles' volume. The
// radius is never larger than a particle's.
float drawn_grain_radius(double particle_radius, uint32_t particles, uint32_t grains);

// The description of a scene that holds this many particles and grains. Throws a Failure when the file's own capacities
// are smaller, or the library refuses it.
sandglass_scene_desc describe_scene(const SceneFile& scene, uint32_t particles, uint32_t grains);
void expect_taken(const SceneFile& scene, const sandglass_scene_desc& desc);  // by the library

}  // namespace sandglass::host

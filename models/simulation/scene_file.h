// A scene as a JSON file: what is filled with sand, what it falls on, how it is solved, how long it runs. Every key is
// known or refused by name, every number is finite and in range. Numbers are read as double and used as float.
// models/README.md lists the keys; models/scenes holds the scenes that ship.
#pragma once

#include <array>
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

// Signed distance of a point from the turned outline, above 0 outside it.
double revolved_distance(const Profile& profile, Vec3 point);

struct Body {
  BodyShape shape = BodyShape::box;
  Vec3 size;  // metres; only y for trefoil, mesh and sphere; all 0 when it follows from `particles`
  uint32_t counts[3] = {0, 0, 0};
  double spacing = 2.02;  // radii
  double jitter = 0.0;    // radii
  uint32_t particles = 0, grains = 0;
  double grain_distance = 0.0;  // metres; 0: follows from `grains`
  bool grain_grid = false;
  Vec3 position, velocity, spin;  // spin: rad/s, rigid bodies only
  Quaternion rotation = k_no_rotation;
  Profile profile;     // of a revolved body
  double rigid = 0.0;  // density over that of sand; 0: sand
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
  Profile profile;     // of a revolved one; a mesh has none
  std::string mesh;    // of a mesh: the generated one that is taken where --collider-mesh names no file; may be empty
  std::string shadow;  // of a mesh: file or name of its baked shadow; empty: none
  bool solid_outside = false;
  double field_spacing = 0.0;              // 0: the particle radius
  const sandglass_field* field = nullptr;  // set by CollisionFields
};

// A light that turns evenly over the run.
struct LightTrack {
  double polar_deg[2] = {45, 45}, azimuth_deg[2] = {0, 0};  // at the run's start and end
  Vec3 towards(double share) const;                         // `share` of the run is over, 0..1
};

struct ShotTrack {
  double turn_deg = 0.0, sway_deg = 0.0, azimuth_deg = 90.0;
  uint32_t room = 1;
};

struct PileShadowTrack {
  double low[2] = {}, high[2] = {};  // x, z; metres
  uint32_t texels = 128;             // a side
};

struct EmitterTrack {
  sandglass_emitter emitter = {};
  double start = 0.0, end = 1e6;  // seconds
};

// What pours and what swallows during one frame.
struct Flow {
  std::vector<sandglass_emitter> emitters;
  std::vector<sandglass_collider> sinks;
};

struct SceneFile {
  std::string name, source;  // source: what error sentences call it
  uint32_t frames = 100;
  double frame_step = 0.02, budget_ms = 4.0;
  double particle_radius = 0.0;  // 0: follows from a body
  float gravity[3] = {0.0f, -9.81f, 0.0f};
  uint64_t seed = 1;
  // The library's defaults with the file's values over them; a capacity that the file does not give is 0.
  sandglass_granular_desc granular = {};
  std::vector<Body> bodies;
  std::vector<ColliderTrack> colliders, sinks;
  std::vector<EmitterTrack> emitters;
  std::optional<LightTrack> light;
  std::optional<ShotTrack> shot;
  std::optional<PileShadowTrack> pile_shadow;
  std::optional<Camera> camera;
};

// `source` names the text in error sentences.
SceneFile parse_scene(const std::string& text, const std::string& source);

// The path of a scene: the file itself, or a shipped scene's name. Looks beside the source tree and in the installed
// share folder.
std::string find_scene(const std::string& name_or_path);
SceneFile load_scene(const std::string& name_or_path);

// The collider over the frame that begins at `time`: its pose at the frame's end, its velocities at the frame's middle.
sandglass_collider collider_over_frame(const ColliderTrack& track, double time, double frame_step);

// What pours during the frame that begins at `time`, and all sinks.
Flow flow_over_frame(const SceneFile& scene, double time);

// Radius at which grains are drawn: together they have about the volume of the particles. Never larger than that of a
// particle.
float drawn_grain_radius(double particle_radius, uint32_t particles, uint32_t grains);

// The description of the scene that holds `particles` and `grains`; a Failure where the file's own capacities are
// smaller.
sandglass_scene_desc describe_scene(const SceneFile& scene, uint32_t particles, uint32_t grains);

}  // namespace sandglass::host

// A scene that runs by the wall clock and that a user can change: pour sand, push it with a sphere, turn the light,
// change the budget. The frame includes the library's shadows of objects and of the sand, but no room and no estimate
// of its light. This code knows nothing about windows.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/drawing/render.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

struct LiveOptions {
  std::string scene, mesh, collider_mesh, isa = "automatic";
  double budget_ms = -1.0;  // below 0: the budget of the scene file
  uint32_t threads = 1;
};

class LiveScene {
 public:
  explicit LiveScene(const LiveOptions& options);

  // Moves on by this many seconds of wall time. It runs zero, one or two frames of the scene. Then the grains are those
  // of the present instant, which lies between the last two frames.
  void advance(double seconds);
  void restart();

  void push_at(std::optional<Vec3> place);  // the centre of the pushing sphere; none: no sphere
  void pour_at(std::optional<Vec3> place);  // the centre of the nozzle; none: nothing pours
  void turn_light(double polar_deg, double azimuth_deg);
  void scale_budget(double factor);  // the budget stays within 0.1..1000 ms

  std::span<const sandglass_grain> grains() const { return simulation_->output(); }
  const std::vector<float>& particles() { return simulation_->particle_positions(); }
  const CollisionFields& fields() const { return *fields_; }
  const std::vector<sandglass_collider>& colliders() const { return colliders_; }  // the pushing sphere is the last one
  std::vector<FloorShadow> shadows() const;                                        // of the objects
  std::optional<FloorShadow> pile(bool on_sand) const;                             // of the sand, if the scene has one
  bool runs(sandglass_stage stage) const;  // whether frames have work units of this stage
  Vec3 to_light() const { return scene_.light->towards(0.0); }
  const sandglass_frame_report& report() const { return report_; }  // of the last frame that advanced time
  const SceneFile& scene() const { return scene_; }
  double budget_ms() const { return scene_.budget_ms; }
  double grain_radius() const { return grain_radius_; }
  double push_radius() const { return push_radius_; }
  double floor() const { return floor_; }
  const Bounds& bounds() const { return bounds_; }  // of the sand at the start, the colliders and the emitters
  bool pushing() const { return push_.has_value(); }

 private:
  void frame(double time_step, double lag);

  SceneFile scene_;
  std::optional<CollisionFields> fields_;
  Material material_;
  std::optional<ThreadPool> pool_;
  std::optional<Simulation> simulation_;
  std::optional<StandingShadows> shadows_;
  std::optional<PileShadow> pile_;
  std::vector<sandglass_collider> colliders_;
  sandglass_frame_report report_ = {};
  Bounds bounds_;
  double owed_ = 0.0, grain_radius_ = 0.0, push_radius_ = 0.0, floor_ = 0.0;
  uint32_t frame_ = 0, grains_per_particle_ = 0;
  std::optional<Vec3> push_, pushed_before_, pour_;
};

}  // namespace sandglass::host

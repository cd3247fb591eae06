// A scene that runs by the wall clock and can be touched: sand poured where the cursor points, pushed by a sphere, the
// light turned, the budget changed. The library's own shadows are in the frame, of the objects and of the sand; a room
// and an estimate of its light are not. Knows nothing of windows.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/drawing/render.h"
#include "models/simulation/body_meshes.h"
#include "models/simulation/collision_fields.h"
#include "models/simulation/pile_shadow.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/simulation.h"
#include "models/simulation/standing_shadows.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

struct LiveOptions {
  std::string scene, mesh, collider_mesh, isa = "automatic";
  double budget_ms = -1.0;  // below 0: the scene's
  uint32_t threads = 1;
};

class LiveScene {
 public:
  explicit LiveScene(const LiveOptions& options);

  // Moves on by so many seconds of wall time: none, one or two frames of the scene, then the grains for the present
  // instant, which lies between the last two frames.
  void advance(double seconds);
  void restart();

  void push_at(std::optional<Vec3> place);  // the pushing sphere's centre; none: no sphere
  void pour_at(std::optional<Vec3> place);  // the nozzle's centre; none: nothing pours
  void turn_light(double polar_deg, double azimuth_deg);
  void scale_budget(double factor);  // within 0.1..1000 ms

  std::span<const sandglass_grain> grains() const { return simulation_->output(); }
  const std::vector<float>& particles() { return simulation_->particle_positions(); }
  const std::vector<sandglass_collider>& colliders() const { return colliders_; }  // the sphere last, while it pushes
  std::vector<FloorShadow> shadows() const;                                        // of the objects
  std::optional<FloorShadow> pile(bool on_sand) const;  // of the sand, where the scene has one
  bool runs(sandglass_stage stage) const;               // any frame has units of it
  Vec3 to_light() const { return scene_.light->towards(0.0); }
  const sandglass_frame_report& report() const { return report_; }  // of the last frame that moved time on
  const SceneFile& scene() const { return scene_; }
  double budget_ms() const { return scene_.budget_ms; }
  double grain_radius() const { return grain_radius_; }
  double push_radius() const { return push_radius_; }
  double floor() const { return floor_; }
  const Bounds& bounds() const { return bounds_; }  // of the sand at the start and of what stands there
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

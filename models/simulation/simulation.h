// One scene of the library with the block it lives in, and its state as arrays: what run, bench, verify and the tests
// drive.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/work/block.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

class Simulation {
 public:
  explicit Simulation(const sandglass_scene_desc& desc);  // a Failure with the library's own sentence

  void add(const Material& material);
  void add(std::span<const float> particles, std::span<const float> velocities);

  // budget_ns UINT64_MAX: all the work. `plan`: a recorded plan to execute.
  sandglass_frame_report frame(double time_step, uint64_t budget_ns, std::span<const sandglass_collider> colliders,
                               const sandglass_plan* plan = nullptr, std::span<sandglass_shadow* const> shadows = {});
  // The frame that the input describes, but for where grains are written.
  sandglass_frame_report frame(sandglass_frame_input input);

  // What pours and what swallows from the next frame on.
  void flow(Flow flow) { flow_ = std::move(flow); }

  // The sand's own shadow from the next frame on; null: none.
  void cast(sandglass_pile_shadow* shadow) { pile_shadow_ = shadow; }

  // The light to estimate, and the image for the next frame; null: none.
  void see(sandglass_light* light, const sandglass_camera_image* image) { light_ = light, image_ = image; }

  // After sandglass_scene_reset: filled as at the start.
  void restart(const Material& material);

  // As the last frame wrote them, at the instant that its output_lag asked for.
  std::span<const sandglass_grain> output() const { return output_; }

  // Refreshed by each call; 3 floats an item, as many items as were added or emitted.
  const std::vector<float>& particle_positions();
  const std::vector<float>& particle_velocities();
  const std::vector<float>& grain_positions();
  const std::vector<float>& grain_velocities();

  sandglass_scene* handle() const { return scene_; }
  uint64_t bytes() const { return bytes_; }

 private:
  sandglass_scene* scene_ = nullptr;
  Block block_;
  uint64_t bytes_ = 0;
  Flow flow_;
  sandglass_pile_shadow* pile_shadow_ = nullptr;
  sandglass_light* light_ = nullptr;
  const sandglass_camera_image* image_ = nullptr;
  uint32_t particles_ = 0, grains_ = 0;
  std::vector<float> positions_, velocities_, grain_positions_, grain_velocities_;
  std::vector<sandglass_grain> output_;  // stands for the app's buffer
};

// The description of the scene filled with this material: rigid bodies and their colliders included.
sandglass_scene_desc describe_filled(const SceneFile& scene, const Material& material);

std::vector<sandglass_collider> colliders_over_frame(const SceneFile& scene, uint32_t frame);

// Appends the shapes of the scene's rigid boxes and spheres where they will be `ahead` seconds from now, at the end of
// the coming frame: they keep grains out and are drawn.
void add_rigid_shapes(const SceneFile& scene, const sandglass_scene* state, double ahead,
                      std::vector<sandglass_collider>* colliders);

// The instruction set of that name, or a Failure: the name is unknown, this build lacks it, or this CPU does.
sandglass_isa find_isa(const std::string& name);

}  // namespace sandglass::host

// One scene of the library with the memory it lives in, and its state as arrays. The commands run, bench and verify and
// the tests drive it.
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
  // Throws a Failure with the library's own sentence.
  explicit Simulation(const sandglass_scene_desc& desc);

  void add(const Material& material);
  void add(std::span<const float> particles, std::span<const float> velocities);

  // Runs one frame. With a `budget_ns` of UINT64_MAX it does all the work. `plan` is a recorded plan to execute, or
  // null.
  sandglass_frame_report frame(double time_step, uint64_t budget_ns, std::span<const sandglass_collider> colliders,
                               const sandglass_plan* plan = nullptr, std::span<sandglass_shadow* const> shadows = {},
                               std::span<sandglass_cast* const> casts = {});
  // Runs the frame that the input describes. Only the place where grains are written is set here.
  sandglass_frame_report frame(sandglass_frame_input input);

  // Sets the emitters and sinks from the next frame on.
  void flow(Flow flow) { flow_ = std::move(flow); }

  // Sets the sand's own shadow from the next frame on; null: none.
  void cast(sandglass_pile_shadow* shadow) { pile_shadow_ = shadow; }

  // Sets the light to estimate, the room to see, and the image for both, from the next frame on; null: none.
  void see(sandglass_estimator* light, sandglass_room* room, const sandglass_camera_image* image) {
    light_ = light;
    room_ = room;
    image_ = image;
  }

  // Each call refreshes its array. It holds 3 floats per item, for all items that were added or emitted.
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
  sandglass_estimator* light_ = nullptr;
  sandglass_room* room_ = nullptr;
  const sandglass_camera_image* image_ = nullptr;
  uint32_t particles_ = 0, grains_ = 0;
  std::vector<float> positions_, velocities_, grain_positions_, grain_velocities_;
  std::vector<sandglass_grain> output_;  // the buffer that an app would give
};

// The description of the scene that holds this material, with room for the rigid bodies and their colliders.
sandglass_scene_desc describe_filled(const SceneFile& scene, const Material& material);

// The scene file's colliders over the given frame.
std::vector<sandglass_collider> colliders_over_frame(const SceneFile& scene, uint32_t frame);

// Appends the shapes of the scene's rigid boxes and spheres as colliders. They stand where they will be in `ahead`
// seconds, at the end of the coming frame. They keep grains out and are drawn.
void add_rigid_shapes(const SceneFile& scene, const sandglass_scene* state, double ahead,
                      std::vector<sandglass_collider>* colliders);

// The instruction set of that name. Throws a Failure when the name is unknown, or when this build or this CPU lacks it.
sandglass_isa find_isa(const std::string& name);

}  // namespace sandglass::host

// A thin layer: every rule is in the library.
#include "models/simulation/simulation.h"

#include <string>

#include "models/files/failure.h"

namespace sandglass::host {

// `reason` is a reference because the call that sets it is an argument too, and C++ may evaluate arguments in any
// order.
static void require(sandglass_status status, const char* const& reason) {
  if (status == SANDGLASS_OK) return;
  throw cannot("create", "scene", reason != nullptr ? reason : sandglass_status_name(status));
}

Simulation::Simulation(const sandglass_scene_desc& desc) {
  const char* reason = nullptr;
  require(sandglass_scene_bytes(&desc, &bytes_, &reason), reason);
  block_ = new_block(bytes_, "the scene", "make the scene smaller");
  require(sandglass_scene_create(&desc, block_.get(), bytes_, &scene_, &reason), reason);
  output_.reserve(desc.granular.grain_capacity);  // so that no frame allocates
}

void Simulation::add(const Material& material) {
  const char* reason = nullptr;
  const sandglass_points particles = {material.particle_positions.data(), material.particle_velocities.data(),
                                      material.particles()},
                         grains = {material.grain_positions.data(), material.grain_velocities.data(),
                                   material.grains()};
  require(sandglass_scene_add(scene_, &particles, &grains, &reason), reason);
  for (const RigidSample& sample : material.rigid) {
    sandglass_body body;
    sandglass_body_default(&body);
    body.particle_positions = sample.positions.data();
    body.particle_count = static_cast<uint32_t>(sample.positions.size() / 3);
    body.density_ratio = static_cast<float>(sample.density);
    to_floats(sample.velocity, body.linear_velocity);
    to_floats(sample.spin, body.angular_velocity);
    require(sandglass_scene_add_body(scene_, &body, nullptr, &reason), reason);
  }
  particles_ += material.particles() + material.rigid_particles();
  grains_ += material.grains();
  output_.resize(grains_);
}

void Simulation::add(std::span<const float> particles, std::span<const float> velocities) {
  Material material;
  material.particle_positions.assign(particles.begin(), particles.end());
  material.particle_velocities.assign(velocities.begin(), velocities.end());
  material.particle_velocities.resize(particles.size());
  add(material);
}

sandglass_frame_report Simulation::frame(double time_step, uint64_t budget_ns,
                                         std::span<const sandglass_collider> colliders, const sandglass_plan* plan,
                                         std::span<sandglass_shadow* const> shadows,
                                         std::span<sandglass_cast* const> casts) {
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = static_cast<float>(time_step);
  input.budget_ns = budget_ns;
  input.colliders = colliders.data();
  input.collider_count = static_cast<uint32_t>(colliders.size());
  input.plan = plan;
  input.emitters = flow_.emitters.data();
  input.emitter_count = static_cast<uint32_t>(flow_.emitters.size());
  input.sinks = flow_.sinks.data();
  input.sink_count = static_cast<uint32_t>(flow_.sinks.size());
  input.shadows = shadows.data();
  input.shadow_count = static_cast<uint32_t>(shadows.size());
  input.casts = casts.data();
  input.cast_count = static_cast<uint32_t>(casts.size());
  input.pile_shadow = pile_shadow_;
  input.estimator = light_;
  input.room = room_;
  input.camera = image_;
  return frame(input);
}

sandglass_frame_report Simulation::frame(sandglass_frame_input input) {
  if (grains_ > 0) {
    input.grains = output_.data();
    input.grain_stride = sizeof(sandglass_grain);
    input.grain_capacity = grains_;
  }
  sandglass_frame_report report = {};
  report.struct_size = sizeof report;
  const char* reason = nullptr;
  require(sandglass_scene_frame(scene_, &input, &report, &reason), reason);
  particles_ = report.sand.particle_numbers;
  grains_ = report.sand.grain_numbers;
  output_.resize(grains_);
  return report;
}

static const std::vector<float>& refreshed(std::vector<float>* array, uint32_t count, const auto& read) {
  array->resize(3 * static_cast<size_t>(count));
  read(array->data());
  return *array;
}
const std::vector<float>& Simulation::particle_positions() {
  return refreshed(&positions_, particles_, [&](float* to) { sandglass_scene_particles(scene_, to, nullptr); });
}
const std::vector<float>& Simulation::particle_velocities() {
  return refreshed(&velocities_, particles_, [&](float* to) { sandglass_scene_particles(scene_, nullptr, to); });
}
const std::vector<float>& Simulation::grain_positions() {
  return refreshed(&grain_positions_, grains_, [&](float* to) { sandglass_scene_grains(scene_, to, nullptr); });
}
const std::vector<float>& Simulation::grain_velocities() {
  return refreshed(&grain_velocities_, grains_, [&](float* to) { sandglass_scene_grains(scene_, nullptr, to); });
}

sandglass_scene_desc describe_filled(const SceneFile& scene, const Material& material) {
  sandglass_scene_desc desc =
      describe_scene(scene, material.particles() + material.rigid_particles(), material.grains());
  desc.granular.body_capacity = static_cast<uint32_t>(material.rigid.size());
  desc.granular.body_particle_capacity = material.rigid_particles();
  desc.granular.collider_capacity += static_cast<uint32_t>(material.rigid.size());
  expect_taken(scene, desc);
  return desc;
}

std::vector<sandglass_collider> colliders_over_frame(const SceneFile& scene, uint32_t frame) {
  std::vector<sandglass_collider> colliders;
  for (const ColliderTrack& track : scene.colliders)
    colliders.push_back(collider_over_frame(track, frame * scene.frame_step, scene.frame_step));
  return colliders;
}

void add_rigid_shapes(const SceneFile& scene, const sandglass_scene* state, double ahead,
                      std::vector<sandglass_collider>* colliders) {
  uint32_t index = 0;
  for (const Body& body : scene.bodies) {
    if (body.rigid == 0.0) continue;
    const bool there = sandglass_scene_has_body(state, index) != 0;  // no sink has taken it
    const sandglass_body_pose pose = sandglass_scene_body_pose(state, index++);
    if (!there || (body.shape != BodyShape::box && body.shape != BodyShape::sphere)) continue;
    sandglass_collider shape = {};
    shape.shape = body.shape == BodyShape::box ? SANDGLASS_SHAPE_BOX : SANDGLASS_SHAPE_SPHERE;
    shape.grains_only = 1;
    const double half[3] = {0.5 * body.size.x, 0.5 * body.size.y, 0.5 * body.size.z};
    for (int k = 0; k < 3; ++k) {
      shape.position[k] = pose.position[k] + static_cast<float>(ahead) * pose.linear_velocity[k];
      shape.size[k] = static_cast<float>(body.shape == BodyShape::box ? half[k] : half[1]);
      shape.linear_velocity[k] = pose.linear_velocity[k];
      shape.angular_velocity[k] = pose.angular_velocity[k];
    }
    const Quaternion turned = normalised(multiply(
        rotation_by(from_floats(pose.angular_velocity) * ahead),
        multiply(Quaternion{pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]}, body.rotation)));
    for (size_t k = 0; k < 4; ++k) shape.rotation[k] = static_cast<float>(turned[k]);
    colliders->push_back(shape);
  }
}

sandglass_isa find_isa(const std::string& name) {
  constexpr sandglass_isa k_isa_limit = 16;  // above every number that sandglass_isa_name knows
  std::string available;
  sandglass_isa found = -1;
  for (sandglass_isa isa = 0; isa < k_isa_limit; ++isa) {
    const char* isa_name = sandglass_isa_name(isa);
    if (isa_name == nullptr) continue;
    if (sandglass_isa_available(isa) != 0) available += (available.empty() ? "" : ", ") + std::string(isa_name);
    if (name == isa_name) found = isa;
  }
  if (found >= 0 && sandglass_isa_available(found) != 0) return found;
  if (found >= 0)
    throw cannot("use", name, "this CPU, or this build, lacks the instruction set", "Take one of " + available);
  throw cannot("use", name, "no instruction set has this name", "Take one of " + available);
}

}  // namespace sandglass::host

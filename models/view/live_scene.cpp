// See live_scene.h.
#include "models/view/live_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_poured_particles = 4000;   // room for this many particles beside the scene's own
constexpr uint32_t k_grains_per_particle = 16;  // when the scene has no particles
constexpr double k_nozzle_radii = 4.0;          // in particle radii
// m/s at a particle radius of 1 cm. It grows with the root of the radius, as the speed of a fall does.
constexpr double k_pour_speed = 0.6;
constexpr double k_push_radii = 5.0;  // in particle radii
// m/s, the highest speed of the sphere, so that a cursor that jumps does not hit the sand.
constexpr double k_push_speed = 1.0;
constexpr uint32_t k_frames_at_once = 2;  // after a pause the scene does not run on to catch up
// Degrees: the renderer's own sun, when the scene has no light.
constexpr double k_sun_polar = 40, k_sun_azimuth = 144;

}  // namespace

LiveScene::LiveScene(const LiveOptions& options) : scene_(load_scene(options.scene)) {
  if (options.budget_ms >= 0.0) scene_.budget_ms = options.budget_ms;
  const sandglass_isa isa = find_isa(options.isa);
  const LoadedMeshes meshes(scene_, options.mesh);
  if (!meshes.note().empty()) std::fprintf(stderr, "sandglass: note: %s\n", meshes.note().c_str());
  material_ = fill_scene(&scene_, meshes.bodies());
  fields_.emplace(&scene_, options.collider_mesh);

  const double r = scene_.particle_radius;
  push_radius_ = k_push_radii * r;
  grains_per_particle_ =
      material_.particles() == 0 ? k_grains_per_particle : std::min(64u, material_.grains() / material_.particles());
  if (!scene_.emitters.empty()) grains_per_particle_ = scene_.emitters[0].emitter.grains_per_particle;
  sandglass_scene_desc desc = describe_filled(scene_, material_);
  desc.isa = isa;
  desc.clock = sandglass_clock_system();
  desc.granular.particle_capacity += k_poured_particles;
  desc.granular.grain_capacity += k_poured_particles * grains_per_particle_;
  desc.granular.emitter_capacity += 1, desc.granular.collider_capacity += 1;
  const uint32_t particles = std::max(1u, material_.particles()),
                 grains = material_.particles() > 0 ? material_.grains() : grains_per_particle_;
  grain_radius_ = grains > 0 ? static_cast<double>(drawn_grain_radius(r, particles, grains)) : r;
  if (grains > 0) desc.granular.grain_radius = static_cast<float>(grain_radius_);
  pool_.emplace(options.threads);
  desc.parallel = pool_->hook();
  simulation_.emplace(desc);
  simulation_->add(material_);
  if (!scene_.light) scene_.light = LightTrack{{k_sun_polar, k_sun_polar}, {k_sun_azimuth, k_sun_azimuth}};
  turn_light(0.0, 0.0);
  shadows_.emplace(scene_, isa);
  if (scene_.pile_shadow) pile_.emplace(*scene_.pile_shadow, isa);

  bounds_.add_most(material_.grains() > 0 ? material_.grain_positions : material_.particle_positions);
  floor_ = 1e30;
  for (const sandglass_collider& c : colliders_over_frame(scene_, 0)) {
    const Vec3 at = from_floats(c.position);
    if (c.shape == SANDGLASS_SHAPE_HALF_SPACE) floor_ = std::min(floor_, at.y);
    else bounds_.add(at);
  }
  for (const EmitterTrack& track : scene_.emitters) bounds_.add(from_floats(track.emitter.position));
  if (floor_ > 1e29) floor_ = bounds_.empty() ? 0.0 : bounds_.low.y;
  if (bounds_.empty()) bounds_.add({0, floor_, 0});
  bounds_.add({bounds_.low.x, floor_, bounds_.low.z});
  frame(0.0, 0.0);
}

void LiveScene::restart() {
  sandglass_scene_reset(simulation_->handle());
  simulation_->restart(material_);
  if (pile_) sandglass_pile_shadow_refresh(pile_->handle());
  frame_ = 0, owed_ = 0.0, report_ = {};
  frame(0.0, 0.0);
}

void LiveScene::push_at(std::optional<Vec3> place) { push_ = place; }
void LiveScene::pour_at(std::optional<Vec3> place) { pour_ = place; }

void LiveScene::turn_light(double polar_deg, double azimuth_deg) {
  LightTrack& light = *scene_.light;
  light.polar_deg[0] = light.polar_deg[1] = std::clamp(light.polar_deg[0] + polar_deg, 0.0, 85.0);
  light.azimuth_deg[0] = light.azimuth_deg[1] = std::fmod(light.azimuth_deg[0] + azimuth_deg, 360.0);
}

void LiveScene::scale_budget(double factor) { scene_.budget_ms = std::clamp(scene_.budget_ms * factor, 0.1, 1000.0); }

void LiveScene::frame(double time_step, double lag) {
  colliders_ = colliders_over_frame(scene_, frame_);
  add_rigid_shapes(scene_, simulation_->handle(), scene_.frame_step, &colliders_);
  const double r = scene_.particle_radius;
  if (push_) {
    sandglass_collider sphere = {};
    sphere.shape = SANDGLASS_SHAPE_SPHERE;
    sphere.rotation[3] = 1.0f;
    sphere.size[0] = static_cast<float>(push_radius_);
    Vec3 at = *push_, velocity = {};
    if (pushed_before_ && time_step > 0.0) {
      velocity = (at - *pushed_before_) * (1.0 / time_step);
      if (const double speed = length(velocity); speed > k_push_speed) {
        velocity = velocity * (k_push_speed / speed);
        at = *pushed_before_ + velocity * time_step;
      }
    } else if (pushed_before_) {
      at = *pushed_before_;
    }
    to_floats(at, sphere.position);
    to_floats(velocity, sphere.linear_velocity);
    colliders_.push_back(sphere);
    pushed_before_ = at;
  } else {
    pushed_before_.reset();
  }

  Flow flow = flow_over_frame(scene_, frame_ * scene_.frame_step);
  if (pour_) {
    sandglass_emitter nozzle = {};
    to_floats(*pour_, nozzle.position);
    nozzle.rotation[3] = 1.0f;
    nozzle.radius = static_cast<float>(k_nozzle_radii * r);
    nozzle.speed = static_cast<float>(k_pour_speed * std::sqrt(r / 0.01));
    nozzle.grains_per_particle = grains_per_particle_;
    flow.emitters.push_back(nozzle);
  }
  shadows_->set_light(scene_, frame_, scene_.light->towards(0.0));
  if (pile_) pile_->set_light(scene_.light->towards(0.0));

  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = static_cast<float>(time_step);
  input.budget_ns = static_cast<uint64_t>(scene_.budget_ms * 1e6);
  input.colliders = colliders_.data(), input.collider_count = static_cast<uint32_t>(colliders_.size());
  input.emitters = flow.emitters.data(), input.emitter_count = static_cast<uint32_t>(flow.emitters.size());
  input.sinks = flow.sinks.data(), input.sink_count = static_cast<uint32_t>(flow.sinks.size());
  input.shadows = shadows_->handles().data(), input.shadow_count = static_cast<uint32_t>(shadows_->handles().size());
  input.pile_shadow = pile_ ? pile_->handle() : nullptr;
  input.output_lag = static_cast<float>(lag);
  const sandglass_frame_report now = simulation_->frame(input);
  if (time_step > 0.0 || report_.struct_size == 0) report_ = now;
}

void LiveScene::advance(double seconds) {
  const double step = scene_.frame_step;
  owed_ = std::min(owed_ + std::max(0.0, seconds), k_frames_at_once * step);
  bool moved = false;
  while (owed_ >= step) {
    owed_ -= step;
    ++frame_;
    frame(step, step - owed_);
    moved = true;
  }
  if (!moved) frame(0.0, step - owed_);  // the display is faster than the simulation: same state, later instant
}

std::vector<FloorShadow> LiveScene::shadows() const {
  SceneShadows now;
  shadows_->draw(colliders_, &now);
  return now.object;
}

std::optional<FloorShadow> LiveScene::pile(bool on_sand) const {
  return pile_ ? std::optional(pile_->drawn(on_sand)) : std::nullopt;
}

bool LiveScene::runs(sandglass_stage stage) const {
  if (stage == SANDGLASS_STAGE_SHADOW) return pile_ || !shadows_->handles().empty();
  return stage != SANDGLASS_STAGE_LIGHTING;  // no light is estimated here
}

}  // namespace sandglass::host

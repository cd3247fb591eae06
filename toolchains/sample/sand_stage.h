// What the sample apps share on every phone. A scene is made once, and sand is poured above a point of the real floor.
// One call a frame fills a mapped buffer with grains, estimates the light of the room from the camera's image, and
// updates the sand's soft shadow, all in one budget. Positions are those of the AR session's world: metres, y up, as
// Sandglass has them.
//
// An app with objects of its own adds their baked shadows: it makes a sandglass_shadow beside the scene (shadow.h),
// gives it the estimate's direction turned into the object's frame, and passes it as input.shadows.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/light.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/sandglass.hpp"

namespace sample {

constexpr float k_particle_radius = 0.01f;
constexpr uint32_t k_particles = 1500, k_grains = 25000;  // as much as a phone simulates in the budget
constexpr float k_block_half = 0.1f;                      // metres, half the side of the block that is poured
constexpr float k_shadow_half = 0.64f;                    // metres, half the side of the floor that receives the shadow
constexpr uint32_t k_shadow_texels = 128;                 // on a side: a texel is as wide as a particle's radius
constexpr uint64_t k_budget_ns = 4'000'000;

class SandStage {
 public:
  // Makes scene, shadow and light, with all memory that the library ever uses. `network` is the file of a lighting
  // network (models/lights/room.light) in 8-byte words, of which the file fills `network_bytes`. Without one the light
  // stays as it begins: grey, from everywhere, with no visible shadow. `trace` is the system's profiler or the app's
  // own hook.
  sandglass::Status create(std::vector<uint64_t> network = {}, uint64_t network_bytes = 0,
                           sandglass_trace trace = sandglass_trace_system()) {
    estimate_.direction[1] = 1.0f;
    for (float& channel : estimate_.ambient) channel = 0.5f;
    sandglass_pile_shadow_desc shadow;
    sandglass_pile_shadow_desc_default(&shadow);
    for (int k = 0; k < 2; ++k) shadow.low[k] = -k_shadow_half, shadow.high[k] = k_shadow_half;
    shadow.texels = k_shadow_texels;
    shadow.on_sand = 0;
    sandglass::Status status;
    uint64_t bytes = 0;
    status.code = sandglass_pile_shadow_bytes(&shadow, &bytes, &status.reason);
    if (!status) return status;
    shadow_block_ = sandglass::allocate_block(bytes);
    status.code = sandglass_pile_shadow_create(&shadow, shadow_block_.get(), bytes, &shadow_, &status.reason);
    if (!status) return status;

    network_ = std::move(network);
    if (!network_.empty()) {
      sandglass_light_desc light = sandglass::light_desc();
      light.asset = network_.data(), light.asset_bytes = network_bytes;
      status = light_.create(light);
      if (!status) return status;
    }

    sandglass_scene_desc desc = sandglass::scene_desc();
    desc.clock = sandglass_clock_system();
    desc.trace = trace;
    desc.granular.particle_radius = k_particle_radius;
    desc.granular.particle_capacity = k_particles;
    desc.granular.grain_capacity = k_grains;
    desc.granular.collider_capacity = 1;
    return scene_.create(desc);
  }

  // Replaces all sand by a block of it above a point of a real horizontal surface.
  sandglass::Status pour(const float point[3]) {
    const float r = k_particle_radius, h = k_block_half;
    for (int k = 0; k < 3; ++k) origin_[k] = point[k];  // the scene's origin: grains are given relative to it
    floor_ = sandglass::floor_at(0.0f);
    scene_.reset();
    drawn_ = 0;
    std::vector<float> particles, grains;
    const auto everywhere = [](const float*) { return true; };
    const sandglass::Box box{{-h, 2 * r, -h}, {h, 2 * r + 0.9f * 2 * h, h}};
    sandglass::Status status = sandglass::sample_lattice(box, 2.02f * r, everywhere, &particles);
    if (status) status = sandglass::sample_volume(box, 0.58f * r, everywhere, &grains);
    if (!status) return status;
    if (particles.size() > 3 * k_particles) particles.resize(3 * k_particles);
    if (grains.size() > 3 * k_grains) grains.resize(3 * k_grains);
    status = scene_.add(particles, grains);
    if (status) drawn_ = static_cast<uint32_t>(grains.size() / 3);
    return status;
  }

  // Runs one frame, `seconds` after the last one. `headroom` is that of sandglass_frame_input. `grains` is the
  // renderer's mapped buffer of k_grains items. `camera` is the newest image or null; it is read in this call only. A
  // performance hint session takes report.target_ns and report.elapsed_ns. If report.light_changed is set, the renderer
  // has to take light() again.
  sandglass_frame_report frame(float seconds, float headroom, sandglass_grain* grains,
                               const sandglass_camera_image* camera = nullptr) {
    (void)!sandglass_pile_shadow_set_light(shadow_, estimate_.direction, nullptr);  // a unit vector is never refused
    sandglass_frame_input input = sandglass::frame_input();
    input.time_step = seconds;
    input.budget_ns = k_budget_ns;
    input.thermal_headroom = headroom;
    input.colliders = &floor_, input.collider_count = 1;
    input.grains = grains, input.grain_capacity = k_grains;
    input.pile_shadow = shadow_;
    input.light = light_.get(), input.camera = light_ ? camera : nullptr;
    sandglass_frame_report report = sandglass::frame_report();
    const sandglass::Status status = scene_.frame(input, &report);
    if (!status) drawn_ = 0;
    if (report.light_changed != 0) estimate_ = light_.estimated();
    return report;
  }

  // The light of the room, in the session's world.
  const sandglass_light_estimate& light() const { return estimate_; }
  // The sand's shadow on the floor: `low` and `high` are x and z relative to origin(). Upload it after each frame.
  sandglass_pile_shadow_texture shadow() const {
    sandglass_pile_shadow_texture texture{};
    texture.struct_size = sizeof texture;
    sandglass_pile_shadow_get_texture(shadow_, &texture);
    return texture;
  }
  // The factor of coverage: the floor keeps 1 - coverage * shadow_strength() of its light.
  float shadow_strength() const { return shadow().opacity * estimate_.contrast; }

  const float* origin() const { return origin_; }  // in the session's world
  uint32_t drawn() const { return drawn_; }        // grains to draw
  explicit operator bool() const { return static_cast<bool>(scene_); }

 private:
  sandglass::Scene scene_;
  sandglass::Light light_;
  std::vector<uint64_t> network_;  // light_ reads it
  sandglass::Block shadow_block_;
  sandglass_pile_shadow* shadow_ = nullptr;
  sandglass_light_estimate estimate_ = {};
  sandglass_collider floor_ = sandglass::floor_at(0.0f);
  float origin_[3] = {0, 0, 0};
  uint32_t drawn_ = 0;
};

}  // namespace sample

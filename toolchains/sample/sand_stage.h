// What the sample apps share on every phone. A scene is made once, and sand is poured above a point of the real floor.
// One call a frame fills a mapped buffer with grains, gathers the light of the room from the camera's image, and
// updates the sand's shadows, all in one budget. Positions are those of the AR session's world: metres, y up, as
// Sandglass has them.
//
// An app with objects of its own adds their baked shadows: it makes a sandglass_shadow beside the scene (shadow.h),
// hands it the same cells and main light (models/examples/camera_app.cpp), and passes it as input.shadows.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sample {

constexpr float k_particle_radius = 0.01f;
constexpr uint32_t k_particles = 1500, k_grains = 25000;  // as much as a phone simulates in the budget
constexpr float k_block_half = 0.1f;                      // metres, half the side of the block that is poured
constexpr float k_shadow_half = 0.64f;                    // metres, half the side of the floor that receives the shadow
constexpr uint32_t k_shadow_texels = 128;                 // on a side: a texel is as wide as a particle's radius
constexpr uint32_t k_sky_texels = 64;                     // of the shadow of all other light, which is softer
constexpr float k_enough_seen = 0.5f;                     // below, the user is asked to look around
// Above this share of the light from clipped pixels, a short exposure helps: behind little of it may be a strong lamp.
constexpr float k_much_clipped = 0.02f;
constexpr uint64_t k_budget_ns = 4'000'000;

class SandStage {
 public:
  // Makes scene, shadow and room, with all memory that the library ever uses. `trace` is the system's profiler or the
  // app's own hook.
  sandglass::Status create(sandglass_trace trace = sandglass_trace_system()) {
    sandglass_pile_shadow_desc shadow = sandglass::pile_shadow_desc();
    for (int k = 0; k < 2; ++k) shadow.low[k] = -k_shadow_half, shadow.high[k] = k_shadow_half;
    shadow.texels = k_shadow_texels, shadow.sky_texels = k_sky_texels;
    shadow.on_sand = 0;
    sandglass::Status status = shadow_.create(shadow);
    if (status) status = room_.create();
    if (!status) return status;
    shown_ = known_ = room_.light_at(origin_);  // what is usual in a room
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
    known_ = room_.light_at(origin_);
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
  // performance hint session takes report.target_ns and report.elapsed_ns.
  sandglass_frame_report frame(float seconds, float headroom, sandglass_grain* grains,
                               const sandglass_camera_image* camera = nullptr) {
    const float* d = shown_.main_direction;  // unit vectors and shares of a light are never refused
    (void)shadow_.set_light({d[0], d[1], d[2]});
    (void)shadow_.set_cells(shown_.ambient_cells);
    sandglass_frame_input input = sandglass::frame_input();
    input.time_step = seconds;
    input.budget_ns = k_budget_ns;
    input.thermal_headroom = headroom;
    input.colliders = &floor_, input.collider_count = 1;
    input.grains = grains, input.grain_capacity = k_grains;
    input.pile_shadow = shadow_.get();
    input.room = room_.get(), input.camera = camera;
    sandglass_frame_report report = sandglass::frame_report();
    const sandglass::Status status = scene_.frame(input, &report);
    if (!status) drawn_ = 0;
    if (camera != nullptr) known_ = room_.light_at(origin_), exposure_ = camera->exposure;
    sandglass_room_light_fade(&shown_, &known_, seconds);
    return report;
  }

  // The light of the room as it is drawn, in the session's world.
  const sandglass_room_light& light() const { return shown_; }
  // Its irradiance and harmonics are in the scale of the image that the room took in last. This makes them those of the
  // image on the screen, where the system tells exposures.
  float light_scale() const { return exposure_ > 0.0f && shown_.white > 0.0f ? exposure_ * shown_.white : 1.0f; }
  // The sand's shadow of the main light on the floor: `low` and `high` are x and z relative to origin(). Upload it
  // after each frame, and the one below.
  sandglass_pile_shadow_texture shadow() const { return shadow_.texture(); }
  // What the sand leaves of all other light. The floor keeps sky().floor / 255 - coverage / 255 * shadow_strength().
  sandglass_pile_shadow_sky sky() const { return shadow_.sky(); }
  float shadow_strength() const { return shadow().opacity * shown_.main_share; }

  // Where to ask the user to look, or null where enough of the room was seen.
  const float* look() const { return known_.seen < k_enough_seen ? known_.look : nullptr; }
  // Whether images with a short exposure, such as a sixty-fourth, would help. Keep it for 0.1 s, in which the room
  // takes one image, and do not show those images.
  bool wants_short_exposure() const { return known_.clipped > k_much_clipped; }

  // Another room: forgets all that was seen.
  void forget_room() { room_.reset(), known_ = room_.light_at(origin_); }
  // What was seen, for a later session. It holds in the same world frame alone: restore it when ARKit has relocalised
  // to the world map that was saved with it, or after sandglass_room_move from one persistent anchor to the same.
  sandglass::Status save_room(std::vector<std::byte>* data) const { return room_.save(data); }
  sandglass::Status restore_room(const void* data, uint64_t bytes) {
    const sandglass::Status status = room_.restore(data, bytes);
    known_ = room_.light_at(origin_);
    return status;
  }

  const float* origin() const { return origin_; }  // in the session's world
  uint32_t drawn() const { return drawn_; }        // grains to draw
  explicit operator bool() const { return static_cast<bool>(scene_); }

 private:
  sandglass::Scene scene_;
  sandglass::PileShadow shadow_;
  sandglass::Room room_;
  sandglass_room_light known_ = {}, shown_ = {};  // now, and on its way there
  float exposure_ = 0.0f;                         // of the last image
  sandglass_collider floor_ = sandglass::floor_at(0.0f);
  float origin_[3] = {0, 0, 0};
  uint32_t drawn_ = 0;
};

}  // namespace sample

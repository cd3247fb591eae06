// What the sample apps share, whatever the phone: a scene made once, sand poured above a point of the real floor, and
// one call a frame that fills a mapped buffer with grains. Positions are those of the AR session's world: metres, y up,
// which is also Sandglass's.
//
// Light and soft shadows have their place in `frame`. The samples draw no object, so they show no shadow: an app that
// does makes a sandglass_shadow of the object's baked file beside the scene (shadow.h), calls
// sandglass_shadow_set_light, passes it as input.shadows and draws the texture on the floor. The light comes from the
// camera image: a sandglass_light of a network's file (light.h), passed as input.light with the image as input.camera;
// where report.light_changed, what sandglass_light_get says goes to the shadows and, converted, to the renderer.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace sample {

constexpr float k_particle_radius = 0.01f;
constexpr uint32_t k_particles = 1500, k_grains = 25000;  // a phone's scene
constexpr float k_heap_half = 0.1f;                       // metres: half the side of the block that is poured
constexpr uint64_t k_budget_ns = 4'000'000;

class SandStage {
 public:
  // Makes the scene: the only allocation of the library's. `trace` is the platform's profiler or the app's own hook.
  sandglass::Status create(sandglass_trace trace = sandglass_trace_system()) {
    sandglass_scene_desc desc = sandglass::scene_desc();
    desc.clock = sandglass_clock_system();
    desc.trace = trace;
    desc.granular.particle_radius = k_particle_radius;
    desc.granular.particle_capacity = k_particles;
    desc.granular.grain_capacity = k_grains;
    desc.granular.collider_capacity = 1;
    return scene_.create(desc);
  }

  // A block of sand above a point of a real horizontal surface, instead of what was there.
  sandglass::Status pour(const float point[3]) {
    const float r = k_particle_radius, h = k_heap_half;
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

  // One frame. `seconds` since the last one; `headroom` as in sandglass_frame_input; `grains` is the renderer's mapped
  // buffer of k_grains items. A performance hint session takes report.target_ns and report.elapsed_ns.
  sandglass_frame_report frame(float seconds, float headroom, sandglass_grain* grains) {
    sandglass_frame_input input = sandglass::frame_input();
    input.time_step = seconds;
    input.budget_ns = k_budget_ns;
    input.thermal_headroom = headroom;
    input.colliders = &floor_, input.collider_count = 1;
    input.grains = grains, input.grain_capacity = k_grains;
    sandglass_frame_report report = sandglass::frame_report();
    const sandglass::Status status = scene_.frame(input, &report);
    if (!status) drawn_ = 0;
    return report;
  }

  const float* origin() const { return origin_; }  // in the session's world
  uint32_t drawn() const { return drawn_; }        // grains to draw
  explicit operator bool() const { return static_cast<bool>(scene_); }

 private:
  sandglass::Scene scene_;
  sandglass_collider floor_ = sandglass::floor_at(0.0f);
  float origin_[3] = {0, 0, 0};
  uint32_t drawn_ = 0;
};

}  // namespace sample

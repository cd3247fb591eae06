// What an app on a phone calls, the same on every system. `create` makes all memory that the library ever uses. `frame`
// pours sand, reads the camera's image for the light of the room, writes the grains straight into buffers of the GPU, and
// draws the shadows of sand and objects on the table, in one budget. The camera's image is new in every frame, so an app
// draws all; it uploads what has changed. models/examples/camera_app.cpp adds hints where to look.
//
// The world is that of the AR session: metres, y up, as Sandglass has it. Grains are given relative to `origin`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "sandglass/sandglass.hpp"

namespace sample {

constexpr float k_particle_radius = 0.01f;
constexpr uint32_t k_particles = 1500, k_grains = 8 * k_particles;  // as much as a phone simulates in the budget
constexpr uint64_t k_budget_ns = 4'000'000;
constexpr float k_table = 0.5f;  // metres, to each side: where shadows are seen
// Of the objects' shadows: for what is real upon the table, as depth shows it, so many metres up.
constexpr uint32_t k_layers = 4;
constexpr float k_receives = 0.15f;
// Shares of the budget: light and depth rest up to the first, and go on above the second. Switching depth takes a while.
constexpr float k_rests_at = 0.5f, k_goes_on_above = 0.7f;

// An image that is exposed for less than this share is one for lamps, as sandglass_room_light.short_exposure asks for:
// a 64th or less. The room learns from it; it is not on the screen.
constexpr float k_short = 1.0f / 32;

// The light of the room for a grain, linear RGB: what one that faces the main light reflects of it, and what one that
// faces up reflects of all other light.
struct Shading {
  float to_light[3], sun[3], ambient[3];
};

// What hides light from the table, as runtime/shadow/README.md draws it: a byte a texel, row after row, layer after layer. `box` is x
// and z of a corner, from origin(), and one over the extents. Upload it when `version` has changed. 0: none was completed yet.
constexpr uint8_t k_none = 0, k_all = 255;
struct ShadowTexture {
  const uint8_t* bytes;
  uint32_t texels = 1, layers = 1;
  float box[4] = {};
  uint64_t version = 0;
};
struct Shadows {
  ShadowTexture object{&k_none}, object_room{&k_all}, sand{&k_none}, sand_room{&k_all};  // the main light's, the room's
  float main_share = 0, sand_opacity = 0;
  float slide[2] = {};  // of `object`, along x and z, metres a metre up
};

// The buffers that grains are written to, in turns. Two are drawn, mixed as sandglass.h says at grains_time. The one to
// write, `next`, was last drawn two frames ago: let the GPU be no further behind.
constexpr uint32_t k_buffers = 3;
struct Buffers {
  uint32_t older = 0, newer = 0, next = 0, ages[k_buffers] = {};
  float share = 1, span = 0;  // of the newer; seconds between the two
  bool changed = false;       // the last frame wrote into its buffer: upload it
  uint64_t versions[k_buffers] = {};
  double times[k_buffers] = {-1, -1, -1};

  void follow(const sandglass_frame_report& report) {
    changed = ages[next] == 0 || versions[next] != report.versions.grains;
    versions[next] = report.versions.grains;
    for (uint32_t& age : ages) age += age > 0;
    ages[next] = 1;
    if (report.sand.grains_time > times[newer]) {  // else it is written again
      older = newer;
      if (versions[newer] != versions[next]) newer = next;  // where nothing has changed, one buffer is both
      times[newer] = report.sand.grains_time;
      next = older == newer ? (newer + 1) % k_buffers : k_buffers - older - newer;
    }
    span = static_cast<float>(times[newer] - times[older]);
    share = span > 0 ? std::clamp(static_cast<float>(report.sand.shown_time - times[older]) / span, 0.0f, 1.0f) : 1;
  }
};

class Sand {
 public:
  // What is made while the phone is hot never takes the best quality levels, even where they fit.
  sandglass::Status create(float headroom = 1.0f, const sandglass_clock& clock = sandglass_clock_system()) {
    sandglass_scene_desc desc = sandglass::scene_desc();
    desc.clock = clock;
    desc.trace = sandglass_trace_system();  // seen in Perfetto, or in Instruments
    rests_ = headroom <= k_rests_at;
    desc.finest_level = rests_ ? SANDGLASS_LEVEL_COARSE : SANDGLASS_LEVEL_FULL;
    desc.granular.particle_radius = k_particle_radius;
    desc.granular.particle_capacity = k_particles;
    desc.granular.grain_capacity = k_grains;
    desc.granular.collider_capacity = desc.granular.emitter_capacity = 1;
    sandglass::Status status = scene_.create(desc);
    if (status) status = room_.create();
    sandglass_pile_shadow_desc pile = sandglass::pile_shadow_desc();
    std::fill_n(pile.low, 2, -k_table);
    std::fill_n(pile.high, 2, k_table);
    pile.sky_texels = 64;
    if (status) status = pile_.create(pile);
    sandglass_cast_desc cast = sandglass::cast_desc();
    cast.layers = k_layers;
    sandglass_cast_plane plane = sandglass::cast_plane();
    plane.height = k_receives;
    if (status) status = cast_.create(cast);
    if (status) status = cast_.set_plane(plane);
    if (status) light_ = known_ = room_.light_at(origin_);  // what is usual in a room
    return status;
  }

  // What else stands on the table and is drawn by the app: it casts. Poses are from origin(); the arrays must stay. Call it
  // again when something has moved.
  sandglass::Status stand(const sandglass_cast_mesh* meshes, uint32_t count) { return cast_.set_meshes(meshes, count); }

  // From now on sand falls onto this point of a real table, which a ray of the AR session hit. What lay elsewhere goes.
  void pour(const float point[3]) {
    for (int k = 0; k < 3; ++k) origin_[k] = point[k];
    light_ = known_ = room_.light_at(origin_);  // what is placed begins in the light that is known
    scene_.reset();
    buffers_ = {buffers_.next, buffers_.next, buffers_.next};  // it begins anew, in the one that is not being drawn
    pouring_ = 1;
  }

  // One frame, `seconds` after the last one. `headroom` is the share of the budget that the device can sustain.
  // `grains` is buffer buffers().next, mapped as it was left, of k_grains items; or null: nothing is written. `camera` is
  // the newest image, or null, also while the session's tracking is limited, because poses are wrong then; it is read in
  // this call only. It is on the screen, unless it is a short one for lamps (k_short). Draw report.sand.grain_numbers
  // grains; removed ones lie beyond every far plane.
  sandglass_frame_report frame(float seconds, float headroom, sandglass_grain* grains,
                               const sandglass_camera_image* camera) {
    const sandglass_collider floor = sandglass::floor_at(0.0f);
    const sandglass_emitter nozzle = sandglass::emitter(0.0f, 0.3f, 0.0f, 0.03f, 0.5f, k_grains / k_particles);
    sandglass_frame_input input = sandglass::frame_input();
    input.time_step = seconds;
    input.budget_ns = k_budget_ns;
    input.thermal_headroom = headroom;
    input.colliders = &floor;
    input.collider_count = 1;
    input.emitters = &nozzle;
    input.emitter_count = pouring_;
    input.grains = grains;
    input.grain_capacity = k_grains;
    input.grains_age = buffers_.ages[buffers_.next];
    if (grains != nullptr && input.grains_age == 0)
      std::fill_n(grains, k_grains, sandglass_grain{{0, SANDGLASS_REMOVED_Y, 0}, -1});
    input.room = room_.get();
    rests_ = headroom <= (rests_ ? k_goes_on_above : k_rests_at);
    input.camera = rests_ ? nullptr : camera;
    const std::array<float, 3> towards = {light_.main_direction[0], light_.main_direction[1], light_.main_direction[2]};
    (void)pile_.set_light(towards, light_.main_angular_diameter);
    (void)cast_.set_light(towards, light_.main_angular_diameter);
    (void)pile_.set_cells(light_.ambient_cells);
    (void)cast_.set_cells(light_.ambient_cells);
    input.pile_shadow = pile_.get();
    sandglass_cast* const casts[] = {cast_.get()};
    input.casts = casts;
    input.cast_count = 1;
    sandglass_frame_report report = sandglass::frame_report();
    if (!scene_.frame(input, &report)) report = sandglass::frame_report();  // an image in an unknown layout, say
    else if (grains == nullptr) buffers_ = {};
    else buffers_.follow(report);
    if (camera != nullptr) {
      known_ = room_.light_at(origin_, &light_);
      if (sandglass_room_exposure(&known_, camera) > k_short) screen_ = *camera;
    }
    sandglass_room_fade(&light_, &known_, seconds);  // light comes and goes softly
    return report;
  }

  Shading shading() const {
    const float scale = sandglass_room_exposure(&light_, &screen_);  // of the image on the screen
    sandglass_light lighting = {};
    sandglass_filament_light of = {};
    lighting.struct_size = sizeof lighting;
    of.struct_size = sizeof of;
    Shading shading = {};
    if (sandglass_light_of_room(&light_, &lighting, nullptr) != SANDGLASS_OK ||
        sandglass_light_to_filament(&lighting, SANDGLASS_LIGHT_AMBIENT, scale, &of, nullptr) != SANDGLASS_OK)
      return shading;
    for (int k = 0; k < 3; ++k) {
      const float up = of.sh[k] + of.sh[3 + k] - of.sh[18 + k] - of.sh[24 + k];  // the harmonics at (0, 1, 0)
      shading.to_light[k] = -of.direction[k];
      shading.sun[k] = of.intensity / std::numbers::pi_v<float> * of.colour[k];
      shading.ambient[k] = of.sh_intensity * std::fmax(up, 0.0f);
    }
    return shading;
  }

  Shadows shadows() const {
    Shadows all;
    take(&all.object, cast_.texture());
    take(&all.object_room, cast_.ambient());
    take(&all.sand, pile_.texture());
    take(&all.sand_room, pile_.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR));
    all.sand_opacity = pile_.texture().scale;
    all.main_share = light_.main_share;
    for (int k = 0; k < 2; ++k) all.slide[k] = cast_.texture().slide[2 * k];
    return all;
  }

  const Buffers& buffers() const { return buffers_; }
  const float* origin() const { return origin_; }  // in the session's world
  // The phone is hot or busy: no light is gathered, what is known stays, and the app pauses depth.
  bool rests() const { return rests_; }
  // What was seen, to save for a later session. It holds in the same world frame alone: after ARKit has relocalised to
  // the world map that was saved with it, or after sandglass_room_move from one persistent anchor to the same.
  sandglass::Room& room() { return room_; }

 private:
  static void take(ShadowTexture* shadow, const sandglass_texture& t) {
    if (t.valid)
      *shadow = {t.bytes, t.side, t.layers, {t.corner[0], t.corner[2], 1 / t.along[0], 1 / t.across[2]}, t.version};
  }

  sandglass::Scene scene_;
  sandglass::Room room_;
  sandglass::PileShadow pile_;
  sandglass::Cast cast_;
  Buffers buffers_;
  sandglass_room_light known_ = {}, light_ = {};  // now, and as it is drawn on its way there
  sandglass_camera_image screen_ = {};            // the last image that was shown; its planes are gone
  float origin_[3] = {};
  uint32_t pouring_ = 0;
  bool rests_ = false;
};

}  // namespace sample

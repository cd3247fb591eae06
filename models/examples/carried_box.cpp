// An open box is lifted with the sand in it, carried aside and put down: 4 ms a frame. It is told by poses alone, as ARKit,
// ARCore and WebXR give them, and drawn where it is held. The hand is made up; copy the rest.
#include <cmath>
#include <cstdio>
#include <vector>

#include "sandglass/sandglass.hpp"

constexpr float k_radius = 0.006f, k_half = 0.06f, k_high = 0.14f, k_wall = 2 * k_radius;  // metres
constexpr uint32_t k_parts = 5;                                                            // the bottom and four walls
// What a tracker tells: where the middle of the box's lower face is, and how far it is turned about the vertical.
struct Pose {
  float x, y, turn;
};
float eased(float t) { return t <= 0 ? 0 : t >= 1 ? 1 : t * t * (3 - 2 * t); }
Pose hand(float seconds) {  // up by 20 cm; aside by 30, turning; down
  const float aside = eased(seconds - 1);
  return {0.3f * aside, 0.2f * (eased(seconds) - eased(seconds - 2)), 0.8f * aside};
}

// `parts` where that pose puts them. Each has an id, by which it is recognised from frame to frame.
void place(const sandglass_collider parts[k_parts], const Pose& pose, sandglass_collider placed[k_parts]) {
  const sandglass::Rotation turn = sandglass::rotation_about(0, 1, 0, pose.turn);
  const float cosine = std::cos(pose.turn), sine = std::sin(pose.turn);
  for (uint32_t i = 0; i < k_parts; ++i) {
    placed[i] = parts[i];
    placed[i].id = i + 1;
    placed[i].position[0] = pose.x + cosine * parts[i].position[0] + sine * parts[i].position[2];
    placed[i].position[1] = pose.y + parts[i].position[1];
    placed[i].position[2] = cosine * parts[i].position[2] - sine * parts[i].position[0];
    for (size_t k = 0; k < 4; ++k) placed[i].rotation[k] = turn[k];
  }
}

int main() {
  const float in = k_half - k_radius, out = k_half + k_wall, thick = k_wall / 2, side = k_half + thick;
  const float up = k_wall + k_high / 2, low = k_wall + k_radius;
  const sandglass_collider parts[k_parts] = {
      sandglass::box(0, thick, 0, out, thick, out), sandglass::box(-side, up, 0, thick, k_high / 2, out),
      sandglass::box(side, up, 0, thick, k_high / 2, out), sandglass::box(0, up, -side, out, k_high / 2, thick),
      sandglass::box(0, up, side, out, k_high / 2, thick)};
  std::vector<float> particles;
  sandglass::Status status = sandglass::sample_lattice(
      {{-in, low, -in}, {in, low + 0.07f, in}}, 2 * k_radius, [](const float*) { return true; }, &particles);
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_radius = k_radius;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  sandglass::Scene scene;
  sandglass::Skin skin;
  if (status) status = scene.create(desc);
  if (status) status = skin.create(sandglass::skin_desc(desc.granular));
  if (status) status = scene.add(particles);
  sandglass_collider colliders[k_parts + 1], held[k_parts] = {};
  colliders[k_parts] = sandglass::floor_at(0);
  sandglass_frame_input input = sandglass::frame_input(1.0f / 60.0f, 4'000'000);
  input.colliders = colliders;
  input.collider_count = k_parts + 1;
  input.skin = skin.get();
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; status && frame < 270; ++frame) {
    place(parts, hand(input.time_step * static_cast<float>(frame - 30)), colliders);
    status = scene.frame(input, &report);
    for (uint32_t i = 0; status && i < k_parts; ++i) scene.held_collider(i, &held[i]);  // an app draws the box there
  }
  if (!status) std::fprintf(stderr, "%s: %s\n", status.name(), status.reason);
  particles.resize(3 * static_cast<size_t>(report.sand.particle_numbers));
  sandglass_scene_particles(scene.get(), particles.data(), nullptr);
  const float *at = held[0].position, *turn = held[0].rotation;  // of the bottom
  const float cosine = 1 - 2 * turn[1] * turn[1], sine = 2 * turn[1] * turn[3];
  uint32_t inside = 0;
  for (size_t i = 0; i < particles.size(); i += 3) {
    const float x = particles[i] - at[0], y = particles[i + 1] - at[1], z = particles[i + 2] - at[2];
    inside += y > 0 && std::fabs(cosine * x - sine * z) < k_half && std::fabs(sine * x + cosine * z) < k_half;
  }
  std::printf("%u of %u particles are in the box, %.2f m aside; %u vertices, level %s, time debt %.3f s\n", inside,
              report.sand.particles, static_cast<double>(at[0]), skin.mesh().vertex_count,
              sandglass_level_name(report.level), report.time.debt);
  return status ? 0 : 1;
}

// An app in augmented reality: from the camera's images the light of the room, in that light a ball of sand that falls
// beside a chair, and the soft shadow of the chair on the floor: 4 ms a frame. The phone is made up; copy the rest.
#include <cmath>
#include <cstdio>

#include "models/examples/made_up_phone.h"
#include "sandglass/sandglass.hpp"

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("usage: camera_app room.light chair.shadow last_frame.ppm\n", stderr), 2;
  // The light of the room. The file of its network must stay as long as the light.
  const MadeUpPhone::Asset network = MadeUpPhone::asset(argv[1]), baked = MadeUpPhone::asset(argv[2]);
  sandglass_light_desc light_desc = sandglass::light_desc();
  light_desc.asset = network.words.data(), light_desc.asset_bytes = network.bytes;
  sandglass::Light light;
  sandglass::Status status = light.create(light_desc);
  if (!status) return std::fprintf(stderr, "%s: %s\n", argv[1], status.reason), 1;

  // The shadow of the chair. Its file is needed until create returns.
  sandglass_shadow_desc shadow_desc = sandglass::shadow_desc();
  shadow_desc.asset = baked.words.data(), shadow_desc.asset_bytes = baked.bytes;
  sandglass_shadow_info chair{};
  sandglass::Shadow shadow;
  status = sandglass::inspect_shadow(shadow_desc.asset, shadow_desc.asset_bytes, &chair);
  if (status) status = shadow.create(shadow_desc);
  if (!status) return std::fprintf(stderr, "%s: %s\n", argv[2], status.reason), 1;

  // Sand: particles that collide, grains that are drawn.
  const float r = 0.01f, turn = 0.4f, x = chair.half_x + 0.3f, y = 0.25f, z = 0.1f;
  auto in_ball = [&](const float* p) { return std::hypot(p[0] - x, std::hypot(p[1] - y, p[2] - z)) < 0.1f; };
  const sandglass::Box box{{x - 0.1f, y - 0.1f, z - 0.1f}, {x + 0.1f, y + 0.1f, z + 0.1f}};
  std::vector<float> particles, grains;
  status = sandglass::sample_lattice(box, 2 * r, in_ball, &particles);
  if (status) status = sandglass::sample_volume(box, 0.7f * r, in_ball, &grains);
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_radius = r, desc.granular.collider_capacity = 2;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  sandglass::Scene scene;
  if (status) status = scene.create(desc);
  if (status) status = scene.add(particles, grains);

  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);  // stands for a mapped vertex buffer
  sandglass_collider colliders[] = {
      sandglass::floor_at(0.0f),  // the plane that ARCore or ARKit found, and the chair, turned about y
      sandglass::box(0, chair.height / 2, 0, chair.half_x, chair.height / 2, chair.half_z)};
  const float up[3] = {0, 1, 0};
  sandglass_rotation_about(up, turn, colliders[1].rotation);
  sandglass_shadow* const shadows[] = {shadow.get()};
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f, input.budget_ns = 4'000'000, input.colliders = colliders, input.collider_count = 2;
  input.grains = drawn.data(), input.grain_capacity = desc.granular.grain_capacity;
  input.shadows = shadows, input.shadow_count = 1, input.light = light.get();
  sandglass_frame_report report = sandglass::frame_report();
  sandglass_light_estimate now = light.estimated();  // until the first estimate: from above, and no shadow
  MadeUpPhone phone;
  for (int frame = 0; status && frame < 90; ++frame) {
    input.camera = phone.next_image();  // NULL where the camera, slower than the display, has no new one
    const float s = std::sin(turn), c = std::cos(turn), *d = now.direction;
    status = shadow.set_light({c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]});  // the light in the chair's frame
    if (status) status = scene.frame(input, &report);
    if (report.light_changed != 0) now = light.estimated();
    phone.draw(now, shadow.texture(), turn, drawn, r);  // the chair's mesh is the app's own
  }
  if (!status) return std::fprintf(stderr, "%s: %s\n", status.name(), status.reason), 1;
  std::printf("%u grains; last frame %.2f of 4 ms; light from (%.2f %.2f %.2f), contrast %.2f, %u estimates\n",
              report.grains, 1e-6 * static_cast<double>(report.elapsed_ns), now.direction[0], now.direction[1],
              now.direction[2], now.contrast, now.estimates);
  return phone.save(argv[3]) ? 0 : 1;
}

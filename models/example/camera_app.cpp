// What an AR app does with Sandglass, whole: a ball of sand falls beside a chair that stands on the real floor and
// casts its soft shadow there, in 4 ms of every frame. The camera's feed is made up and the GPU is a loop: copy the
// rest.
//   camera_app chair.shadow last_frame.ppm
#include <cmath>
#include <cstdio>
#include <fstream>

#include "models/example/made_up_phone.h"
#include "sandglass/sandglass.hpp"
#include "sandglass/shadow.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("usage: camera_app chair.shadow last_frame.ppm\n", stderr), 2;
  std::vector<uint64_t> asset(1 << 18);  // 8-byte words: a shadow's file must be so aligned
  std::ifstream file(argv[1], std::ios::binary);
  file.read(reinterpret_cast<char*>(asset.data()), static_cast<std::streamsize>(8 * asset.size()));

  // The chair's shadow; the file is needed until create returns.
  sandglass_shadow_desc shadow_desc;
  sandglass_shadow_desc_default(&shadow_desc);
  shadow_desc.asset = asset.data(), shadow_desc.asset_bytes = static_cast<uint64_t>(file.gcount());
  sandglass_shadow_info chair{};
  chair.struct_size = sizeof chair;
  uint64_t bytes = 0;
  sandglass::Status status;
  status.code = sandglass_shadow_inspect(shadow_desc.asset, shadow_desc.asset_bytes, &chair, &status.reason);
  if (status) status.code = sandglass_shadow_bytes(&shadow_desc, &bytes, &status.reason);
  if (!status) return std::fprintf(stderr, "%s: %s\n", argv[1], status.reason), 1;
  sandglass::Block shadow_block = sandglass::allocate_block(bytes);
  sandglass_shadow* shadow = nullptr;
  status.code = sandglass_shadow_create(&shadow_desc, shadow_block.get(), bytes, &shadow, &status.reason);

  // Sand: particles that collide, grains that are drawn.
  const float r = 0.01f, ball[3] = {chair.half_x + 0.3f, 0.25f, 0.1f};
  const sandglass::Box box{{ball[0] - 0.1f, 0.15f, 0.0f}, {ball[0] + 0.1f, 0.35f, 0.2f}};
  auto in_ball = [&](const float* p) {
    return std::hypot(p[0] - ball[0], std::hypot(p[1] - ball[1], p[2] - ball[2])) < 0.1f;
  };
  std::vector<float> particles, grains;
  if (status) status = sandglass::sample_lattice(box, 2 * r, in_ball, &particles);
  if (status) status = sandglass::sample_volume(box, 0.7f * r, in_ball, &grains);
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_radius = r;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  desc.granular.collider_capacity = 2;
  sandglass::Scene scene;
  if (status) status = scene.create(desc);
  if (status) status = scene.add(particles, grains);

  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);  // stands for a mapped vertex buffer
  const sandglass_collider colliders[] = {
      sandglass::floor_at(0.0f),  // the plane that ARCore or ARKit found, and the chair
      sandglass::box(0, chair.height / 2, 0, chair.half_x, chair.height / 2, chair.half_z)};
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f, input.budget_ns = 4'000'000;
  input.colliders = colliders, input.collider_count = 2;
  input.grains = drawn.data(), input.grain_stride = sizeof drawn[0],
  input.grain_capacity = desc.granular.grain_capacity;
  input.shadows = &shadow, input.shadow_count = 1;
  sandglass_frame_report report = sandglass::frame_report();
  MadeUpPhone phone;
  for (int frame = 0; status && frame < 90; ++frame) {
    phone.next_image();
    const float turn = 0.01f * static_cast<float>(frame), to_light[3] = {-std::cos(turn), 1.0f, std::sin(turn)};
    status.code = sandglass_shadow_set_light(shadow, 0, to_light, 1.0f, &status.reason);  // in the chair's own frame
    if (status) status = scene.frame(input, &report);
    sandglass_shadow_texture texture{};
    texture.struct_size = sizeof texture;
    sandglass_shadow_get_texture(shadow, 0, &texture);
    phone.draw(texture, drawn, r, to_light);  // the chair's mesh is the app's own
  }
  if (!status) return std::fprintf(stderr, "%s: %s\n", status.name(), status.reason), 1;
  std::printf("%u grains; last frame %.2f of 4 ms, quality '%s', %.3f s owed, shadow %u frames old\n", report.grains,
              1e-6 * static_cast<double>(report.elapsed_ns), sandglass_level_name(report.level), report.time_debt,
              report.shadow_age);
  return phone.save(argv[2]) ? 0 : 1;
}

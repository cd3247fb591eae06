// A wooden box falls onto sand in a tray. Half way the scene is saved, as when the app goes to the background, and
// restored into another scene. Both then run the same frames and end in the same state, to the bit.
#include <cinttypes>
#include <cstdio>
#include <vector>

#include "sandglass/sandglass.hpp"

constexpr float k_radius = 0.01f, k_wall = 0.12f;  // of a particle; from the tray's middle to its walls; metres

// A wall: a half space whose normal, local +y, is turned to the tray's middle.
sandglass_collider wall(float x, float z, const sandglass::Rotation& rotation) {
  sandglass_collider c = sandglass::collider(SANDGLASS_SHAPE_HALF_SPACE, x, 0, z);
  for (int k = 0; k < 4; ++k) c.rotation[k] = rotation[static_cast<size_t>(k)];
  return c;
}

sandglass::Status run(sandglass::Scene& scene, const sandglass::BoxBody& box, int frames) {
  const float quarter = 1.5707963f;
  sandglass_collider colliders[] = {sandglass::floor_at(0),
                                    wall(-k_wall, 0, sandglass::rotation_about(0, 0, 1, -quarter)),
                                    wall(k_wall, 0, sandglass::rotation_about(0, 0, 1, quarter)),
                                    wall(0, -k_wall, sandglass::rotation_about(1, 0, 0, quarter)),
                                    wall(0, k_wall, sandglass::rotation_about(1, 0, 0, -quarter)),
                                    {}};
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f;
  input.colliders = colliders;
  input.collider_count = 6;
  sandglass::Status status;
  for (int frame = 0; status && frame < frames; ++frame) {
    colliders[5] = box.collider(scene.body_pose(0));  // keeps the grains out; its pose is also that of the box's mesh
    status = scene.frame(input);
  }
  return status;
}

int main() {
  const auto everywhere = [](const float*) { return true; };
  std::vector<float> particles, grains;
  const float inside = k_wall - k_radius;
  const sandglass::Box bed{{-inside, k_radius, -inside}, {inside, 0.1f, inside}};
  sandglass::Status status = sandglass::sample_lattice(bed, 2 * k_radius, everywhere, &particles);
  if (status) status = sandglass::sample_volume(bed, k_radius, everywhere, &grains);
  sandglass::BoxBody box;  // 8 x 6 x 10 cm, half as dense as sand, tilted
  const sandglass::Rotation tilt = sandglass::rotation_about(1, 0, 1, 0.4f);
  if (status) status = sandglass::box_body({0.04f, 0.03f, 0.05f}, k_radius, {0, 0.25f, 0}, 0.5f, &box, tilt);

  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.granular.particle_radius = k_radius;
  desc.granular.body_capacity = 1;
  desc.granular.body_particle_capacity = box.body.particle_count;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3) + box.body.particle_count;
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  desc.granular.collider_capacity = 6;
  sandglass::Scene scene, later;
  std::vector<std::byte> saved;
  if (status) status = scene.create(desc);
  if (status) status = later.create(desc);
  if (status) status = scene.add(particles, grains);
  if (status) status = scene.add_body(box.body);
  if (status) status = run(scene, box, 60);
  if (status) status = scene.save(&saved);
  if (status) status = later.restore(saved);
  if (status) status = run(scene, box, 180);
  if (status) status = run(later, box, 180);
  if (!status) {
    std::fprintf(stderr, "bodies: %s: %s\n", status.name(), status.reason);
    return 1;
  }

  const sandglass_body_pose pose = scene.body_pose(0);
  std::printf("the box's middle ends %.3f m above the floor, moving at %.3f m/s; %zu bytes saved\n",
              static_cast<double>(pose.position[1]), static_cast<double>(pose.linear_velocity[1]), saved.size());
  std::printf("hash 0x%016" PRIx64 ", restored 0x%016" PRIx64 "\n", scene.hash(), later.hash());
}

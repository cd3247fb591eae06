#include "tests/laboratory/shot/shot_stage.h"

#include <algorithm>

#include "models/compositing/shot.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/panorama_file.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"

namespace sandglass::host {

constexpr uint32_t k_settling_frames = 75;  // 1.5 s: the knot has become a pile

ShotStage::ShotStage() : scene(load_scene("shot")) {
  // What is said of the chair is said of the chair alone.
  std::erase_if(scene.colliders, [](const ColliderTrack& track) { return track.casts; });
  const LoadedMeshes meshes(scene);
  const Material material = fill_scene(&scene, meshes.bodies());
  const CollisionFields fields(&scene);
  Simulation simulation(describe_filled(scene, material));
  simulation.add(material);
  for (uint32_t frame = 0; frame < k_settling_frames; ++frame)
    simulation.frame(scene.frame_step, UINT64_MAX, colliders_over_frame(scene, frame));
  particles = simulation.particle_positions();
  const std::vector<sandglass_collider> colliders = colliders_over_frame(scene, 0);
  const auto shape = [&] {
    return SandShaper().shape({particles, {}, colliders, static_cast<float>(scene.particle_radius)});
  };
  // The truth has no loose sand, so there is none.
  std::vector<bool> lone(particles.size() / 3);
  for (const sandglass_skin_loose& loose : shape().loose) lone[loose.number] = loose.weight > 0.5f;
  size_t left = 0;
  for (size_t i = 0; i < lone.size(); ++i)
    if (!lone[i]) std::copy_n(&particles[3 * i], 3, &particles[3 * left++]);
  particles.resize(3 * left);
  sand = shape();
  sand.loose.clear();
  sand.flying = 0;
  object = standing_object(scene);
}

SceneShadows ShotStage::shadows_for(const ShotLight& light) const {
  return complete_shadows(scene, SANDGLASS_ISA_AUTOMATIC, 0, colliders_over_frame(scene, 0), particles, light);
}

Surroundings ShotStage::captured(const std::string& file, double azimuth_deg) const {
  RadianceMap map = read_panorama(file);
  fill_tripod(&map);
  return panorama_surroundings(std::move(map), stem_of(file), *scene.camera, azimuth_deg, {}, k_object_insertion);
}

}  // namespace sandglass::host

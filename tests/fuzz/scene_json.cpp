// A scene file of any text: it is refused by a sentence, or it is small enough and describes a scene that the library
// takes or refuses.
#include "models/files/failure.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "tests/fuzz/edits.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  try {
    host::SceneFile scene = host::parse_scene(std::string(reinterpret_cast<const char*>(data), size), "x.json");
    for (const double time : {0.0, 0.5})
      for (const host::ColliderTrack& track : scene.colliders)
        (void)host::collider_over_frame(track, time, scene.frame_step);
    for (const host::ColliderTrack& track : scene.colliders)
      if (!track.profile.empty()) fuzz::expect(std::isfinite(host::revolved_distance(track.profile, {0.1, 0.1, 0.0})));
    if (scene.light) fuzz::expect(host::length(scene.light->towards(0.5)) < 1.001);
    (void)host::flow_over_frame(scene, 0.0);
    bool quick = true;
    uint64_t asked = 0;
    for (const host::Body& body : scene.bodies) {
      asked += uint64_t{body.particles} + body.grains + uint64_t{body.counts[0]} * body.counts[1] * body.counts[2];
      const bool by_size = body.particles == 0 && body.shape != host::BodyShape::lattice;
      quick = quick && body.grain_distance == 0.0 && !(by_size && body.size.y > 20 * scene.particle_radius) &&
              body.size.x <= 20 * body.size.y && body.size.z <= 20 * body.size.y;
    }
    if (!quick || asked > 300) return 0;
    const host::Material material = host::fill_scene(&scene, {});
    host::describe_scene(scene, material.particles(), material.grains());
  } catch (const host::Failure& failure) {
    fuzz::expect(std::strlen(failure.what()) > 0);
  }
  return 0;
}

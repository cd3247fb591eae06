// The scene of the studies, its sand asleep; the light is set view by view.
#pragma once

#include <memory>
#include <vector>

#include "models/compositing/shot_picture.h"
#include "models/mesh/mesh.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_shadows.h"

namespace sandglass::host {

struct ShotStage {
  SceneFile scene;
  std::vector<float> particles, grains;
  float grain_radius = 0.0f;
  LitObject object;

  ShotStage();

  enum class Sand { grains, particles };
  // The sand's shadow, complete, made of grains or of particles.
  std::unique_ptr<PileShadow> pile_for(Vec3 towards, Sand of) const;
  // All shadows, complete, as a frame has them.
  SceneShadows shadows_for(const ShotLight& light) const;
};

}  // namespace sandglass::host

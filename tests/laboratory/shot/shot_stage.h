// The scene of the study, its sand asleep; the light is set view by view.
#pragma once

#include <vector>

#include "models/compositing/shot_picture.h"
#include "models/mesh/mesh.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_shadows.h"

namespace sandglass::host {

struct ShotStage {
  SceneFile scene;
  std::vector<float> particles;
  SandShape sand;
  LitObject object;

  ShotStage();

  // All shadows, complete, as a frame has them.
  SceneShadows shadows_for(const ShotLight& light) const;
  // The room of a panorama's file, seen towards an azimuth.
  Surroundings captured(const std::string& file, double azimuth_deg) const;
};

}  // namespace sandglass::host

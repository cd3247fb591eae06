// The triangle meshes that a scene's bodies stand for: the generated trefoil knot, and the file of --mesh, read and
// judged.
#pragma once

#include <string>

#include "models/mesh/mesh.h"
#include "models/simulation/scene_fill.h"

namespace sandglass::host {

class LoadedMeshes {
 public:
  // A Failure for a mesh that cannot be read, for one whose inside is not defined, and for --mesh where no body asks
  // for it.
  LoadedMeshes(const SceneFile& scene, const std::string& mesh_path);
  LoadedMeshes(const LoadedMeshes&) = delete;
  LoadedMeshes& operator=(const LoadedMeshes&) = delete;

  const BodyMeshes& bodies() const { return bodies_; }
  const std::string& note() const { return note_; }  // about a mesh that is usable but not sound; else empty

 private:
  Mesh trefoil_, argument_;
  BodyMeshes bodies_;
  std::string note_;
};

}  // namespace sandglass::host

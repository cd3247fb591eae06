// The triangle meshes of a scene's bodies: the generated trefoil knot, and the file that --mesh names. The file is
// read, and meshes without an inside are refused.
#pragma once

#include <string>

#include "models/mesh/mesh.h"
#include "models/simulation/scene_fill.h"

namespace sandglass::host {

class LoadedMeshes {
 public:
  // Throws a Failure for a mesh that cannot be read, for a mesh without a defined inside, and for --mesh when no body
  // asks for it.
  LoadedMeshes(const SceneFile& scene, const std::string& mesh_path);
  LoadedMeshes(const LoadedMeshes&) = delete;
  LoadedMeshes& operator=(const LoadedMeshes&) = delete;

  const BodyMeshes& bodies() const { return bodies_; }
  // A sentence about a mesh that is usable but open; otherwise empty.
  const std::string& note() const { return note_; }

 private:
  Mesh trefoil_, argument_;
  BodyMeshes bodies_;
  std::string note_;
};

}  // namespace sandglass::host

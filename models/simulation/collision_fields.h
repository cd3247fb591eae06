// Builds the signed-distance fields of a scene's revolved and mesh colliders.
#pragma once

#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/simulation/scene_file.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

// Scales a mesh to `height` and puts the middle of its base at the origin. A collider of shape "mesh" stands like this.
// `name` is what the Failure about a flat mesh calls it.
void stand_mesh(Mesh* mesh, double height, const std::string& name);

class CollisionFields {
 public:
  // Builds the fields and sets them in the scene's collider tracks. They stay valid as long as this object.
  // `mesh_path` is the file of --collider-mesh, or empty. A Failure names what is missing or cannot be built.
  CollisionFields(SceneFile* scene, const std::string& mesh_path);

  // The mesh that a field was made of, or the turned outline; null for a field that is not of this scene.
  const Mesh* mesh_of(const sandglass_field* field) const;

 private:
  std::vector<cpp::Field> fields_;
  std::vector<Mesh> meshes_;  // of the same index
};

}  // namespace sandglass::host

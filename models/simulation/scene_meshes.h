// The triangle meshes of a scene: those that its bodies fill (the generated trefoil knot, and the file that --mesh
// names), and the signed-distance fields of its revolved and mesh colliders.
#pragma once

#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

class LoadedMeshes {
 public:
  // Throws a Failure for a mesh that cannot be read, for a mesh without a defined inside, and for --mesh when no body
  // asks for it.
  LoadedMeshes(const SceneFile& scene, const MeshFile& mesh = {});
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

// Scales a mesh to `height` and puts the middle of its base at the origin. A collider of shape "mesh" stands like this.
// `name` is what the Failure about a flat mesh calls it.
void stand_mesh(Mesh* mesh, double height, const std::string& name);

// How the field of a standing mesh is made.
struct FieldPlan {
  sandglass_inside_rule rule = SANDGLASS_INSIDE_PARITY;
  sandglass_solid solid = SANDGLASS_SOLID_INSIDE;
  cpp::Box box;
  float spacing = 0.0f, band = 0.0f;  // metres
};

class CollisionFields {
 public:
  // Builds the fields and sets them in the scene's collider tracks. They stay valid as long as this object.
  // `mesh` is the file of --collider-mesh, or empty. A Failure names what is missing or cannot be built.
  CollisionFields(SceneFile* scene, const MeshFile& mesh = {});

  // The mesh that a field was made of, or the turned outline; null for a field that is not of this scene.
  const Mesh* mesh_of(const sandglass_field* field) const;
  // How it was made of that mesh; null for the field of an outline too.
  const FieldPlan* plan_of(const sandglass_field* field) const;

 private:
  std::vector<cpp::Field> fields_;
  std::vector<Mesh> meshes_;      // of the same index
  std::vector<FieldPlan> plans_;  // of the same index
};

}  // namespace sandglass::host

// A closed surface is filled by ray parity, an open one by winding number. A surface that is not closed and has edges
// of three or more triangles is refused: neither rule says what is inside it.
#include "models/simulation/body_meshes.h"

#include <algorithm>

#include "models/files/failure.h"
#include "models/mesh/generated.h"

namespace sandglass::host {

static sandglass_mesh view_of(const Mesh& mesh) {
  return {mesh.vertices.data(), mesh.vertex_count(), mesh.indices.data(), mesh.triangle_count()};
}

LoadedMeshes::LoadedMeshes(const SceneFile& scene, const std::string& mesh_path) {
  const auto asked_for = [&](BodyShape shape) {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.shape == shape; });
  };
  if (asked_for(BodyShape::trefoil)) {
    trefoil_ = make_trefoil();
    bodies_.trefoil = {view_of(trefoil_), SANDGLASS_INSIDE_PARITY};
  }
  if (mesh_path.empty()) return;
  if (!asked_for(BodyShape::mesh))
    throw cannot("use --mesh with", scene.source, "the scene has no body of shape \"mesh\"", "Leave --mesh out");
  MeshResult loaded = load_mesh(mesh_path);
  if (!loaded) throw Failure(loaded.error);
  const MeshReport& report = loaded.report;
  if (!report.watertight() && report.non_manifold_edges > 0)
    throw cannot("fill", mesh_path,
                 "it is not manifold: " + std::to_string(report.non_manifold_edges) +
                     " edges belong to three or more triangles, so it has no inside",
                 "Repair it");
  if (!report.watertight())
    note_ = "\"" + mesh_path + "\" is open (" + std::to_string(report.boundary_edges) +
            " boundary edges). It is filled where its winding number is at least one half.";
  argument_ = std::move(loaded.mesh);
  bodies_.argument = {view_of(argument_), report.watertight() ? SANDGLASS_INSIDE_PARITY : SANDGLASS_INSIDE_WINDING};
}

}  // namespace sandglass::host

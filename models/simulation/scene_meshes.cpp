// A surface is filled by winding number, or by parity where a closed one is not oriented. A surface that is not closed
// and has edges of three or more triangles is refused: neither rule says what is inside it. The field of a revolved outline samples
// its exact distance at every node. The field of a mesh comes from the library's own builder.
#include "models/simulation/scene_meshes.h"

#include <algorithm>

#include "models/files/failure.h"
#include "models/mesh/generated.h"

namespace sandglass::host {

LoadedMeshes::LoadedMeshes(const SceneFile& scene, const MeshFile& mesh) {
  const std::string& mesh_path = mesh.path;
  const auto asked_for = [&](BodyShape shape) {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.shape == shape; });
  };
  if (asked_for(BodyShape::trefoil)) {
    trefoil_ = make_trefoil();
    bodies_.trefoil = {trefoil_.view(), SANDGLASS_INSIDE_PARITY};
  }
  if (mesh_path.empty()) return;
  if (!asked_for(BodyShape::mesh))
    throw cannot("use --mesh with", scene.source, "the scene has no body of shape \"mesh\"", "Leave --mesh out");
  MeshResult loaded = load_mesh_for_command(mesh);
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
  bodies_.argument = {argument_.view(), inside_rule(report)};
}

namespace {

constexpr uint32_t k_around = 64;  // half planes of a drawn outline

void require(const SceneFile& scene, size_t index, const cpp::Status& status) {
  if (status) return;
  throw cannot("make the field of collider " + std::to_string(index) + " in", scene.source,
               status.reason != nullptr ? status.reason : status.name());
}

}  // namespace

void stand_mesh(Mesh* mesh, double height, const std::string& name) {
  std::vector<float>& vertices = mesh->vertices;
  const auto [low, high] = box_of(*mesh);
  if (!(high[1] > low[1]))
    throw cannot("stand", name, "the mesh is flat, and a collider needs a height", "Turn it: y is up");
  const float scale = static_cast<float>(height) / (high[1] - low[1]);
  const float middle[3] = {0.5f * (low[0] + high[0]), low[1], 0.5f * (low[2] + high[2])};
  for (size_t v = 0; v < vertices.size(); ++v) vertices[v] = (vertices[v] - middle[v % 3]) * scale;
}

CollisionFields::CollisionFields(SceneFile* scene, const MeshFile& mesh) {
  const std::string& mesh_path = mesh.path;
  const auto is_mesh = [](const ColliderTrack& track) {
    return track.shape == SANDGLASS_SHAPE_FIELD && track.profile.empty();
  };
  const bool wanted = std::any_of(scene->colliders.begin(), scene->colliders.end(), is_mesh);
  if (!wanted && !mesh_path.empty())
    throw cannot("use --collider-mesh with", scene->source, "the scene has no collider of shape \"mesh\"",
                 "Leave --collider-mesh out");
  MeshResult argument;
  if (!mesh_path.empty()) argument = load_mesh_for_command(mesh);
  const double radius = scene->particle_radius;
  for (size_t i = 0; i < scene->colliders.size(); ++i) {
    ColliderTrack& track = scene->colliders[i];
    if (track.shape != SANDGLASS_SHAPE_FIELD) continue;
    const double spacing = track.field_spacing > 0.0 ? track.field_spacing : radius;
    const double margin = std::max(3.0 * radius, 2.0 * spacing);
    const sandglass_solid solid = track.solid_outside ? SANDGLASS_SOLID_OUTSIDE : SANDGLASS_SOLID_INSIDE;
    const float step = static_cast<float>(spacing), beyond = static_cast<float>(margin);
    FieldPlan& plan = plans_.emplace_back();
    cpp::Box& box = plan.box;
    cpp::Field& field = fields_.emplace_back();
    Mesh& standing = meshes_.emplace_back();
    if (!track.profile.empty()) {
      const auto [r, bottom, top] = extent_of(track.profile);
      to_floats({-r - margin, bottom - margin, -r - margin}, box.min);
      to_floats({r + margin, top + margin, r + margin}, box.max);
      const double sign = track.solid_outside ? -1.0 : 1.0;
      standing = make_revolved(track.profile, k_around);
      require(*scene, i, field.from_function(box, step, solid, [&](const float* p) {
        return static_cast<float>(sign * revolved_distance(track.profile, from_floats(p)));
      }));
    } else {
      if (mesh_path.empty() && track.mesh.empty())
        throw cannot("read", scene->source, "collider " + std::to_string(i) + " is a mesh without a file",
                     "Name it with --collider-mesh FILE");
      const MeshResult loaded = mesh_path.empty() ? make_named(track.mesh) : argument;
      if (!loaded) throw Failure(loaded.error);
      standing = loaded.mesh;
      stand_mesh(&standing, track.size.y, mesh_path);
      const sandglass_mesh view = standing.view();
      require(*scene, i, cpp::call(sandglass_mesh_bounds, &view, box.min, box.max));
      for (int k = 0; k < 3; ++k) {
        box.min[k] -= beyond;
        box.max[k] += beyond;
      }
      plan.rule = inside_rule(loaded.report);
      plan.solid = solid;
      plan.spacing = step;
      plan.band = static_cast<float>(2.0 * radius);
      cpp::MeshInside inside;
      require(*scene, i, inside.create(view, plan.rule));
      require(*scene, i, field.from_mesh(view, inside, box, step, plan.band, solid));
    }
    track.field = field.get();
  }
}

const Mesh* CollisionFields::mesh_of(const sandglass_field* field) const {
  for (size_t i = 0; i < fields_.size(); ++i)
    if (fields_[i].get() == field) return &meshes_[i];
  return nullptr;
}

const FieldPlan* CollisionFields::plan_of(const sandglass_field* field) const {
  for (size_t i = 0; i < fields_.size(); ++i)
    if (fields_[i].get() == field) return plans_[i].spacing > 0.0f ? &plans_[i] : nullptr;
  return nullptr;
}

}  // namespace sandglass::host

// Writes a scene for JavaScript: web_scene NAME FILE [--counted]. The file is JSON and holds what a scene file leads to: the
// description, the sand as it was sampled, colliders, emitters, and the meshes whose fields the module makes itself.
// Arrays are base64 of little-endian numbers. models/page/scene.mjs reads it. Only what stands still can be written.
// With --counted it also holds the NEON instructions that its frames take, and the cores that a device may be compared
// with.
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/json.h"
#include "models/phones/phone.h"
#include "models/report/report_page.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/simulation.h"
#include "platform/virtual_clock.h"

namespace sandglass::host {
namespace {

template <class T>
std::string packed(const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
  return base64(std::vector<uint8_t>(bytes, bytes + values.size() * sizeof(T)));
}

Json granular(const sandglass_granular_desc& g) {
  return {{"particle_capacity", g.particle_capacity},
          {"grain_capacity", g.grain_capacity},
          {"emitter_capacity", g.emitter_capacity},
          {"collider_capacity", g.collider_capacity},
          {"particle_radius", g.particle_radius},
          {"grain_radius", g.grain_radius},
          {"static_friction", g.static_friction},
          {"kinetic_friction", g.kinetic_friction},
          {"height_weighting", g.height_weighting},
          {"courant", g.courant},
          {"substep_max", g.substep_max},
          {"substep_min", g.substep_min},
          {"list_margin", g.list_margin},
          {"sleep_after", g.sleep_after},
          {"refine_step", g.refine_step}};
}

Json collider(const ColliderTrack& track, const CollisionFields& fields, const std::string& source) {
  if (!track.motion.empty() || !track.profile.empty())
    throw cannot("write for the web", source, "a collider moves or is a surface of revolution",
                 "Take a scene whose colliders stand still");
  const sandglass_collider c = collider_over_frame(track, 0.0, 0.0);
  Json out = {{"shape", c.shape}, {"position", c.position}, {"rotation", c.rotation}, {"size", c.size}};
  if (const Mesh* mesh = fields.mesh_of(c.field)) {
    const FieldPlan& plan = *fields.plan_of(c.field);
    out["field"] = {{"vertices", packed(mesh->vertices)},
                    {"indices", packed(mesh->indices)},
                    {"rule", plan.rule},
                    {"solid", plan.solid},
                    {"low", plan.box.min},
                    {"high", plan.box.max},
                    {"spacing", plan.spacing},
                    {"band", plan.band}};
  }
  return out;
}

Json emitter(const EmitterTrack& track) {
  const sandglass_emitter& e = track.emitter;
  return {{"start", track.start},
          {"end", track.end},
          {"position", e.position},
          {"rotation", e.rotation},
          {"radius", e.radius},
          {"speed", e.speed},
          {"grains_per_particle", e.grains_per_particle}};
}

// All frames with all their work, charged as models/phones says.
Json counted(const SceneFile& scene, const Material& material) {
  PhoneClock clock(phone_cores().front());
  sandglass_scene_desc desc = describe_filled(scene, material);
  desc.clock = clock.clock();
  Simulation simulation(desc);
  clock.follow(simulation.handle());
  simulation.add(material);
  double ms = 0.0;
  for (uint32_t frame = 0; frame < scene.frames; ++frame) {
    simulation.flow(flow_over_frame(scene, frame * scene.frame_step));
    const auto report = simulation.frame(scene.frame_step, UINT64_MAX, colliders_over_frame(scene, frame));
    ms += 1e-6 * static_cast<double>(report.time.elapsed_ns);
  }
  Json cores = Json::array();
  for (const PhoneCore& core : phone_cores())
    cores.push_back({{"name", core.name}, {"low", core.ghz * core.ipc_low}, {"high", core.ghz * core.ipc_high}});
  return {{"instructions", ms * clock.core().middle_ipc() * clock.core().ghz * 1e6}, {"cores", cores}};
}

Json web_scene(const std::string& name, bool with_counts) {
  SceneFile scene = load_scene(name);
  const LoadedMeshes meshes(scene);
  const Material material = fill_scene(&scene, meshes.bodies());
  if (!material.rigid.empty() || !scene.sinks.empty())
    throw cannot("write for the web", scene.source, "it has rigid bodies or sinks", "Take a scene of sand alone");
  const CollisionFields fields(&scene);
  const sandglass_scene_desc desc = describe_filled(scene, material);
  Json colliders = Json::array(), emitters = Json::array();
  for (const ColliderTrack& track : scene.colliders) colliders.push_back(collider(track, fields, scene.source));
  for (const EmitterTrack& track : scene.emitters) emitters.push_back(emitter(track));
  Json out = {{"name", scene.name},
              {"frames", scene.frames},
              {"gravity", desc.gravity},
              {"frame_step", scene.frame_step},
              {"budget_ms", scene.budget_ms},
              {"virtual_step_ns", k_virtual_step_ns},
              {"granular", granular(desc.granular)},
              {"particles", packed(material.particle_positions)},
              {"particle_velocities", packed(material.particle_velocities)},
              {"grains", packed(material.grain_positions)},
              {"grain_velocities", packed(material.grain_velocities)},
              {"colliders", colliders},
              {"emitters", emitters}};
  if (with_counts) out["counted"] = counted(scene, material);
  return out;
}

}  // namespace
}  // namespace sandglass::host

int main(int count, char** arguments) try {
  const bool with_counts = count == 4 && std::string_view(arguments[3]) == "--counted";
  if (count != 3 && !with_counts) {
    std::fprintf(stderr, "web_scene NAME FILE [--counted]: a scene, and where it is written\n");
    return 2;
  }
  const std::string text = sandglass::host::text_of(sandglass::host::web_scene(arguments[1], with_counts));
  sandglass::host::write_file(arguments[2], std::string_view(text));
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "web_scene: %s\n", failure.what());
  return 2;
}

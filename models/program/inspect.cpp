// `sandglass inspect FILE`: says what a file is, by its content. It is a recording, a baked shadow, a lighting network,
// a scene, a picture, a panorama or a mesh.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/picture_head.h"
#include "models/mesh/readers.h"
#include "models/program/commands.h"
#include "models/rooms/panorama_file.h"
#include "models/simulation/recording.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"
#include "runtime/asset/light_asset.h"
#include "sandglass/estimator.h"
#include "sandglass/shadow.h"

namespace sandglass::host {

namespace {

struct InspectOptions {
  std::string file;
  MeshOptions as_mesh;
};

Options options_of(InspectOptions& o) {
  return {
      required({"FILE", &o.file, "", "The file, or the name of a shipped scene"}),
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
  };
}

constexpr char k_recording_magic[] = "SGREC";   // the first bytes of models/simulation/recording.h's format
constexpr char k_shadow_identifier[] = "SGSH";  // bytes 4..7 of a file by runtime/asset/shadow.fbs
constexpr char k_light_identifier[] = "SGLN";   // bytes 4..7 of a file by runtime/asset/light.fbs
constexpr char k_exr_magic[] = "\x76\x2f\x31\x01";

void inspect_recording(const std::string& path, const std::string&) {
  const Recording recording = load_recording(path);
  double seconds = 0.0;
  size_t colliders = 0;
  uint64_t units = 0;
  for (const RecordedFrame& frame : recording.frames) {
    seconds += static_cast<double>(frame.time_step);
    colliders = std::max(colliders, frame.colliders.size());
    for (uint32_t run = 0; run < std::min<uint32_t>(frame.plan.run_count, SANDGLASS_PLAN_RUNS); ++run)
      units += frame.plan.runs[run].units;
  }
  std::printf("recording of scene '%s'\n  frames       %zu (%.3f s asked for)\n", recording.scene_name.c_str(),
              recording.frames.size(), seconds);
  std::printf("  work units   %llu\n  colliders    %zu at most\n", static_cast<unsigned long long>(units), colliders);
  std::printf("  start hash   0x%016llx\n  final hash   0x%016llx\n",
              static_cast<unsigned long long>(recording.start_hash),
              static_cast<unsigned long long>(recording.final_hash));
}

void inspect_shadow_file(const std::string& path, const std::string& content) {
  const AlignedBytes file(content);
  const sandglass_shadow_info info = inspect_shadow(file, path);
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.asset = file.data();
  desc.asset_bytes = file.size();
  uint64_t memory = 0;
  const char* reason = nullptr;
  if (sandglass_shadow_bytes(&desc, &memory, &reason) != SANDGLASS_OK) throw cannot("read", path, reason);
  const auto degrees = [](float radians) { return static_cast<double>(radians) * 180 / 3.14159265358979; };
  std::printf("baked shadow, version %u\n  network      %u neurons x (1 + %u) hidden layers, %llu MAC a texel\n",
              info.version, info.width, info.layers, static_cast<unsigned long long>(info.macs_per_texel));
  std::printf("  box          %g x %g x %g m, on the plane at [%g, %g, %g]\n", 2 * info.half_x, info.height,
              2 * info.half_z, info.origin[0], info.origin[1], info.origin[2]);
  std::printf("  light        %.3g degrees wide, up to %.3g degrees from the zenith\n", degrees(info.angular_diameter),
              degrees(info.polar_max));
  std::printf("  plane        %s\n", info.plane_fitted != 0 ? "fitted to the light" : "one square for all lights");
  std::printf("  RMSE         %.4f float, %.4f int8, over %u unseen lights\n", info.rmse_float, info.rmse_int8,
              info.validated_lights);
  if (info.ambient_texels > 0)
    std::printf("  ambient      %u components of %u x %u texels, %g m a side, RMSE %.4f in made-up rooms\n",
                info.ambient_components, info.ambient_texels, info.ambient_texels, 2 * info.ambient_half,
                info.ambient_rmse);
  else std::printf("  ambient      none: it was baked without\n");
  std::printf("  surface      %u points\n", info.surface_vertices);
  std::printf("  float copy   %s\n  memory       %llu bytes\n", info.float_parameters > 0 ? "yes" : "no",
              static_cast<unsigned long long>(memory));
}

void inspect_light(const std::string& path, const std::string& content) {
  const AlignedBytes file(content);
  LightAsset asset;
  const char* reason = nullptr;
  if (open_light_asset(file.data(), file.size(), &asset, &reason) != SANDGLASS_OK) throw cannot("read", path, reason);
  sandglass_estimator_desc desc;
  sandglass_estimator_desc_default(&desc);
  desc.asset = file.data();
  desc.asset_bytes = file.size();
  uint64_t memory = 0;
  if (sandglass_estimator_bytes(&desc, &memory, &reason) != SANDGLASS_OK) throw cannot("read", path, reason);
  std::printf("lighting network '%s', version %u\n  trained on   %u images, calibrated on %u\n", asset.name,
              k_light_asset_version, asset.training_images, asset.calibration_images);
  std::printf("  int8         %.2f degrees and %.4f of a colour from float, medians\n", asset.angle_deg,
              asset.difference);
  std::printf("  float copy   %s\n  memory       %llu bytes\n", asset.float_parameters != nullptr ? "yes" : "no",
              static_cast<unsigned long long>(memory));
}

void inspect_scene(const std::string& path) {
  SceneFile scene = load_scene(path);
  const bool needs_mesh =
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& b) { return b.shape == BodyShape::mesh; });
  std::printf("scene '%s'\n  frames       %u of %g ms, budget %g ms\n  bodies       %zu, colliders %zu\n",
              scene.name.c_str(), scene.frames, scene.frame_step * 1e3, scene.budget_ms, scene.bodies.size(),
              scene.colliders.size());
  uint32_t particles = 0, grains = 0;
  if (needs_mesh) {
    for (const Body& body : scene.bodies) {
      particles += body.particles;
      grains += body.grains;
    }
    std::printf("  filled with  a mesh file that `run --mesh` names; the counts below are the wanted ones\n");
  } else {
    const LoadedMeshes meshes(scene);
    const Material material = fill_scene(&scene, meshes.bodies());
    particles = material.particles();
    grains = material.grains();
  }
  std::printf("  particles    %u of radius %g m\n  grains       %u\n  friction     %g static, %g kinetic\n", particles,
              scene.particle_radius, grains, scene.granular.static_friction, scene.granular.kinetic_friction);
  if (scene.particle_radius == 0.0) return;
  Simulation simulation(describe_scene(scene, particles, grains));
  std::printf("  memory       %llu bytes\n", static_cast<unsigned long long>(simulation.bytes()));
  std::vector<sandglass_region> regions(sandglass_scene_regions(simulation.handle(), nullptr, 0));
  regions.resize(std::min<size_t>(regions.size(), sandglass_scene_regions(simulation.handle(), regions.data(),
                                                                          static_cast<uint32_t>(regions.size()))));
  for (const sandglass_region& region : regions)
    std::printf("    %-30s %12llu\n", region.name, static_cast<unsigned long long>(region.bytes));
}

void inspect_picture(const std::string& path, const std::string&) {
  const Picture picture = read_picture(path);
  std::printf("picture, %d x %d pixels\n", picture.width, picture.height);
}

void inspect_panorama(const std::string& path, const std::string&) {
  const RadianceMap map = read_panorama(path);
  std::printf("panorama, %d x %d pixels\n  brightest    %.4g\n", map.width, map.height, greatest_luminance(map));
}

void inspect_mesh(const MeshFile& file) {
  const MeshResult loaded = load_mesh(file);
  if (!loaded) throw Failure(loaded.error);
  const Mesh& mesh = loaded.mesh;
  const MeshBox box = box_of(mesh);
  const auto& [low, high] = box;
  const double volume = signed_volume(mesh);
  const std::string faults = describe_faults(loaded.report);
  std::printf("mesh\n  vertices     %u\n  triangles    %u\n", mesh.vertex_count(), mesh.triangle_count());
  std::printf("  parts        %u\n  size         %g x %g (up) x %g m\n", loaded.report.parts, box.size(0), box.size(1),
              box.size(2));
  std::printf("  bounds       [%g, %g, %g] to [%g, %g, %g]\n", low[0], low[1], low[2], high[0], high[1], high[2]);
  std::printf("  watertight   %s\n  manifold     %s\n", loaded.report.watertight() ? "yes" : "no",
              loaded.report.manifold() ? "yes" : "no");
  std::printf("  orientation  %s\n  volume       %g\n",
              loaded.report.inconsistent_edges > 0 ? "inconsistent"
              : volume >= 0.0                      ? "outward"
                                                   : "inward",
              volume);
  if (!faults.empty()) std::printf("  faults       %s\n", faults.c_str());
  for (const std::string& remark : loaded.remarks) std::printf("  note         %s\n", remark.c_str());
}

}  // namespace

// What the program reads of such a file elsewhere, by its first bytes.
static uint64_t limit_of(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return k_file_limit;  // read_file refuses it
  char head[8] = {};
  std::ifstream(file, std::ios::binary).read(head, sizeof head);
  const std::string_view identifier(head + 4, 4);
  if (identifier == k_shadow_identifier || identifier == k_light_identifier) return k_asset_limit;
  return k_file_limit;
}

static int run(const InspectOptions& options) {
  const std::string& file = options.file;
  std::error_code error;
  const bool is_file = std::filesystem::exists(file, error);
  const std::string content = is_file ? read_file(file, "file", limit_of(file)) : "";
  if (is_file && content.empty()) throw cannot("inspect", file, "the file is empty", "Name another");
  const auto has_identifier = [&](const char* name) { return content.size() > 8 && content.compare(4, 4, name) == 0; };
  const PictureHead::Kind picture = picture_head(content).kind;
  const MeshKind mesh = mesh_kind(content);
  const size_t first = content.find_first_not_of(" \t\r\n");
  const bool is_text_of_braces = first != std::string::npos && content[first] == '{';
  const bool is_scene = !is_file || (is_text_of_braces && mesh.format == nullptr);
  void (*of_kind)(const std::string& file, const std::string& content) = nullptr;
  if (content.starts_with(k_recording_magic)) of_kind = inspect_recording;
  else if (has_identifier(k_shadow_identifier)) of_kind = inspect_shadow_file;
  else if (has_identifier(k_light_identifier)) of_kind = inspect_light;
  else if (picture == PictureHead::Kind::png || picture == PictureHead::Kind::jpeg) of_kind = inspect_picture;
  else if (content.starts_with("#?") || content.starts_with(k_exr_magic)) of_kind = inspect_panorama;
  else if (picture == PictureHead::Kind::other && mesh.format == nullptr) of_kind = inspect_picture;
  if (of_kind != nullptr) of_kind(file, content);
  else if (is_scene) inspect_scene(file);
  else if (mesh.format != nullptr) inspect_mesh({file, options.as_mesh.units()});
  else
    throw cannot("inspect", file,
                 "it " + mesh.is_instead + ", and no recording, shadow, lighting network, scene, picture or panorama",
                 "Name one of those; export meshes as " + offered_formats());
  return k_exit_done;
}

Command inspect_command() {
  return command<InspectOptions>(
      "inspect", "Say what a file is: a recording, a shadow, a lighting network, a scene, a picture or a mesh",
      options_of, run);
}

}  // namespace sandglass::host

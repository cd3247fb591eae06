// `sandglass run` and how it starts: the scene, what the options change in it, and everything that its frames need. At
// its end it prints the hash of the final state.
#include <algorithm>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/program/run.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

// The virtual clock advances by this much at every reading, and the library reads it once or twice a work unit. So a
// plan depends only on the scene and the budget.
constexpr uint64_t k_virtual_step_ns = 5'000;

}  // namespace

Run::Run(const RunOptions& options) : options_(options), scene_(load_scene(options.scene)) {
  if (options_.frames > 0) scene_.frames = options_.frames;
  if (options_.budget_ms >= 0.0) scene_.budget_ms = options_.budget_ms;
  const sandglass_isa isa = find_isa(options_.isa);
  load_replay();
  for (const std::string& folder : {options_.out, options_.dump})
    if (!folder.empty()) make_folder(folder);
  replace_shadow();
  take_shot();
  const LoadedMeshes meshes(scene_, options_.mesh);
  if (!meshes.note().empty()) std::fprintf(stderr, "sandglass: note: %s\n", meshes.note().c_str());
  const Material material = fill_scene(&scene_, meshes.bodies());
  fields_.emplace(&scene_, options_.collider_mesh);
  simulation_.emplace(describe(material, isa));
  simulation_->add(material);
  shadows_.emplace(scene_, isa);
  if (scene_.pile_shadow) {
    pile_.emplace(*scene_.pile_shadow, isa);
    simulation_->cast(pile_->handle());
  }
  begin_report();
  if (!options_.out.empty()) {
    std::vector<sandglass_collider> colliders = colliders_over_frame(scene_, 0);
    add_rigid_shapes(scene_, simulation_->handle(), 0.0, &colliders);
    take_snapshot(0, std::move(colliders));
  }
  expect_start(sandglass_scene_hash(simulation_->handle()));
}

void Run::load_replay() {
  if (options_.replay.empty()) return;
  recording_ = load_recording(options_.replay);
  if (recording_.frames.empty())
    throw cannot("replay", options_.replay, "the recording holds no frame", "Record the run again");
  const size_t frames = recording_.frames.size();
  scene_.frames = static_cast<uint32_t>(options_.frames > 0 ? std::min<size_t>(options_.frames, frames) : frames);
}

void Run::expect_start(uint64_t start_hash) {
  if (options_.replay.empty()) {
    recording_.scene_name = scene_.name;
    recording_.start_hash = start_hash;
  } else if (recording_.start_hash != start_hash) {
    throw cannot("replay", options_.replay,
                 "it was recorded from scene \"" + recording_.scene_name + "\" in another state than scene \"" +
                     scene_.name + "\" starts in",
                 "Name that scene and the same --mesh");
  }
}

void Run::replace_shadow() {
  if (options_.asset.empty()) return;
  const auto standing = std::find_if(scene_.colliders.begin(), scene_.colliders.end(),
                                     [](const ColliderTrack& track) { return !track.shadow.empty(); });
  if (standing == scene_.colliders.end())
    throw cannot("use --asset with", scene_.source, "the scene has no object with a baked shadow", "Leave --asset out");
  standing->shadow = options_.asset;
}

void Run::take_shot() {
  const bool asked =
      !options_.panorama.empty() || !options_.photo.empty() || !options_.light.empty() || !options_.network.empty();
  if (!scene_.shot && asked)
    throw cannot("use --panorama, --photo, --light or --network with", scene_.source, "the scene is no shot",
                 "Leave them out, or run a shot, such as \"shot\"");
  if (!scene_.shot) return;
  if (!options_.network.empty() && !options_.light.empty() && options_.light != name_of(LightSource::estimate))
    throw Failure("cannot use \"--network\" with \"--light " + options_.light +
                  "\": a network estimates the light. Leave one of them out.");
  if (!options_.collider_mesh.empty() && options_.asset.empty())
    throw Failure(
        "cannot use \"--object\" without \"--asset\": the object needs its own shadow. Bake it with sandglass bake and "
        "name it with --asset.");
  ShotOptions o;
  o.panorama = options_.panorama, o.photo = options_.photo, o.photo_fov_deg = options_.fov_deg;
  o.mesh = options_.collider_mesh, o.folder = options_.out, o.threads = drawing_threads();
  for (const LightSource source : {LightSource::labels, LightSource::estimate, LightSource::arbitrary})
    if (options_.light == name_of(source)) o.light = source;
  o.network = options_.network, o.isa = find_isa(options_.isa);
  shot_.emplace(scene_, o);
}

sandglass_scene_desc Run::describe(const Material& material, sandglass_isa isa) {
  sandglass_scene_desc desc = describe_filled(scene_, material);
  desc.isa = isa;
  if (options_.clock == "virtual") {
    virtual_time_.step_ns = k_virtual_step_ns;
    desc.clock = virtual_clock(&virtual_time_);
  } else {
    desc.clock = sandglass_clock_system();
  }
  pool_.emplace(options_.threads);
  desc.parallel = pool_->hook();
  if (!options_.out.empty()) desc.trace = recorder_.hook();
  return desc;
}

void Run::begin_report() {
  report_.scene = scene_.name;
  report_.isa = sandglass_isa_name(sandglass_scene_isa(simulation_->handle()));
  if (!shadows_->handles().empty()) {
    const std::string of_bytes = sandglass_isa_name(sandglass_shadow_isa(shadows_->handles()[0]));
    if (of_bytes != report_.isa) report_.isa += ", shadows " + of_bytes;
  }
  report_.clock = options_.replay.empty() ? options_.clock : "replay";
  report_.light = shot_ ? name_of(shot_->source()) : scene_.light ? "scene's light" : "";
  report_.threads = options_.threads;
  report_.memory_bytes = simulation_->bytes();
}

int run_command(const RunOptions& options) {
  listen_for_interrupt();
  Run run(options);
  run.execute();
  const uint64_t hash = run.hash();
  run.finish(hash);
  const int exit_code = run.exit_code(hash);
  std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
  return exit_code;
}

}  // namespace sandglass::host

// `sandglass run`: how it starts (the scene, what the options change in it, and everything that its frames need), and
// its frames. It ends with the hash of the final state.
#include "models/program/run.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "models/files/failure.h"
#include "models/work/progress.h"
#include "platform/clock.h"

namespace sandglass::host {

namespace {

constexpr const char* k_collider_mesh = "Mesh of the scene's colliders of shape \"mesh\"";

Options options_of(RunOptions& o) {
  return {
      required({"SCENE", &o.scene, "", k_scene_argument}),
      {"--mesh", &o.mesh, "FILE", k_body_mesh},
      {"--object,--collider-mesh", &o.collider_mesh, "FILE", k_collider_mesh},
      scale_option(o.as_mesh),
      up_option(o.as_mesh),
      standard(k_scene, {"--asset", &o.asset, "FILE", "Baked shadow of that object"}),
      standard(k_scene, {"--frames", &o.frames, "N", "Frames to run", whole_number(1, 100'000'000)}),
      standard(k_scene, {"--budget-ms", &o.budget_ms, "MS", "Budget of a frame, ms", number(0, 1e6)}),
      {"--panorama", &o.panorama, "FILE", "For a shot: the room, .hdr or .exr"},
      needs("--panorama",
            {"--later", &o.later, "FILE", "That room from the middle of the run on: a lamp is switched off"}),
      needs("--fov", excludes("--panorama",
                              {"--photo", &o.photo, "FILE", "For a shot: a photograph behind the scene, PNG or JPEG"})),
      needs("--photo", standard("", {"--fov", &o.fov_deg, "DEGREES",
                                     "Field of view of --photo across the diagonal, degrees", number(5, 150)})),
      {"--light", &o.light, "KIND",
       "For a shot: the room as a session sees it, the truth, one light by the network, or nothing known",
       one_of({"room", "truth", "estimate", "nothing"})},
      threads_option(o.threads),
      isa_option(o.isa),
      {"--clock", &o.clock, "KIND",
       "Clock of the budget; virtual adds 5 microseconds a reading: equal plans everywhere",
       one_of({"real", "virtual"})},
      excludes("--clock",
               standard("", {"--as", &o.as, "CORE", "Estimate the times of a phone's core from counted instructions",
                             one_of(phone_core_names())})),
      fills_partly({"--out", &o.out, "FOLDER", "Write reports, contact sheet, frames and film into this new folder"}),
      writes({"--record", &o.record, "FILE", "Write what every frame was given and did to this file"}),
      excludes("--record", {"--replay", &o.replay, "FILE", "Repeat the run of such a file, to the bit"}),
  };
}

// The positions, of removed particles not a number.
std::vector<float> present(std::vector<float> positions) {
  for (size_t i = 0; i < positions.size(); i += 3)
    if (positions[i + 1] == SANDGLASS_REMOVED_Y) std::fill_n(&positions[i], 3, std::numeric_limits<float>::quiet_NaN());
  return positions;
}

}  // namespace

Run::Run(const RunOptions& options, uint32_t finest_level)
    : options_(options), finest_level_(finest_level), scene_(load_scene(options.scene)) {
  if (options_.frames > 0) scene_.frames = options_.frames;
  if (options_.budget_ms >= 0.0) scene_.budget_ms = options_.budget_ms;
  const sandglass_isa isa = find_isa(options_.isa);
  load_replay();
  replace_shadow();
  take_shot();
  const LoadedMeshes meshes(scene_, {options_.mesh, options_.as_mesh.units()});
  if (!meshes.note().empty()) std::fprintf(stderr, "sandglass: note: %s\n", meshes.note().c_str());
  const Material material = fill_scene(&scene_, meshes.bodies());
  fields_.emplace(&scene_, MeshFile(options_.collider_mesh, options_.as_mesh.units()));
  simulation_.emplace(describe(material, isa));
  if (phone_) phone_->follow(simulation_->handle());
  simulation_->add(material);
  shadows_.emplace(scene_, isa);
  if (scene_.pile_shadow) {
    for (std::optional<PileShadow>* pile : {&pile_, &drawn_pile_})
      pile->emplace(*scene_.pile_shadow, isa, scene_.shot ? scene_.pile_shadow->texels / 2 : 0);
    simulation_->cast(pile_->handle());
  }
  begin_report();
  if (!options_.out.empty()) {
    std::vector<sandglass_collider> colliders = colliders_over_frame(scene_, 0);
    add_rigid_shapes(scene_, simulation_->handle(), 0.0, &colliders);
    if (shot_) {
      // An app shows an object when its shadow is there.
      light_shadows(0);
      shadows_->complete();
    }
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
  if (options_.frames > frames)
    throw cannot("replay", options_.replay, "it holds " + std::to_string(frames) + " frames",
                 "Ask for no more by --frames");
  if (recording_.scene_name != scene_.name) throw of_another_scene();
  scene_.frames = static_cast<uint32_t>(options_.frames > 0 ? options_.frames : frames);
}

void Run::expect_start(uint64_t start_hash) {
  if (options_.replay.empty()) {
    recording_.scene_name = scene_.name;
    recording_.start_hash = start_hash;
  } else if (recording_.start_hash != start_hash) {
    throw of_another_scene();
  }
}

Failure Run::of_another_scene() const {
  return cannot("replay", options_.replay,
                "it was recorded from scene \"" + recording_.scene_name + "\" in another state than scene \"" +
                    scene_.name + "\" starts in",
                "Name that scene and the same --mesh");
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
  const bool asked = !options_.panorama.empty() || !options_.photo.empty() || !options_.light.empty();
  if (!scene_.shot && asked)
    throw cannot("use --panorama, --photo or --light with", scene_.source, "the scene is no shot",
                 "Leave them out, or run a shot, such as \"shot\"");
  if (!scene_.shot) return;
  if (!options_.collider_mesh.empty() && options_.asset.empty())
    throw Failure(
        "cannot use \"--object\" without \"--asset\": the object needs its own shadow. Bake it with sandglass bake and "
        "name it with --asset.");
  ShotOptions o;
  o.panorama = options_.panorama;
  o.later = options_.later;
  o.photo = options_.photo;
  o.photo_fov_deg = options_.fov_deg;
  o.mesh = {options_.collider_mesh, options_.as_mesh.units()};
  o.folder = options_.out;
  o.threads = drawing_threads();
  for (const LightSource source : {LightSource::room, LightSource::truth, LightSource::estimate, LightSource::nothing})
    if (options_.light == name_of(source)) o.light = source;
  o.isa = find_isa(options_.isa);
  shot_.emplace(scene_, o);
}

sandglass_scene_desc Run::describe(const Material& material, sandglass_isa isa) {
  sandglass_scene_desc desc = describe_filled(scene_, material);
  desc.isa = isa;
  desc.finest_level = finest_level_;
  if (!options_.as.empty()) {
    phone_.emplace(phone_core(options_.as));
    desc.clock = phone_->clock();
  } else if (options_.clock == "virtual") {
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
  if (phone_) {
    const PhoneCore& core = phone_->core();
    report_.estimate = {core.name,
                        core.ghz,
                        core.ipc_low,
                        core.ipc_high,
                        core.middle_ipc() / core.ipc_high,
                        core.middle_ipc() / core.ipc_low,
                        core.why};
  }
  report_.clock = phone_ ? "estimated" : options_.replay.empty() ? options_.clock : "replay";
  report_.light = shot_ ? name_of(shot_->source()) : scene_.light ? "scene's light" : "";
  report_.threads = options_.threads;
  report_.memory_bytes = simulation_->bytes();
}

uint64_t Run::hash() const {
  const uint64_t of_pile = pile_ ? sandglass_pile_shadow_hash(pile_->handle()) : 0;
  const uint64_t of_room = shot_ && shot_->room() != nullptr ? sandglass_room_hash(shot_->room()) : 0;
  return sandglass_scene_hash(simulation_->handle()) + shadows_->hash() + of_pile + of_room;
}

void Run::light_shadows(uint32_t frame) {
  if (!shot_ && !scene_.light) return;
  if (!shot_) {
    const Vec3 towards = scene_.light->towards(static_cast<double>(frame) / scene_.frames);
    shadows_->set_light(scene_, frame, towards);
    if (pile_) {
      pile_->set_light(towards);
      drawn_pile_->set_light(towards);
    }
    return;
  }
  const PlacedLight& light = shot_->light(frame);
  shadows_->set_light(scene_, frame, main_direction_of(light.object));
  shadows_->set_cells(scene_, frame, light.object.ambient_cells);
  if (!pile_) return;
  for (PileShadow* pile : {&*pile_, &*drawn_pile_}) {
    pile->set_light(main_direction_of(light.sand));
    pile->set_cells(light.sand.ambient_cells);
  }
}

// Runs one frame, by clock and budget or as recorded.
sandglass_frame_report Run::advance(uint32_t frame, std::vector<sandglass_collider>* colliders) {
  if (shot_) simulation_->see(shot_->estimator(), shot_->room(), shot_->image());
  light_shadows(frame);
  simulation_->flow(flow_over_frame(scene_, frame * scene_.frame_step));
  if (options_.replay.empty()) {
    *colliders = colliders_over_frame(scene_, frame);
    add_rigid_shapes(scene_, simulation_->handle(), scene_.frame_step, colliders);
    return simulation_->frame(scene_.frame_step, static_cast<uint64_t>(scene_.budget_ms * 1e6), *colliders, nullptr,
                              shadows_->handles(), shadows_->casts());
  }
  const RecordedFrame& recorded = recording_.frames[frame];
  *colliders = recorded.colliders;
  // A recording names only the shapes. The fields behind them come from the scene.
  for (size_t i = 0; i < colliders->size() && i < scene_.colliders.size(); ++i)
    (*colliders)[i].field = scene_.colliders[i].field;
  return simulation_->frame(static_cast<double>(recorded.time_step), recorded.budget_ns, *colliders, &recorded.plan,
                            shadows_->handles(), shadows_->casts());
}

void Run::take_snapshot(uint32_t frame, std::vector<sandglass_collider> colliders) {
  Snapshot snapshot;
  snapshot.frame = frame;
  snapshot.time = frame * scene_.frame_step;
  snapshot.particles = present(simulation_->particle_positions());
  LyingSand sand = {snapshot.particles, simulation_->particle_velocities(), colliders,
                    static_cast<float>(scene_.particle_radius)};
  std::copy_n(scene_.gravity, 3, sand.gravity);
  snapshot.sand = shaper_.shape(sand, drawn_pile_ ? drawn_pile_->handle() : nullptr);
  snapshot.sand.nozzles = flow_over_frame(scene_, snapshot.time).emitters;
  snapshot.sand.seconds = scene_.frame_step;
  shadows_->draw(colliders, &snapshot.shadows);
  if (drawn_pile_) drawn_pile_->draw(&snapshot.shadows);
  snapshot.colliders = std::move(colliders);
  if (scene_.light) snapshot.to_light = scene_.light->towards(static_cast<double>(frame) / scene_.frames);
  if (shot_) snapshot.to_light = main_direction_of(shot_->light(frame).object);
  snapshots_.push_back(std::move(snapshot));
}

void Run::execute() {
  const uint32_t particles = static_cast<uint32_t>(simulation_->particle_positions().size() / 3);
  const uint32_t step = snapshot_step(scene_.frames, scene_.frame_step, particles);
  const sandglass_clock cpu = clock_thread_cpu();
  const KeepingResults until_the_end;
  Progress progress("simulating " + scene_.name, scene_.frames);
  for (uint32_t frame = 0; frame < scene_.frames && !interrupted(); ++frame) {
    std::vector<sandglass_collider> colliders;
    FrameRow row = {};
    if (shot_) shot_->begin(frame);  // makes the camera's image, which a real app gets from its camera
    row.begin_ns = recorder_.now_ns();
    const uint64_t cpu_from = cpu.now_ns(cpu.user);
    row.report = advance(frame, &colliders);
    row.cpu_ms = static_cast<double>(cpu.now_ns(cpu.user) - cpu_from) * 1e-6;
    row.wall_ms = static_cast<double>(recorder_.now_ns() - row.begin_ns) * 1e-6;
    report_.frames.push_back(row);
    if (!options_.record.empty())
      recording_.frames.push_back(
          {static_cast<float>(scene_.frame_step), row.report.time.budget_ns, colliders, row.report.plan});
    if (!options_.out.empty() && ((frame + 1) % step == 0 || frame + 1 == scene_.frames))
      take_snapshot(frame + 1, colliders);
    progress.done(frame + 1);
  }
  report_.interrupted = interrupted();
  if (report_.interrupted && !options_.out.empty())
    std::fprintf(stderr, "sandglass: interrupted; reports and sheet of %zu frames follow. Ctrl-C again ends at once.\n",
                 report_.frames.size());
  report_.units = std::move(recorder_.events);
}

static int run(const RunOptions& options) {
  Run run(options);
  run.execute();
  const uint64_t hash = run.hash();
  run.finish(hash);
  const int exit_code = run.exit_code(hash);
  std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
  return exit_code;
}

Command run_command() {
  return command<RunOptions>("run", "Run a scene under its budget, report on it and draw it", options_of, run);
}

}  // namespace sandglass::host

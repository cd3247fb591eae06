// `sandglass run`: fills a scene with sand, runs its frames under the budget, reports, and ends with the hash of the
// final state.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <thread>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/atomic_file.h"
#include "models/host/body_meshes.h"
#include "models/host/collision_fields.h"
#include "models/host/failure.h"
#include "models/host/metrics.h"
#include "models/host/npy.h"
#include "models/host/pictures.h"
#include "models/host/pile_shadow.h"
#include "models/host/progress.h"
#include "models/host/recording.h"
#include "models/host/report.h"
#include "models/host/report_page.h"
#include "models/host/scene_file.h"
#include "models/host/scene_fill.h"
#include "models/host/simulation.h"
#include "models/host/standing_shadows.h"
#include "models/host/thread_pool.h"
#include "models/shot/shot.h"
#include "platform/clock.h"
#include "platform/virtual_clock.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

// The virtual clock moves on by this much at every reading, and the library reads it once or twice a work unit: a plan
// that depends on nothing but the scene and the budget.
constexpr uint64_t k_virtual_step_ns = 5'000;
constexpr int k_exit_check_failed = 1, k_exit_interrupted = 130;
constexpr uint32_t k_threads_at_most = 256, k_drawing_threads_at_most = 8;

struct Options {
  std::string scene, mesh, collider_mesh, clock = "real", isa = "automatic", record, replay, dump, out;
  std::string panorama, photo, asset, light, network;
  uint32_t frames = 0, threads = 1;
  double budget_ms = -1.0, fov_deg = 0.0;
  bool plain = false;
};

void dump_frame(const std::string& folder, uint32_t frame, double particle_radius, Simulation* simulation) {
  const auto write = [&](const char* item, const char* what, const std::vector<float>& values, uint64_t columns) {
    char name[64];
    std::snprintf(name, sizeof name, "%s_%06u_%s.npy", item, frame, what);
    write_npy((fs::path(folder) / name).string(), values, values.size() / columns, columns);
  };
  const std::vector<float>& particles = simulation->particle_positions();
  const uint32_t particle_count = static_cast<uint32_t>(particles.size() / 3);
  write("particles", "position", particles, 3);
  write("particles", "velocity", simulation->particle_velocities(), 3);
  write("particles", "radius", std::vector<float>(particle_count, static_cast<float>(particle_radius)), 1);
  const std::vector<float>& grains = simulation->grain_positions();
  const uint32_t grain_count = static_cast<uint32_t>(grains.size() / 3);
  if (grain_count == 0) return;
  write("grains", "position", grains, 3);
  write("grains", "velocity", simulation->grain_velocities(), 3);
  write("grains", "radius",
        std::vector<float>(grain_count, drawn_grain_radius(particle_radius, particle_count, grain_count)), 1);
}

void write_reports(const std::string& folder, const RunReport& report) {
  struct Part {
    const char* file;
    std::string (*content)(const RunReport& report);
  };
  constexpr Part k_parts[] = {{"report.csv", report_csv},
                              {"trace.json", report_trace},
                              {"summary.json", report_summary_json},
                              {"summary.txt", report_summary_text}};
  Progress progress("writing reports", std::size(k_parts));
  uint64_t written = 0;
  for (const Part& part : k_parts) {
    write_file((fs::path(folder) / part.file).string(), part.content(report));
    progress.done(++written);
  }
}

// Rows for the page's table.
std::vector<std::vector<std::string>> scene_facts(const SceneFile& scene) {
  const auto text = [](double value, const char* unit) {
    char words[48];
    std::snprintf(words, sizeof words, "%.6g %s", value, unit);
    return std::string(words);
  };
  const sandglass_granular_desc& g = scene.granular;
  return {{"file", fs::path(scene.source).filename().string()},
          {"frame step", text(1e3 * scene.frame_step, "ms of simulated time")},
          {"budget a frame", text(scene.budget_ms, "ms")},
          {"particle radius", text(1e3 * scene.particle_radius, "mm")},
          {"friction, static and kinetic",
           text(static_cast<double>(g.static_friction), "and ") + text(static_cast<double>(g.kinetic_friction), "")},
          {"bodies, colliders", std::to_string(scene.bodies.size()) + " and " + std::to_string(scene.colliders.size())},
          {"seed", std::to_string(scene.seed)}};
}

// Without what was removed.
std::vector<float> present(const std::vector<float>& positions) {
  std::vector<float> left;
  left.reserve(positions.size());
  for (size_t i = 0; i < positions.size(); i += 3)
    if (positions[i + 1] != SANDGLASS_REMOVED_Y) left.insert(left.end(), &positions[i], &positions[i] + 3);
  return left;
}

struct Run {
  const Options& options;
  SceneFile scene;
  VirtualClock virtual_time;
  TraceRecorder recorder;
  std::optional<CollisionFields> fields;
  std::optional<ThreadPool> pool;
  std::optional<Simulation> simulation;
  std::optional<StandingShadows> shadows;
  std::optional<PileShadow> pile;
  std::optional<Shot> shot;
  RunReport report;
  std::vector<Snapshot> snapshots;
  Recording recording;  // --replay: what to execute; --record: what was executed

  explicit Run(const Options& o) : options(o), scene(load_scene(o.scene)) {}

  uint32_t drawing_threads() const {
    return std::min(std::max(1u, std::thread::hardware_concurrency()), k_drawing_threads_at_most);
  }

  void take_shot() {
    const bool asked =
        !options.panorama.empty() || !options.photo.empty() || !options.light.empty() || !options.network.empty();
    if (!scene.shot && asked)
      throw Failure("scene '" + scene.source +
                    "' is no shot; --panorama, --photo, --light and --network need one, such as 'shot'");
    if (!scene.shot) return;
    if (!options.network.empty() && !options.light.empty() && options.light != name_of(LightSource::estimate))
      throw Failure("--network estimates the light, and --light " + options.light +
                    " takes another; leave one of them out");
    if (!options.collider_mesh.empty() && options.asset.empty())
      throw Failure("--object needs --asset: the shadow of that mesh, which sandglass bake makes");
    if (!options.photo.empty() && options.fov_deg <= 0.0)
      throw Failure("--photo needs --fov: the camera's field of view across the diagonal, in degrees");
    ShotOptions o;
    o.panorama = options.panorama, o.photo = options.photo, o.photo_fov_deg = options.fov_deg;
    o.mesh = options.collider_mesh, o.folder = options.out, o.threads = drawing_threads();
    for (const LightSource source : {LightSource::labels, LightSource::estimate, LightSource::arbitrary})
      if (options.light == name_of(source)) o.light = source;
    o.network = options.network, o.isa = find_isa(options.isa);
    shot.emplace(scene, o);
  }

  void prepare() {
    if (options.frames > 0) scene.frames = options.frames;
    if (options.budget_ms >= 0.0) scene.budget_ms = options.budget_ms;
    const sandglass_isa isa = find_isa(options.isa);
    if (!options.replay.empty()) {
      recording = load_recording(options.replay);
      if (recording.frames.empty())
        throw Failure("the recording '" + options.replay + "' holds no frame; record the run again");
      const size_t frames = recording.frames.size();
      scene.frames = static_cast<uint32_t>(options.frames > 0 ? std::min<size_t>(options.frames, frames) : frames);
    }
    for (const std::string& folder : {options.out, options.dump})
      if (!folder.empty()) make_folder(folder);

    if (!options.asset.empty()) {
      const auto standing = std::find_if(scene.colliders.begin(), scene.colliders.end(),
                                         [](const ColliderTrack& track) { return !track.shadow.empty(); });
      if (standing == scene.colliders.end())
        throw Failure("scene '" + scene.source + "' has no object with a baked shadow, so --asset does nothing");
      standing->shadow = options.asset;
    }
    take_shot();
    const LoadedMeshes meshes(scene, options.mesh);
    if (!meshes.note().empty()) std::fprintf(stderr, "sandglass: note: %s\n", meshes.note().c_str());
    const Material material = fill_scene(&scene, meshes.bodies());
    fields.emplace(&scene, options.collider_mesh);
    sandglass_scene_desc desc = describe_filled(scene, material);
    desc.isa = isa;
    if (options.clock == "virtual") {
      virtual_time.step_ns = k_virtual_step_ns;
      desc.clock = virtual_clock(&virtual_time);
    } else {
      desc.clock = sandglass_clock_system();
    }
    pool.emplace(options.threads);
    desc.parallel = pool->hook();
    if (!options.out.empty()) desc.trace = recorder.hook();
    simulation.emplace(desc);
    simulation->add(material);
    shadows.emplace(scene, isa);
    if (scene.pile_shadow) {
      pile.emplace(*scene.pile_shadow, isa);
      simulation->cast(pile->handle());
    }
    report.scene = scene.name;
    report.isa = sandglass_isa_name(sandglass_scene_isa(simulation->handle()));
    if (!shadows->handles().empty()) {
      const std::string of_bytes = sandglass_isa_name(sandglass_shadow_isa(shadows->handles()[0]));
      if (of_bytes != report.isa) report.isa += ", shadows " + of_bytes;
    }
    report.clock = options.replay.empty() ? options.clock : "replay";
    report.light = shot ? name_of(shot->source()) : scene.light ? "scene's light" : "";
    report.threads = options.threads;
    report.memory_bytes = simulation->bytes();
    if (!options.out.empty()) {
      std::vector<sandglass_collider> colliders = colliders_over_frame(scene, 0);
      add_rigid_shapes(scene, simulation->handle(), 0.0, &colliders);
      take_snapshot(0, std::move(colliders));
    }
    const uint64_t start_hash = sandglass_scene_hash(simulation->handle());
    if (options.replay.empty()) {
      recording.scene_name = scene.name;
      recording.start_hash = start_hash;
    } else if (recording.start_hash != start_hash) {
      throw Failure("the recording '" + options.replay + "' was made of scene '" + recording.scene_name +
                    "' in another state than scene '" + scene.name +
                    "' starts in; name that scene, and the same --mesh");
    }
  }

  void take_snapshot(uint32_t frame, std::vector<sandglass_collider> colliders) {
    Snapshot snapshot;
    snapshot.frame = frame, snapshot.time = frame * scene.frame_step;
    snapshot.grains = present(simulation->grain_positions()),
    snapshot.particles = present(simulation->particle_positions());
    snapshot.shadows = shadows->drawn(colliders);
    if (pile) snapshot.pile = {pile->drawn(false)}, snapshot.pile_surface = {pile->drawn(true)};
    snapshot.colliders = std::move(colliders);
    if (scene.light) snapshot.to_light = scene.light->towards(static_cast<double>(frame) / scene.frames);
    if (shot) snapshot.to_light = shot->light(frame).towards;
    snapshots.push_back(std::move(snapshot));
  }

  // Of every active stage.
  uint64_t hash() const {
    const uint64_t of_pile = pile ? sandglass_pile_shadow_hash(pile->handle()) : 0;
    return sandglass_scene_hash(simulation->handle()) + shadows->hash() + of_pile;
  }

  // What the app draws the frame with.
  FrameLight light_of(uint32_t frame) const {
    FrameLight light;
    if (!shot && !scene.light) return light;
    ShotLight now;
    if (shot) now = shot->light(frame);
    else now.towards = scene.light->towards(static_cast<double>(frame) / scene.frames);
    const auto put = [](Vec3 from, double(&to)[3]) { to[0] = from.x, to[1] = from.y, to[2] = from.z; };
    light.known = true, light.coloured = shot.has_value();
    put(normalised(now.towards), light.towards), put(now.light, light.light), put(now.ambient, light.ambient);
    light.contrast = now.contrast, light.confidence = now.confidence;
    return light;
  }

  // One frame by clock and budget, or as recorded.
  sandglass_frame_report advance(uint32_t frame, std::vector<sandglass_collider>* colliders) {
    if (shot) simulation->see(shot->estimator(), shot->image());
    if (shot || scene.light) {
      const Vec3 towards =
          shot ? shot->light(frame).towards : scene.light->towards(static_cast<double>(frame) / scene.frames);
      shadows->set_light(scene, frame, towards);
      if (pile) pile->set_light(towards);
    }
    simulation->flow(flow_over_frame(scene, frame * scene.frame_step));
    if (options.replay.empty()) {
      *colliders = colliders_over_frame(scene, frame);
      add_rigid_shapes(scene, simulation->handle(), scene.frame_step, colliders);
      return simulation->frame(scene.frame_step, static_cast<uint64_t>(scene.budget_ms * 1e6), *colliders, nullptr,
                               shadows->handles());
    }
    const RecordedFrame& recorded = recording.frames[frame];
    *colliders = recorded.colliders;
    // A recording names shapes; the fields behind them are the scene's.
    for (size_t i = 0; i < colliders->size() && i < scene.colliders.size(); ++i)
      (*colliders)[i].field = scene.colliders[i].field;
    return simulation->frame(static_cast<double>(recorded.time_step), recorded.budget_ns, *colliders, &recorded.plan,
                             shadows->handles());
  }

  void execute() {
    const uint32_t particles = static_cast<uint32_t>(simulation->particle_positions().size() / 3);
    const uint32_t grains = static_cast<uint32_t>(simulation->grain_positions().size() / 3);
    const uint32_t step = snapshot_step(scene.frames, scene.frame_step, particles, grains);
    const sandglass_clock cpu = clock_thread_cpu();
    Progress progress("simulating " + scene.name, scene.frames);
    for (uint32_t frame = 0; frame < scene.frames && !interrupted(); ++frame) {
      std::vector<sandglass_collider> colliders;
      FrameRow row = {};
      if (shot) shot->begin(frame);  // the made-up camera's image: an app is given its own
      row.begin_ns = recorder.now_ns();
      const uint64_t cpu_from = cpu.now_ns(cpu.user);
      row.report = advance(frame, &colliders);
      row.cpu_ms = static_cast<double>(cpu.now_ns(cpu.user) - cpu_from) * 1e-6;
      row.wall_ms = static_cast<double>(recorder.now_ns() - row.begin_ns) * 1e-6;
      row.light = light_of(frame);
      report.frames.push_back(row);
      if (!options.record.empty())
        recording.frames.push_back(
            {static_cast<float>(scene.frame_step), row.report.budget_ns, colliders, row.report.plan});
      if (!options.dump.empty()) dump_frame(options.dump, frame + 1, scene.particle_radius, &*simulation);
      if (!options.out.empty() && ((frame + 1) % step == 0 || frame + 1 == scene.frames))
        take_snapshot(frame + 1, colliders);
      progress.done(frame + 1);
    }
    report.interrupted = interrupted();
    if (report.interrupted && !options.out.empty())
      std::fprintf(stderr,
                   "sandglass: interrupted; reports and sheet of %zu frames follow, Ctrl-C again ends at once\n",
                   report.frames.size());
    report.units = std::move(recorder.events);
  }

  void finish(uint64_t hash) {
    if (!options.record.empty()) {
      recording.final_hash = hash;
      save_recording(recording, options.record);
    }
    if (!options.out.empty()) write_reports(options.out, report);
    std::fputs(report_summary_text(report).c_str(), stdout);
    if (report.interrupted)
      std::printf("interrupted after %zu of %u frames; the reports cover those\n", report.frames.size(), scene.frames);
    if (options.out.empty()) return;
    PictureSet set;
    set.folder = options.out;
    set.title = scene.name;
    set.particle_radius = scene.particle_radius;
    set.camera = scene.camera;
    set.threads = drawing_threads();
    set.plain = options.plain;
    set.film = !report.interrupted;
    if (shot)
      set.painter = [this](const Snapshot& snapshot, int width, int height, uint32_t threads) {
        return shot->paint(snapshot, width, height, threads);
      };
    if (snapshots.size() > 1) set.seconds_per_snapshot = snapshots[1].time - snapshots[0].time;
    PicturePaths paths = draw_pictures(set, snapshots);
    if (shot) {
      std::printf("light          %s, of %s\n", name_of(shot->source()), shot->surroundings().name.c_str());
      if (const double angle = shot->angle_deg(snapshots.back().frame); angle >= 0.0)
        std::printf("               %.1f degrees from the labels in the last frame\n", angle);
      if (shot->surroundings().has_truth() && !interrupted()) {
        const std::vector<PageFigure> figures = beside_truth(set.threads);
        paths.figures.insert(paths.figures.begin(), figures.begin(), figures.end());
      }
    }
    const std::string page = (fs::path(options.out) / "report.html").string();
    write_file(page, report_page(report, page_content(paths.figures)));
    if (!paths.film.empty()) std::printf("film           %s\n", paths.film.c_str());
    std::printf("last frame     %s\n", paths.last.c_str());
    std::printf("contact sheet  %s\n", paths.sheet.c_str());
    for (const char* file : {"trace.json", "report.csv", "summary.json", "summary.txt"})
      std::printf("report         %s\n", (fs::path(options.out) / file).string().c_str());
    std::printf("page           %s\n", page.c_str());
  }

  // The last picture beside its truth; where its light is not that of the labels, first the same instant in theirs:
  // what renderer and shadow can do, before what the light gets wrong.
  std::vector<PageFigure> beside_truth(uint32_t threads) const {
    const Snapshot& last = snapshots.back();
    const RadianceMap truth = shot->traced(last, options.out, threads);
    const auto file = [&](const std::string& name) {
      const std::string content = read_file((fs::path(options.out) / (name + ".png")).string(), "picture");
      return ImageFile(content.begin(), content.end());
    };
    std::vector<PageFigure> figures;
    const auto compare = [&](const Snapshot& lit, const ShotLight& light, const std::string& name,
                             const std::string& title) {
      const std::string errors = shot_errors_text(shot->compare(lit, light, truth, options.out, name, threads));
      std::printf("beside truth   %s: %s\n", title.c_str(), errors.c_str());
      std::printf("               %s\n", (fs::path(options.out) / ("beside_truth" + name + ".png")).string().c_str());
      figures.push_back({"Composite and truth: " + title, errors, file("composite" + name), file("truth"), "composite",
                         "path traced", false});
    };
    if (shot->source() != LightSource::labels)
      compare(shot->relit(last, shot->labels().towards), shot->labels(), "_labels", "lit by the true labels");
    const char* title = shot->source() == LightSource::labels     ? "lit by the true labels"
                        : shot->source() == LightSource::estimate ? "lit by the network's estimate"
                                                                  : "lit by an arbitrary light";
    compare(last, shot->light(last.frame), "", title);
    return figures;
  }

  PageContent page_content(std::vector<PageFigure> figures) const {
    PageContent content;
    content.figures = std::move(figures);
    content.tables.push_back({"Scene", "", {}, scene_facts(scene)});
    content.tables.push_back({"Machine", "", {}, machine_facts()});
    if (shot && shot->source() != LightSource::labels && shot->surroundings().has_truth() && !report.frames.empty()) {
      LightSeries labels = {"labels", {}};
      const Vec3 d = shot->labels().towards;
      for (const FrameRow& row : {report.frames.front(), report.frames.back()}) {
        LightSample sample;
        sample.time = row.report.simulated_time, sample.direction = {d.x, d.y, d.z};
        labels.samples.push_back(sample);
      }
      content.light.push_back(std::move(labels));
    }
    return content;
  }

  int exit_code(uint64_t hash) const {
    if (report.interrupted || interrupted()) return k_exit_interrupted;
    const bool whole = !options.replay.empty() && report.frames.size() == recording.frames.size();
    if (!whole || hash == recording.final_hash) return 0;
    std::fprintf(stderr, "sandglass: the replay ends in another state than the recording, whose hash is 0x%016llx\n",
                 static_cast<unsigned long long>(recording.final_hash));
    return k_exit_check_failed;
  }
};

}  // namespace

void add_run_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  Command command =
      program.add_subcommand("run", "Fill a scene with sand, run it under its budget, report and draw it");
  command->add_option("scene", options->scene, "Scene file, or the name of a shipped scene")->required();
  command->add_option("--mesh", options->mesh, "Triangle mesh for the scene's bodies of shape \"mesh\"");
  command->add_option("--collider-mesh,--object", options->collider_mesh,
                      "Triangle mesh for the scene's colliders of shape \"mesh\"");
  command->add_option("--asset", options->asset, "Baked shadow of that object, instead of the scene's");
  Option panorama = command->add_option("--panorama", options->panorama, "Of a shot: the room, .hdr or .exr");
  Option photo = command->add_option("--photo", options->photo, "Of a shot: a photograph behind it, with --fov");
  photo->excludes(panorama);
  command->add_option("--fov", options->fov_deg, "Field of view of --photo across the diagonal, degrees")
      ->check(range(5.0, 150.0))
      ->needs(photo);
  command->add_option("--network", options->network,
                      "Of a shot: the lighting network's file, instead of the shipped one");
  command->add_option("--light", options->light, "Of a shot: labels (of the panorama), estimate, or arbitrary")
      ->check(one_of({"labels", "estimate", "arbitrary"}));
  command->add_option("--frames", options->frames, "Frames to run instead of the scene's")
      ->check(range(1u, 100'000'000u));
  command->add_option("--budget-ms", options->budget_ms, "Budget of a frame, instead of the scene's")
      ->check(range(0.0, 1e6));
  command->add_option("--threads", options->threads, "Threads, the calling one included (1)")
      ->check(range(1u, k_threads_at_most));
  command->add_option("--clock", options->clock, "real, or virtual: 5 microseconds a reading, the same plan everywhere")
      ->check(one_of({"real", "virtual"}));
  command->add_option("--isa", options->isa,
                      "Kernels: scalar, neon, neon_dotprod, neon_i8mm, avx2, avx512 (automatic)");
  Option record =
      command->add_option("--record", options->record, "Write what every frame was given and did to this file");
  command->add_option("--replay", options->replay, "Execute a recorded run to the bit")->excludes(record);
  command->add_option("--dump", options->dump,
                      "Write positions, velocities and radii of every frame as NPY into this folder");
  command->add_option("--out", options->out, "Write reports, contact sheet, frames and film into this folder");
  command->add_flag("--plain", options->plain, "Pictures without label, ruler and checker, in warmer colours");
  command->callback([options, exit_code] {
    listen_for_interrupt();
    Run run(*options);
    run.prepare();
    run.execute();
    const uint64_t hash = run.hash();
    run.finish(hash);
    *exit_code = run.exit_code(hash);
    std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
  });
}

}  // namespace sandglass::host

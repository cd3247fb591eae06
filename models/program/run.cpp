// `sandglass run`: fills a scene with sand, runs its frames under the budget, reports, and ends with the hash of the
// final state.
#include "models/program/run.h"

#include <cstdio>

#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

void add_scene_options(Command& command, RunOptions& o) {
  command.add("SCENE", o.scene, "Scene file, or the name of a shipped scene").required();
  command.add("--mesh FILE", o.mesh, "Mesh of the scene's bodies of shape \"mesh\"");
  command.add("--object,--collider-mesh FILE", o.collider_mesh, "Mesh of the scene's colliders of shape \"mesh\"");
  command.add("--asset FILE", o.asset, "Baked shadow of that object").by_default("the scene's");
  command.add("--frames N", o.frames, "Frames to run").checked(whole_number(1, 100'000'000)).by_default("the scene's");
  command.add("--budget-ms MS", o.budget_ms, "Budget of a frame, ms").checked(number(0, 1e6)).by_default("the scene's");
}

void add_shot_options(Command& command, RunOptions& o) {
  Option& panorama = command.add("--panorama FILE", o.panorama, "For a shot: the room, .hdr or .exr");
  Option& photo = command.add("--photo FILE", o.photo, "For a shot: a photograph behind the scene, PNG or JPEG");
  Option& fov = command.add("--fov DEGREES", o.fov_deg, "Field of view of --photo across the diagonal, degrees")
                    .checked(number(5, 150))
                    .by_default("");
  photo.excludes(panorama).needs(fov);
  fov.needs(photo);
  command.add("--light KIND", o.light, "For a shot: light of the panorama's labels, of the network, or any other")
      .checked(one_of({"labels", "estimate", "arbitrary"}));
  command.add("--network FILE", o.network, "For a shot: the lighting network").by_default("the shipped one");
}

void add_machine_options(Command& command, RunOptions& o) {
  add_threads(command, o.threads);
  add_isa(command, o.isa);
  command
      .add("--clock KIND", o.clock,
           "Clock of the budget; virtual adds 5 microseconds a reading: equal plans everywhere")
      .checked(one_of({"real", "virtual"}));
}

void add_output_options(Command& command, RunOptions& o) {
  command.add("--out FOLDER", o.out, "Write reports, contact sheet, frames and film into this folder");
  command.add_flag("--plain", o.plain, "Draw without label, ruler and checker, in warmer colours");
  command.add("--dump FOLDER", o.dump, "Write positions, velocities and radii of every frame into this folder, .npy");
  Option& record = command.add("--record FILE", o.record, "Write what every frame was given and did to this file");
  command.add("--replay FILE", o.replay, "Repeat the run of such a file, to the bit").excludes(record);
}

}  // namespace

void add_run_command(Command& program, const std::string& group) {
  const auto options = std::make_shared<RunOptions>();
  Command& command = program.add_command("run", "Run a scene under its budget, report on it and draw it", group);
  add_scene_options(command, *options);
  add_shot_options(command, *options);
  add_machine_options(command, *options);
  add_output_options(command, *options);
  command.runs([options] {
    listen_for_interrupt();
    Run run(*options);
    run.execute();
    const uint64_t hash = run.hash();
    run.finish(hash);
    const int exit_code = run.exit_code(hash);
    std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
    return exit_code;
  });
}

}  // namespace sandglass::host

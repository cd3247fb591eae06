// `sandglass view SCENE`: the scene in a window, to be turned, lit, poured and pushed while it runs.

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/failure.h"
#include "models/host/progress.h"
#ifdef SANDGLASS_HAVE_VIEW
#include "models/view/window.h"
#endif

namespace sandglass::host {

#ifdef SANDGLASS_HAVE_VIEW

void add_view_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<ViewOptions>();
  Command command = program.add_subcommand(
      "view",
      "Show a running scene in a window: the sand, what stands in it, and the shadows of both, within the budget; of a "
      "shot neither its room nor an estimate of its light");
  command->add_option("scene", options->live.scene, "Scene file, or the name of a shipped scene")->required();
  command->add_option("--mesh", options->live.mesh, "Triangle mesh for the scene's bodies of shape \"mesh\"");
  command->add_option("--collider-mesh", options->live.collider_mesh,
                      "Triangle mesh for the scene's colliders of shape \"mesh\"");
  command->add_option("--budget-ms", options->live.budget_ms, "Budget of a frame, instead of the scene's")
      ->check(range(0.1, 1000.0));
  command->add_option("--threads", options->live.threads, "Threads, the calling one included (1)")
      ->check(range(1u, 256u));
  command->add_option("--isa", options->live.isa, "Kernels, as for run (automatic)");
  command->add_option("--width", options->width, "Of the window, pixels (1280)")->check(range(320, 8192));
  command->add_option("--height", options->height, "Of the window, pixels (800)")->check(range(240, 8192));
  Option frames =
      command->add_option("--frames", options->frames, "Show so many frames, each 1/60 s of the scene, and end")
          ->check(range(1u, 1'000'000u));
  command->add_option("--screenshot", options->screenshot, "Write the last frame to this PNG")->needs(frames);
  command
      ->add_option("--script", options->script,
                   "Mouse and keys by frame: \"10 down P; 60 up P; 61 cursor 400 300; 61 press right\"")
      ->needs(frames);
  command->callback([options, exit_code] {
    listen_for_interrupt();
    view_scene(*options);
    *exit_code = 0;
  });
}

#else

void add_view_command(Command& program, int*) {
  Command command = program.add_subcommand("view", "Show a running scene in a window (not in this build)");
  command->allow_extras();
  command->callback([] {
    throw Failure(
        "this build has no viewer; install libglfw3-dev and libepoxy-dev (Debian's names), configure and "
        "build again");
  });
}

#endif

}  // namespace sandglass::host

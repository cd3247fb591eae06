// `sandglass view SCENE`: the scene in a window, to be turned, lit, poured and pushed while it runs.
#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "models/work/progress.h"
#ifdef SANDGLASS_HAVE_VIEW
#include "models/view/window.h"
#endif

namespace sandglass::host {

void add_view_command(Command& program, const std::string& group) {
  Command& command = program.add_command("view", "Show a running scene in a window", group);
#ifdef SANDGLASS_HAVE_VIEW
  const auto options = std::make_shared<ViewOptions>();
  LiveOptions& live = options->live;
  command.add("SCENE", live.scene, "Scene file, or the name of a shipped scene").required();
  command.add("--mesh FILE", live.mesh, "Mesh of the scene's bodies of shape \"mesh\"");
  command.add("--collider-mesh FILE", live.collider_mesh, "Mesh of the scene's colliders of shape \"mesh\"");
  command.add("--budget-ms MS", live.budget_ms, "Budget of a frame, ms")
      .checked(number(0.1, 1000))
      .by_default("the scene's");
  add_threads(command, live.threads);
  add_isa(command, live.isa);
  command.add("--width N", options->width, "Width of the window, pixels").checked(whole_number(320, 8192));
  command.add("--height N", options->height, "Height of the window, pixels").checked(whole_number(240, 8192));
  Option& frames = command.add("--frames N", options->frames, "End after this many frames, each 1/60 s of the scene")
                       .checked(whole_number(1, 1'000'000))
                       .by_default("until the window is closed");
  command.add("--screenshot FILE", options->screenshot, "Write the last frame to this file, .png").needs(frames);
  command
      .add("--script EVENTS", options->script,
           "Mouse and keys by frame: \"10 down P; 60 up P; 61 cursor 400 300; 61 press right\"")
      .needs(frames);
  command.runs([options] {
    listen_for_interrupt();
    view_scene(*options);
    return k_exit_done;
  });
#else
  command.is_left_out("this build has no viewer",
                      "Install libglfw3-dev and libepoxy-dev (Debian's names), configure and build again.");
#endif
}

}  // namespace sandglass::host

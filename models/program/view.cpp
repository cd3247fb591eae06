// `sandglass view SCENE`: the scene in a window, to be turned, lit, poured and pushed while it runs.
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

int view_command(const ViewOptions& options) {
  listen_for_interrupt();
  view_scene(options);
  return k_exit_done;
}

}  // namespace sandglass::host

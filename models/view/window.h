// The command `sandglass view`: a window with a running scene.
#pragma once

#include <string>

#include "models/view/live_scene.h"

namespace sandglass::host {

struct ViewOptions {
  LiveOptions live;
  int width = 1280, height = 800;
  uint32_t frames = 0;     // frames of the display; 0: runs until the window is closed
  std::string screenshot;  // path of a PNG of the last frame; needs `frames`
  std::string script;      // as in input_script.h
};

// With `frames`, every display frame stands for 1/60 s, however long it takes. So a script acts at the same times in
// every run. Throws a Failure when there is no display.
void view_scene(const ViewOptions& options);

}  // namespace sandglass::host

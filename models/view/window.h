// `sandglass view`: a window with a running scene.
#pragma once

#include <string>

#include "models/view/live_scene.h"

namespace sandglass::host {

struct ViewOptions {
  LiveOptions live;
  int width = 1280, height = 800;
  uint32_t frames = 0;     // of the display; 0: until the window is closed
  std::string screenshot;  // the last frame, as PNG
  std::string script;      // input_script.h
};

// With `frames`, every display frame stands for 1/60 s, however long it takes: what a script does is then repeatable.
// A Failure where there is no display.
void view_scene(const ViewOptions& options);

}  // namespace sandglass::host

// Whether what is put into a room has the room's colour: a chair and sand, composited and path traced, compared where
// each of them is seen.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/compositing/shot_picture.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct ColourOptions {
  std::vector<std::string> panoramas;  // files
  std::string manifest;                // places; empty: each panorama is its own
  uint64_t seed = 0;                   // where the cameras look, and how the phone sways
  ShotPictureOptions picture = {320, 240, 3, 96};
  std::string network;  // a lighting network's file, for the picture with one light; empty: without it
};

// `progress` gets the number of rooms done and returns false to stop; the result is then empty. A Failure names the
// first panorama that cannot be read.
std::vector<Verdict> verify_colours(const ColourOptions& options, const std::function<bool(size_t done)>& progress);

}  // namespace sandglass::host

// Whole pictures, in place of the dissertation's user study (Fig. 6.11): a chair and sand in captured rooms, drawn as an
// app could draw them, against the same scene path traced in the room. Each picture's mean light is that of the other
// places. Two wrong lights, of a mirrored and of another room, must lose against the right one. And whether what is put
// into a room has the room's colour, compared where each thing is seen.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/compositing/shot_picture.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct ShotVerdictOptions {
  std::vector<std::string> panoramas;  // files
  std::string manifest;                // places; empty: each panorama is its own
  uint64_t seed = 0;                   // where the cameras look, and how the phone sways
  ShotPictureOptions picture;
  std::string network;  // a lighting network's file; empty: without estimate
};

// `progress` gets the number of pictures done and returns false to stop; the result is then empty. Network and panoramas
// are read before anything is measured; a Failure names the first that cannot be read.
std::vector<Verdict> verify_shots(const ShotVerdictOptions& options, const std::function<bool(size_t done)>& progress);
std::vector<Verdict> verify_colours(const ShotVerdictOptions& options,
                                    const std::function<bool(size_t done)>& progress);

}  // namespace sandglass::host

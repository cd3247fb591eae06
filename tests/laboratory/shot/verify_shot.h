// The study of shots, in place of the dissertation's user study (Fig. 6.11): a chair and sand in captured rooms, drawn as
// an app could draw them, against the same scene path traced in the room. By place; each place's mean light is that of
// the others.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/compositing/shot.h"
#include "tests/laboratory/shot/shot_study.h"

namespace sandglass::host {

std::vector<PileShadowError> study_pile_shadow();

struct ShotStudyOptions {
  std::vector<std::string> panoramas;  // files
  std::string manifest;                // places; empty: each panorama is its own
  uint64_t seed = 0;                   // where the cameras look. 0 is the study; others check what was learnt from it
  ShotPictureOptions picture = {160, 120, 4, 256, 1};
  std::string network;  // a lighting network's file; empty: without estimate
  std::string folder;   // for finished views, from which a later run goes on, and for pictures; may be empty
};

// `progress` gets the number of views done and returns false to stop. Stops early, with what it has. Network and
// panoramas are read before anything is measured; a Failure names the first that cannot be read. Without panoramas
// there are no views.
ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress);

}  // namespace sandglass::host

// The study of shots, in place of the dissertation's user study (Fig. 6.11). One view of each of 20 panoramas is
// composited and path traced: with the true labels, with an estimate if there is a network, and with three things left
// out. In the mean of each of seven errors, true labels must beat each of the three.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/compositing/shot.h"
#include "models/laboratory/shot/shot_study.h"

namespace sandglass::host {

std::vector<PileShadowError> study_pile_shadow();

struct ShotStudyOptions {
  std::vector<std::string> panoramas;  // files; the first `views` are taken
  size_t views = 20;
  uint64_t seed = 0;  // where the cameras look. 0 is the study; others check what was learnt from it
  // A composite has eight samples per pixel and axis, so that its own noise is as small as the truth's.
  ShotPictureOptions picture = {160, 120, 8, 1024, 1};
  std::string network;  // a lighting network's file; empty: without estimate
  std::string folder;   // for finished views, from which a later run goes on, and for pictures; may be empty
};

// `progress` gets the number of views done and returns false to stop. Network and panoramas are read before anything is
// measured; a Failure names the first that cannot be read. Without panoramas there are no views.
ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress);

}  // namespace sandglass::host

// What stands in for the source's user study (Fig. 6.11): one view of each of 20 panoramas, composited and path traced,
// with the true labels, with an estimate where there is a network, and with three things left out. Means of seven
// errors; true labels must beat each ablation on every one of them.
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
  uint64_t seed = 0;  // where the cameras look: 0 is the study, others are there to check what was learnt from it
  // Eight points of a composite's pixel and axis: its own noise counts as little as the truth's.
  ShotPictureOptions picture = {160, 120, 8, 1024, 1};
  std::string network;  // a lighting network's file; empty: without estimate
  std::string folder;   // keeps finished views, so that a run goes on where it ended, and gets pictures; may be empty
};

// `progress`: views done; returns false to stop. Network and panoramas are read before anything is measured: a Failure
// names the first that cannot be. Without panoramas there are no views.
ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress);

}  // namespace sandglass::host

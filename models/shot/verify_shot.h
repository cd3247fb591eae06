// What stands in for the source's user study (Fig. 6.11): one view of each of 20 panoramas, composited and path traced,
// with the true labels, with an estimate where there is a network, and with three things left out. Means of seven
// errors; true labels must beat each ablation on every one of them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/shot/shot.h"

namespace sandglass::host {

// plain_shadow: true labels, the shadow multiplied onto what the camera shows, in all colours alike. It is beside the
// ablations, for what the tone curve does, and nothing is promised against it.
enum class ShotVariant { labels, no_shadow, hard_shadow, arbitrary_light, plain_shadow, estimate };
constexpr int k_shot_variants = 6, k_shot_metrics = 7;
const char* name_of(ShotVariant variant);
const char* shot_metric_name(int metric);  // "RMSE", ..., the last two "1 - SSIM" and "FLIP": all are 0 at best

struct ShotView {
  std::string panorama;
  bool done = false, has_estimate = false;
  double errors[k_shot_variants][k_shot_metrics] = {};
  double angle_deg = 0.0;  // between estimate and labels
};

// The sand's own shadow in one light, against rays cast at the very grains that are drawn: means over texels of what
// can be seen of them (6.18), on the floor where either is in shadow. Apart: texels in which grains lie, of which a
// texture can say no more than one thing; and the grains' own surface as it is seen from above, by its cosine to the
// light.
struct PileShadowError {
  double polar_deg, azimuth_deg;
  struct Part {
    double rmse = 0.0, without = 0.0, bias = 0.0;  // of visibility; without: of no shadow of the sand
    int texels = 0;
  } clear, among_grains, on_sand;
};
std::vector<PileShadowError> study_pile_shadow();
PileShadowError whole_of(const std::vector<PileShadowError>& lights);  // over all texels of all lights
bool holds(const PileShadowError& whole);
std::string pile_shadow_text(const std::vector<PileShadowError>& lights);

struct ShotStudy {
  std::vector<ShotView> views;
  bool has_estimate = false;
  double mean[k_shot_variants][k_shot_metrics] = {};
  // labels (first) or estimate (second) against another variant: mean of the paired differences, and half of its 95 %
  // interval over views (bootstrap would say the same of 20; this is Student's).
  struct Paired {
    double mean, half;
  };
  Paired paired(ShotVariant better, ShotVariant worse, int metric) const;
  // The labels' mean is below the ablation's.
  bool beats(ShotVariant ablation, int metric) const {
    return mean[0][metric] < mean[static_cast<int>(ablation)][metric];
  }
};

struct ShotStudyOptions {
  std::vector<std::string> panoramas;  // files; the first `views` are taken
  size_t views = 20;
  uint64_t seed = 0;  // where the cameras look: 0 is the study, others are there to check what was learnt from it
  int width = 160, height = 120, paths = 1024;
  std::string network;  // a lighting network's file; empty: without estimate
  std::string folder;   // keeps finished views, so that a run goes on where it ended, and gets pictures; may be empty
  uint32_t threads = 1;
};

// `progress`: views done; returns false to stop.
ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress);

std::string shot_study_text(const ShotStudy& study);  // Markdown

}  // namespace sandglass::host

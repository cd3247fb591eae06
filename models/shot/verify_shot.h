// What stands in for the source's user study (Fig. 6.11): one view of each of 20 panoramas, composited and path traced,
// with the true labels, with an estimate where there is a network, and with three things left out. Means of seven
// errors; true labels must beat each ablation on every one of them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/shot/shot.h"

namespace sandglass::host {

enum class ShotVariant { labels, no_shadow, hard_shadow, arbitrary_light, estimate };
constexpr int k_shot_variants = 5, k_shot_metrics = 7;
const char* name_of(ShotVariant variant);
const char* shot_metric_name(int metric);  // "RMSE", ..., the last two "1 - SSIM" and "FLIP": all are 0 at best

struct ShotView {
  std::string panorama;
  bool done = false, has_estimate = false;
  double errors[k_shot_variants][k_shot_metrics] = {};
  double angle_deg = 0.0;  // between estimate and labels
};

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
  int width = 160, height = 120, paths = 64;
  std::string network;  // a lighting network's file; empty: without estimate
  std::string folder;   // keeps finished views, so that a run goes on where it ended, and gets pictures; may be empty
  uint32_t threads = 1;
};

// `progress`: views done; returns false to stop.
ShotStudy study_shots(const ShotStudyOptions& options, const std::function<bool(size_t done)>& progress);

std::string shot_study_text(const ShotStudy& study);  // Markdown

}  // namespace sandglass::host

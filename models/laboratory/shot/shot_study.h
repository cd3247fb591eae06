// What a study of shots says: rows of errors that somebody measured (verify_shot.h), their means, what beats what, and
// how sure that is; as a table, and as lines that a later run goes on from. Numbers only: nothing here makes a picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

// no_curve: true labels without the camera's tone curve, the shadow multiplied onto what the camera shows, in all
// colours alike. It is beside the ablations, for what the curve does, and nothing is promised against it.
enum class ShotVariant { labels, no_shadow, hard_shadow, arbitrary_light, no_curve, estimate };
constexpr int k_shot_variants = 6, k_shot_metrics = 7;
const char* name_of(ShotVariant variant);
const char* shot_metric_name(int metric);  // "RMSE", ..., the last two "1 - SSIM" and "FLIP": all are 0 at best

struct ShotView {
  std::string panorama;        // its name, for the reader
  uint64_t panorama_hash = 0;  // of the file's bytes: a name may be another's too
  double azimuth_deg = 0.0;    // where the camera looks
  bool done = false, has_estimate = false;
  double errors[k_shot_variants][k_shot_metrics] = {};
  double angle_deg = 0.0;  // between estimate and labels
};

struct ShotStudy {
  std::vector<ShotView> views;
  bool has_estimate = false;
  double mean[k_shot_variants][k_shot_metrics] = {};  // of the views that are done
  // labels (first) or estimate (second) against another variant: mean of the paired differences, and half of its 95 %
  // interval over views (Student's; a bootstrap would say the same of 20). Of one view it has no end.
  struct Paired {
    double mean, half;
  };
  Paired paired(ShotVariant better, ShotVariant worse, int metric) const;
  // The labels' mean is below the ablation's.
  bool beats(ShotVariant ablation, int metric) const {
    return mean[0][metric] < mean[static_cast<int>(ablation)][metric];
  }
};
void take_means(ShotStudy* study);

// Of Student's distribution: within this many standard errors of the mean lie 95 %.
double student_95(int degrees_of_freedom);

// One line a view, and back; false: that is none.
std::string line_of(const ShotView& view);
bool read_line(const std::string& line, ShotView* view);

// Takes over the rows of an earlier run that are of the same bytes and look the same way; `views` name theirs. `text`
// begins with the line `key`, or is another study's, of which nothing is taken.
void remember(const std::string& text, const std::string& key, std::vector<ShotView>* views);

std::string shot_study_text(const ShotStudy& study);  // Markdown

// The sand's own shadow in one light, against rays cast at the very grains that are drawn: means over texels of what
// can be seen of them (6.18), on the floor where either is in shadow. Apart: texels in which grains lie, of which a
// texture can say no more than one thing; and the grains' own surface as it is seen from above, by its cosine to the
// light.
struct PileShadowError {
  double polar_deg, azimuth_deg;
  struct Part {
    double rmse = 0.0, without = 0.0, bias = 0.0;  // of visibility; without: of no shadow of the sand
    double particles = 0.0,
           mirrored = 0.0;  // rmse of controls: made of the particles; of the light from the other side
    int texels = 0;
  } clear, among_grains, on_sand;
};
PileShadowError whole_of(const std::vector<PileShadowError>& lights);  // over all texels of all lights

// What the shadow has to be good for: on the floor it takes away two thirds or more of the error that leaving it out
// makes, with no more than a twentieth of the light too much or too little, and is nearer than the particles' own
// shadow; on the sand, where the shadows between neighbours are not its part, a quarter. Everywhere it is nearer than
// that of the light from the other side.
bool holds(const PileShadowError& whole);
std::string pile_shadow_text(const std::vector<PileShadowError>& lights);

}  // namespace sandglass::host

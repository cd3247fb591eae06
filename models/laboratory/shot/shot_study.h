// What a study of shots concludes. It takes rows of errors that verify_shot.h measured. It gives their means, says what
// beats what and how sure that is, as a table and as lines from which a later run goes on. It makes no picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

// no_curve: true labels without the camera's tone curve; the shadow is multiplied onto what the camera shows, in all
// colours alike. It shows what the curve does. Nothing is promised against it.
enum class ShotVariant { labels, no_shadow, hard_shadow, arbitrary_light, no_curve, estimate };
constexpr int k_shot_variants = 6, k_shot_metrics = 7;
const char* name_of(ShotVariant variant);
const char* shot_metric_name(int metric);  // "RMSE", ..., the last two "1 - SSIM" and "FLIP": all are 0 at best

struct ShotView {
  std::string panorama;        // the file's name, for the reader
  uint64_t panorama_hash = 0;  // hash of the file's bytes: two files may have one name
  double azimuth_deg = 0.0;    // where the camera looks
  bool done = false, has_estimate = false;
  double errors[k_shot_variants][k_shot_metrics] = {};
  double angle_deg = 0.0;  // between estimate and labels
};

struct ShotStudy {
  std::vector<ShotView> views;
  bool has_estimate = false;
  double mean[k_shot_variants][k_shot_metrics] = {};  // of the views that are done
  // A variant against a worse one: the mean of the paired differences, and half of its 95 % interval over views (by
  // Student's distribution). With one view the interval is infinite.
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

// 95 % of Student's distribution lie within this many standard errors of the mean.
double student_95(int degrees_of_freedom);

// A view as a line of text, and back. Returns false if the line is not of a view.
std::string line_of(const ShotView& view);
bool read_line(const std::string& line, ShotView* view);

// Takes over the rows of an earlier run, for those of `views` with the same bytes and the same azimuth. If `text` does
// not begin with the line `key`, it is of another study, and nothing is taken.
void remember(const std::string& text, const std::string& key, std::vector<ShotView>* views);

std::string shot_study_text(const ShotStudy& study);  // Markdown

// The sand's own shadow in one light, against rays cast at the grains that are drawn. The values are means over texels
// in which either is in shadow. Three parts are kept apart: clear floor; texels in which grains lie, for which a
// texture has only one value; and the grains' own surface as seen from above, weighted by its cosine to the light.
struct PileShadowError {
  double polar_deg, azimuth_deg;
  struct Part {
    // Errors of visibility. `without`: the RMSE if the sand casts no shadow.
    double rmse = 0.0, without = 0.0, bias = 0.0;
    // RMSE of the controls: a shadow made of the particles, and the shadow of the light from the other side.
    double particles = 0.0, mirrored = 0.0;
    int texels = 0;
  } clear, among_grains, on_sand;
};
PileShadowError whole_of(const std::vector<PileShadowError>& lights);  // over all texels of all lights

// Whether the shadow is good enough. On the floor it must remove at least two thirds of the error that leaving it out
// makes, have a bias of at most a twentieth of the light, and beat the shadow made of the particles. On the sand it
// must remove a quarter: shadows between neighbours are not its part. Everywhere it must beat the shadow of the light
// from the other side.
bool holds(const PileShadowError& whole);
std::string pile_shadow_text(const std::vector<PileShadowError>& lights);

}  // namespace sandglass::host

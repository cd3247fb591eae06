// What a study of shots concludes. It takes rows of errors that verify_shot.h measured. It gives their means over places,
// says what beats what and how sure that is, as a table and as lines from which a later run goes on. It makes no picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

// What an app could draw, and what it cannot. The mean light is that of all other places: brightness and harmonics, at
// the geometric mean of the level that the camera's own exposure leaves.
enum class ShotVariant {
  no_shadow,     // mean light, nothing falls on the floor: an app without any estimate
  ambient,       // the same with the ambient shadows of an even sky
  one_light,     // by the network from one image, and nothing else
  turn,          // the room as a session has seen it in a full turn
  turn_short,    // with every fourth image exposed for a 64th of the time
  truth,         // the true light, in cells and nine harmonics
  turn_shadow,   // the shadows of the full turn, object and sand in the true light
  turn_shading,  // the other way round
  turn_level,    // the full turn at the true level
  mirrored,      // control: the full turn as in a mirror
  other_room,    // control: the full turn of another place, at this one's level
  // As the dissertation draws: one light of the panorama's labels (5.1), at the true level.
  label,
  label_no_shadow,
  label_hard,  // its shadow with an edge
  arbitrary,   // some light, at the mean level
  // The mean light at the true level: what the ambient shadow is worth, without what the level's error does.
  no_shadow_level,
  ambient_level
};
constexpr int k_shot_variants = 17, k_shot_metrics = 7;
const char* name_of(ShotVariant variant);
const char* shot_metric_name(int metric);  // "RMSE", ..., the last two "1 - SSIM" and "FLIP": all are 0 at best

struct ShotView {
  std::string panorama;        // the file's name, for the reader
  std::string place;           // several panoramas may show one
  uint64_t panorama_hash = 0;  // hash of the file's bytes: two files may have one name
  double azimuth_deg = 0.0;    // where the camera looks
  bool done = false, has_network = false;
  double errors[k_shot_variants][k_shot_metrics] = {};
  // Between the middles of the floor's light, of the full turn and the truth; and the logarithm of its level's error.
  double angle_deg = 0.0, log_level = 0.0;
};

struct ShotStudy {
  std::vector<ShotView> views;
  bool has_network = false;
  double mean[k_shot_variants][k_shot_metrics] = {};  // over the places that are done
  // A variant against another: the mean of the paired differences over places, and half of its 95 % interval (by
  // Student's distribution). Below 0 the first is better. With one place the interval is infinite.
  struct Paired {
    double mean, half;
  };
  Paired against(ShotVariant first, ShotVariant second, int metric) const;
  std::vector<double> by_place(ShotVariant variant, int metric) const;
};
void take_means(ShotStudy* study);

// What the study must show.
std::vector<Verdict> shot_verdicts(const ShotStudy& study);

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

// `sandglass_lab verify shot`: compares composites with a path traced truth, and the sand's own shadow with cast rays.
#include <algorithm>
#include <cstdio>
#include <utility>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/program/command_line.h"
#include "models/work/progress.h"
#include "tests/laboratory/shot/verify_shot.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

// The panoramas of the options, or the data folder's interiors.
std::vector<std::string> chosen_panoramas(const VerifyOptions& options) {
  if (!options.panoramas.empty()) return find_panoramas(options.panoramas);
  if (data_folder().empty()) throw no_panoramas("shots");
  return find_panoramas({data_folder() + "/hdri/indoor", data_folder() + "/hdri/studio"});
}

uint32_t judge_pile_shadow(const std::vector<PileShadowError>& lights, std::vector<Measurement>* measurements) {
  const PileShadowError whole = whole_of(lights);
  const bool pass = holds(whole);
  if (!pass) std::printf("FAIL: the shadow of the sand\n");
  const std::pair<const char*, const PileShadowError::Part*> parts[] = {
      {"clear floor", &whole.clear}, {"floor among grains", &whole.among_grains}, {"on the sand", &whole.on_sand}};
  for (const auto& [name, part] : parts) {
    Measurement row;
    row.suite = "shot", row.scene = "shadow of the sand, " + std::string(name), row.metric = "RMSE of visibility";
    row.isa = "automatic", row.value = part->rmse;
    row.judgement = Measurement::Judgement{0.0, part->without, pass, false};
    measurements->push_back(row);
  }
  return pass ? 0 : 1;
}

ShotStudy study_pictures(const VerifyOptions& options) {
  ShotStudyOptions study;
  study.panoramas = chosen_panoramas(options);
  study.network = options.network.empty() ? shipped_light_network() : options.network;
  if (options.quick) study.picture.samples = 3, study.picture.paths = 96;
  study.folder = options.out, study.picture.threads = options.threads, study.seed = options.seed;
  study.manifest =
      options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
  if (study.network.empty()) std::printf("no lighting network: without estimates\n");
  Progress progress("compositing and tracing views", study.panoramas.size());
  return study_shots(study, [&](size_t done) {
    progress.done(done);
    return !interrupted();
  });
}

}  // namespace

std::vector<Verdict> check_pictures(const VerifyOptions& options) {
  const ShotStudy study = study_pictures(options);
  if (interrupted()) return {};
  std::printf("%s\n", shot_study_text(study).c_str());
  return shot_verdicts(study);
}

int verify_shot_command(const VerifyOptions& options) {
  const ShotStudy result = study_pictures(options);
  if (interrupted()) return k_exit_interrupted;
  std::vector<Measurement> measurements;
  const std::vector<Verdict> verdicts = shot_verdicts(result);
  for (const Measurement& row : measurements_of("shot", "automatic", options.threads, verdicts))
    measurements.push_back(row);
  uint32_t failed = count_failed(verdicts);
  const std::vector<PileShadowError> pile = study_pile_shadow();
  failed += judge_pile_shadow(pile, &measurements);
  const std::string text = shot_study_text(result) + "\n" + pile_shadow_text(pile);
  std::fputs(text.c_str(), stdout);
  print_verdicts(verdicts);
  if (!options.out.empty()) write_file(options.out + "/shot.md", text);
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements));
  return failed > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host

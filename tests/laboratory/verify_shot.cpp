// `sandglass_lab verify shot`: compares composites with a path traced truth.
#include <cstdio>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
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

}  // namespace

int verify_shot_command(const VerifyOptions& options) {
  ShotVerdictOptions shots;
  shots.panoramas = chosen_panoramas(options);
  shots.network = options.network.empty() ? shipped_light_network() : options.network;
  if (options.quick) shots.picture.samples = 3, shots.picture.paths = 96;
  shots.picture.threads = options.threads;
  shots.seed = options.seed;
  shots.manifest =
      options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
  if (shots.network.empty()) std::printf("no lighting network: without estimates\n");
  std::vector<Verdict> rows;
  {
    Progress progress("compositing and tracing views", shots.panoramas.size());
    rows = verify_shots(shots, [&](size_t done) {
      progress.done(done);
      return !interrupted();
    });
  }
  if (interrupted()) return k_exit_interrupted;
  print_verdicts(rows);
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("shot", "automatic", options.threads, rows)));
  return count_failed(rows) > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host

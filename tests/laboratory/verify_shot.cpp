// The suites of `sandglass_lab verify` that compare pictures with path traced ones: shot, colour and look.
#include "tests/laboratory/shot/verify_shot.h"
#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/work/progress.h"
#include "tests/laboratory/shot/look_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

int study(const VerifyOptions& options, const char* suite, const std::vector<std::string>& panoramas,
          ShotPictureOptions picture, decltype(&verify_shots) verify) {
  picture.threads = options.threads;
  const std::string network = options.network.empty() ? shipped_light_network() : options.network;
  std::vector<Verdict> rows;
  {
    Progress progress("compositing and tracing views", panoramas.size());
    rows = verify({panoramas, manifest_of(options), options.seed, picture, network}, [&](size_t done) {
      progress.done(done);
      return !interrupted();
    });
  }
  return interrupted() ? k_exit_interrupted : tell(options, suite, "automatic", rows);
}

}  // namespace

int verify_shot_command(const VerifyOptions& options) {
  ShotPictureOptions picture = {160, 120, 4, 256};
  if (options.quick) picture.samples = 3, picture.paths = 96;
  return study(options, "shot", panoramas_of(options, "shots"), picture, verify_shots);
}

int verify_colour_command(const VerifyOptions& options) {
  ShotPictureOptions picture = {320, 240, 3, 96};
  if (options.quick) picture.width = 160, picture.height = 120;
  std::vector<std::string> furnished;  // with a floor that is seen
  for (const char* name : {"aerodynamics_workshop", "anniversary_lounge", "artist_workshop", "comfy_cafe", "hotel_room",
                           "lebombo", "lythwood_room", "thatch_chapel", "vestibule", "vintage_measuring_lab"})
    furnished.push_back("indoor/" + std::string(name) + "_1k.hdr");
  return study(options, "colour", panoramas_of(options, "colours", furnished), picture, verify_colours);
}

int verify_look_command(const VerifyOptions& options) {
  std::vector<Verdict> rows;
  {
    Progress progress("tracing views", 1);
    rows = verify_look({options.quick, options.picture, options.threads}, [&](size_t done, size_t all) {
      progress.total(all);
      progress.done(done);
      return !interrupted();
    });
  }
  if (interrupted()) return k_exit_interrupted;
  if (!options.plain.empty()) write_file(options.plain, jpeg_file(plain_picture(options.threads), 85));
  return tell(options, "look", "automatic", rows);
}

}  // namespace sandglass::host

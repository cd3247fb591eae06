// The suites of `sandglass_lab verify` that compare pictures with path traced ones: shot and colour.
#include "tests/laboratory/shot/verify_shot.h"
#include "models/compositing/light_estimate.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

int study(const VerifyOptions& options, const char* suite, const std::vector<std::string>& panoramas,
          ShotPictureOptions picture, decltype(&verify_shots) verify) {
  picture.threads = options.threads;
  const std::string network = options.network.empty() ? shipped_light_network() : options.network;
  const auto rows = with_progress("compositing and tracing views", [&](const auto& go_on) {
    return verify({panoramas, manifest_of(options), options.seed, picture, network},
                  [&](size_t done) { return go_on(done, panoramas.size()); });
  });
  return interrupted() ? k_exit_interrupted : tell(options, suite, "automatic", rows);
}

Options options_of(VerifyOptions& o) {
  return {panoramas_option(o),
          manifest_option(o),
          network_option(o, "Network that estimates the light"),
          {"--quick", &o.quick, "", "Fewer rays: minutes, with errors that are a little larger"},
          seed_option(o.seed, "Where the cameras look, and how the phone sways"),
          threads_option(o.threads),
          json_option(o.json)};
}

int run_shot(const VerifyOptions& options) {
  ShotPictureOptions picture = {160, 120, 4, 256};
  if (options.quick) {
    picture.samples = 3;
    picture.paths = 96;
  }
  return study(options, "shot", panoramas_of(options, "shots"), picture, verify_shots);
}

int run_colour(const VerifyOptions& options) {
  ShotPictureOptions picture = {320, 240, 3, 96};
  if (options.quick) {
    picture.width = 160;
    picture.height = 120;
  }
  std::vector<std::string> furnished;  // with a floor that is seen
  for (const char* name : {"aerodynamics_workshop", "anniversary_lounge", "artist_workshop", "comfy_cafe", "hotel_room",
                           "lebombo", "lythwood_room", "thatch_chapel", "vestibule", "vintage_measuring_lab"})
    furnished.push_back("indoor/" + std::string(name) + "_1k.hdr");
  return study(options, "colour", panoramas_of(options, "colours", furnished), picture, verify_colours);
}

}  // namespace

Command verify_shot_suite() {
  return command<VerifyOptions>("shot", "Whole pictures: composites against path traced truth", options_of, run_shot);
}

Command verify_colour_suite() {
  return command<VerifyOptions>("colour",
                                "Whether what is put into a room has the room's colour, against a path traced truth",
                                options_of, run_colour);
}

}  // namespace sandglass::host

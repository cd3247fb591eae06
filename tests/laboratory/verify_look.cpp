// `sandglass_lab verify look`: drawn sand against path traced grains.
#include "models/files/atomic_file.h"
#include "tests/laboratory/shot/look_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

struct LookSuite : VerifyOptions {
  std::string picture, plain;
};

Options options_of(LookSuite& o) {
  return {{"--quick", &o.quick, "", "One light, one distance"},
          {"--picture", &o.picture, "FILE", "PNG of every view: drawn on the left, traced on the right"},
          {"--plain", &o.plain, "FILE", "JPEG: the pile by the kit on the left, by plain.frag on the right"},
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const LookSuite& options) {
  const auto rows = with_progress("tracing views", [&](const auto& go_on) {
    return verify_look({options.quick, options.picture, options.threads}, go_on);
  });
  if (interrupted()) return k_exit_interrupted;
  if (!options.plain.empty()) write_file(options.plain, jpeg_file(plain_picture(options.threads), 85));
  return tell(options, "look", "automatic", rows);
}

}  // namespace

Command verify_look_suite() {
  return command<LookSuite>("look", "Drawn sand against path traced grains; how its speckle moves", options_of, run);
}

}  // namespace sandglass::host

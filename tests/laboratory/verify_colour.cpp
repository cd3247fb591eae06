// `sandglass_lab verify colour`: the colour of what is put into a room, composited beside path traced.
#include <cstdio>

#include "models/compositing/light_estimate.h"
#include "models/files/atomic_file.h"
#include "models/lighting/dataset.h"
#include "models/program/command_line.h"
#include "models/work/progress.h"
#include "tests/laboratory/shot/colour_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

int verify_colour_command(const VerifyOptions& options) {
  ColourOptions colours;
  if (options.panoramas.empty() && data_folder().empty()) throw no_panoramas("colours");
  std::vector<std::string> names = options.panoramas;
  if (names.empty())  // furnished rooms, with a floor that is seen
    for (const char* name :
         {"aerodynamics_workshop", "anniversary_lounge", "artist_workshop", "comfy_cafe", "hotel_room", "lebombo",
          "lythwood_room", "thatch_chapel", "vestibule", "vintage_measuring_lab"})
      names.push_back(data_folder() + "/hdri/indoor/" + name + "_1k.hdr");
  colours.panoramas = find_panoramas(names);
  colours.network = options.network.empty() ? shipped_light_network() : options.network;
  if (options.quick) colours.picture.width = 160, colours.picture.height = 120;
  colours.picture.threads = options.threads;
  colours.seed = options.seed;
  colours.manifest =
      options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
  std::vector<Verdict> rows;
  {
    Progress progress("compositing and tracing rooms", colours.panoramas.size());
    rows = verify_colours(colours, [&](size_t done) {
      progress.done(done);
      return !interrupted();
    });
  }
  if (interrupted()) return k_exit_interrupted;
  print_verdicts(rows);
  std::printf("%zu rows, %u failed\n", rows.size(), count_failed(rows));
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("colour", "automatic", options.threads, rows)));
  return count_failed(rows) > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host

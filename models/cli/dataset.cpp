// `sandglass dataset PANORAMAS -o DIR`: training pairs for the lighting network.
#include <cstdio>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/progress.h"
#include "models/lighting/dataset.h"

namespace sandglass::host {

void add_dataset_command(Command& program, int* exit_code) {
  constexpr int k_exit_interrupted = 130;
  const auto options = std::make_shared<DatasetOptions>();
  Command command = program.add_subcommand("dataset", "Cut camera images and light labels out of HDR panoramas");
  command->add_option("panoramas", options->panoramas, ".hdr or .exr files, or folders of them")->required();
  command->add_option("-o,--output", options->folder, "Folder to write images, manifest.csv and sheet.png to")
      ->required();
  command->add_option("--manifest", options->manifest, "CSV with file, group and fold: which panoramas share a place");
  command->add_option("--seed", options->seed, "Equal seeds give equal views")->capture_default_str();
  command->add_option("--tiles", options->tiles, "Excerpts on the contact sheet")->capture_default_str();
  command->add_option("--threads", options->threads, "Threads; the result does not depend on them")
      ->check(range(1u, 256u))
      ->capture_default_str();
  command->callback([options, exit_code] {
    listen_for_interrupt();
    const DatasetSummary made = make_dataset(*options);
    *exit_code = interrupted() ? k_exit_interrupted : 0;
    if (*exit_code == 0)
      std::printf("%zu excerpts of %zu panoramas in %s, %zu of them without a direction of light\n", made.excerpts,
                  made.panoramas, options->folder.c_str(), made.without_direction);
  });
}

}  // namespace sandglass::host

// `sandglass dataset PANORAMAS -o DIR`: training pairs for the lighting network.
#include <cstdio>

#include "models/lighting/dataset.h"
#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

void add_dataset_command(Command& program, const std::string& group) {
  const auto options = std::make_shared<DatasetOptions>();
  Command& command = program.add_command("dataset", "Cut camera images and light labels out of HDR panoramas", group);
  command.add("PANORAMAS", options->panoramas, "Files that end in .hdr or .exr, or folders of them").required();
  command.add("-o,--output FOLDER", options->folder, "Write images, manifest.csv and sheet.png into this folder")
      .required();
  command.add("--manifest FILE", options->manifest,
              "CSV with the columns file, group and fold: which panoramas show the same place");
  command.add("--seed N", options->seed, "Equal seeds give equal views");
  command.add("--tiles N", options->tiles, "Images on the contact sheet");
  add_threads(command, options->threads);
  command.runs([options] {
    listen_for_interrupt();
    const DatasetSummary made = make_dataset(*options);
    if (interrupted()) return k_exit_interrupted;
    std::printf("%zu images of %zu panoramas in %s; %zu of them have no direction of light\n", made.excerpts,
                made.panoramas, options->folder.c_str(), made.without_direction);
    return k_exit_done;
  });
}

}  // namespace sandglass::host

// `sandglass dataset PANORAMAS -o DIR`: training pairs for the lighting network.
#include <cstdio>

#include "models/lighting/dataset.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

int dataset_command(const DatasetOptions& options) {
  listen_for_interrupt();
  const DatasetSummary made = make_dataset(options);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu images of %zu panoramas in %s; %zu of them have no direction of light\n", made.excerpts,
              made.panoramas, options.folder.c_str(), made.without_direction);
  return k_exit_done;
}

}  // namespace sandglass::host

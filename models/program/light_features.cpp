// `sandglass light-features NETWORK DATASET -o FILE.npy`: the features that the heads of the lighting network get for
// each image of a data set, as the runtime computes them. train.py fits the heads to them.
#include <algorithm>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/files/picture_file.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

Picture mirrored(const Picture& picture) {
  Picture out = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) std::copy_n(picture.at(picture.width - 1 - x, y), 3, out.at(x, y));
  return out;
}

int write_features(const LightFeaturesOptions& options) {
  const std::string bytes = read_file(options.network, "lighting network");
  LightRunner runner({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, options.network);
  const std::vector<std::string> images = images_of_dataset(options.folder);
  const size_t copies = options.mirror ? 2 : 1;
  std::vector<float> features;
  Progress progress("running the network", copies * images.size());
  for (size_t copy = 0; copy < copies; ++copy)
    for (size_t i = 0; i < images.size() && !interrupted(); ++i) {
      const Picture picture = read_excerpt(images[i]);
      runner.run(copy == 0 ? picture.rgb : mirrored(picture).rgb);
      const std::vector<float> row = runner.features();
      features.insert(features.end(), row.begin(), row.end());
      progress.done(copy * images.size() + i + 1);
    }
  if (interrupted()) return k_exit_interrupted;
  write_npy(options.output, features, copies * images.size(), features.size() / (copies * images.size()));
  std::printf("%s: %zu rows of %zu features\n", options.output.c_str(), copies * images.size(),
              features.size() / (copies * images.size()));
  return 0;
}

}  // namespace

int light_features_command(const LightFeaturesOptions& options) {
  listen_for_interrupt();
  return write_features(options);
}

}  // namespace sandglass::host

// The small commands around the training of the lighting network: `room` makes up a room to train on, `dataset` cuts
// training pairs out of panoramas, `light-features` writes what the network's heads see, and `ceiling` measures what the
// true labels can do.
#include <algorithm>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/files/picture_file.h"
#include "models/laboratory/light/ceiling.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

std::string without_extension(const std::string& path) {
  const size_t dot = path.find_last_of('.');
  if (dot == std::string::npos || path.substr(dot) != ".hdr")
    throw cannot("write", path, "the panorama is a Radiance file", "Choose a name that ends in .hdr");
  return path.substr(0, dot);
}

Picture mirrored(const Picture& picture) {
  Picture out = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) std::copy_n(picture.at(picture.width - 1 - x, y), 3, out.at(x, y));
  return out;
}

void print(const Ceiling& ceiling, size_t rows) {
  std::printf("%zu views of %zu panoramas\n\n", ceiling.views, ceiling.panoramas);
  std::printf("%-15s %-12s %-14s %-13s %8s %8s %8s %8s %8s\n", "colours", "ambient by", "light", "contrast", "RMSE",
              "nRMSE", "siRMSE", "RMLE", "RGB deg");
  for (size_t i = 0; i < std::min(rows, ceiling.variants.size()); ++i) {
    const CeilingVariant& v = ceiling.variants[i];
    const ImageErrors& e = v.mean;
    std::printf("%-15s %-12s %-14s %-13s %8.4f %8.4f %8.4f %8.4f %8.3f\n", name_of(v.range), name_of(v.weight),
                name_of(v.radiometry), v.radiometry == Radiometry::plain ? "-" : name_of(v.contrast), e.rmse,
                e.relative, e.scale_invariant, e.logarithmic, e.angle_deg);
  }
  std::printf("\n%-15s %12s %12s %10s %10s %10s\n", "contrast", "shadow RMSE", "|o - best|", "least o", "mean o",
              "most o");
  for (int c = 0; c < k_contrasts; ++c) {
    const ContrastError& e = ceiling.contrasts[c];
    std::printf("%-15s %12.4f %12.4f %10.3f %10.3f %10.3f\n", name_of(static_cast<Contrast>(c)), e.shadow_rmse,
                e.offset, e.low, e.mean, e.high);
  }
  std::printf("%-15s %12.4f\n", "best possible", ceiling.best_contrast_rmse);
  std::printf("\nlights beyond 45 degrees from the zenith %.1f %%, beyond 70 %.1f %%, below the horizon %.1f %%\n",
              100.0 * ceiling.lights_beyond_45, 100.0 * ceiling.lights_beyond_70, 100.0 * ceiling.lights_below_horizon);
}

}  // namespace

// One procedural room as a panorama, its depth, and a picture for the eye.
int room_command(const RoomOptions& options) {
  listen_for_interrupt();
  const std::string stem = without_extension(options.output);
  if (options.width % 2 != 0)
    throw cannot("use --width", std::to_string(options.width), "a panorama is half as high as wide",
                 "Give an even number");
  const Room room = make_room(options.seed);
  RoomPanorama made = trace_room(room, {options.width, options.samples, options.threads});
  if (interrupted()) return k_exit_interrupted;
  expose(&made.radiance, room.key);
  const RadianceMap& map = made.radiance;
  // The panorama is written last, so if it exists, everything does.
  if (!options.picture.empty()) write_png(options.picture, tone_mapped_picture(map, greatest_luminance(map)));
  write_npy(stem + "_depth.npy", made.depth, static_cast<uint64_t>(map.height), static_cast<uint64_t>(map.width));
  write_hdr(options.output, map);
  std::printf("room %llu, %d x %d, brightest %.4g, depth in %s_depth.npy\n",
              static_cast<unsigned long long>(options.seed), map.width, map.height, greatest_luminance(map),
              stem.c_str());
  return 0;
}

int dataset_command(const DatasetOptions& options) {
  listen_for_interrupt();
  const DatasetSummary made = make_dataset(options);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu images of %zu panoramas in %s; %zu of them have no direction of light\n", made.excerpts,
              made.panoramas, options.folder.c_str(), made.without_direction);
  return k_exit_done;
}

// The features that the heads of the lighting network get for each image of a data set, as the runtime computes them.
// train.py fits the heads to them.
int light_features_command(const LightFeaturesOptions& options) {
  listen_for_interrupt();
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

int ceiling_command(const CeilingCommandOptions& options) {
  listen_for_interrupt();
  CeilingOptions ceiling = options.ceiling;
  ceiling.object = named_mesh(options.object).mesh;
  const Ceiling measured = measure_ceiling(ceiling);
  if (interrupted()) return k_exit_interrupted;
  print(measured, options.rows);
  return k_exit_done;
}

}  // namespace sandglass::host

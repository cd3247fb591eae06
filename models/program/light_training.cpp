// The commands around the training of the lighting network: `room` makes up a room to train on, `dataset` cuts training
// pairs out of panoramas, and `light-features` writes what the network's heads see: train.py and quantise.py fit to it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/npy.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/program/commands.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct RoomOptions {
  std::string output, picture;
  uint64_t seed = 1;
  int width = 512, samples = 64;  // of the panorama, and paths a pixel
  uint32_t threads = 1;
  bool lamps_off = false;
};

struct LightFeaturesOptions {
  std::string network, folder, output;
  bool mirror = false;
};

constexpr const char* k_panoramas = "Files that end in .hdr or .exr, or folders of them";

Options room_options(RoomOptions& o) {
  return {
      seed_option(o.seed, "Equal seeds give equal rooms"),
      output_file(o.output, "Write the panorama to this file, .hdr, with its depth beside it; or .jpg, to ship"),
      writes({"--picture", &o.picture, "FILE", "Also write a tone-mapped picture, .png"}),
      {"--width", &o.width, "N", "Width in pixels, even; the height is half of it", whole_number(16, 8192)},
      {"--samples", &o.samples, "N", "Paths a pixel", whole_number(1, 65536)},
      {"--lamps-off", &o.lamps_off, "", "By daylight alone, as the camera sees it that was exposed with lamps on"},
      threads_option(o.threads),
  };
}

Options dataset_options(DatasetOptions& o) {
  return {
      required({"PANORAMAS", &o.panoramas, "", k_panoramas}),
      fills(output(o.folder, "FOLDER", "Write images and manifest.csv into this new folder")),
      {"--manifest", &o.manifest, "FILE",
       "CSV with the columns file, group and fold: which panoramas show the same place"},
      seed_option(o.seed, "Equal seeds give equal views"),
      threads_option(o.threads),
  };
}

Options features_options(LightFeaturesOptions& o) {
  return {
      required({"NETWORK", &o.network, "", "File of the lighting network"}),
      required({"DATASET", &o.folder, "", "Folder that `sandglass dataset` made"}),
      output_file(o.output, "Write one row an image to this file, .npy"),
      {"--mirror", &o.mirror, "", "Add the rows of the mirrored images behind them"},
  };
}

std::string without_extension(const std::string& path) {
  const size_t dot = path.find_last_of('.');
  if (dot == std::string::npos || (path.substr(dot) != ".hdr" && path.substr(dot) != ".jpg"))
    throw cannot("write", path, "the panorama is a Radiance file", "Choose a name that ends in .hdr");
  return path.substr(0, dot);
}

Picture mirrored(const Picture& picture) {
  Picture out = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) std::copy_n(picture.at(picture.width - 1 - x, y), 3, out.at(x, y));
  return out;
}

}  // namespace

// What a camera makes of the room's colours with its lamps on, by a small panorama.
static Vec3 exposure_of(const Room& room, uint32_t threads) {
  const RadianceMap traced = trace_room(room, {64, 64, threads}).radiance;
  RadianceMap exposed = traced;
  expose(&exposed, room.key);
  // Its darkest pixel is not cut off.
  size_t darkest = 0;
  const auto at = [](const RadianceMap& map, size_t i) { return from_floats(map.rgb.data() + 3 * i); };
  for (size_t i = 0; 3 * i < traced.rgb.size(); ++i) {
    const Vec3 c = at(traced, i);
    if (std::min({c.x, c.y, c.z}) > 0.0 && luminance(c) < luminance(at(traced, darkest))) darkest = i;
  }
  const Vec3 before = at(traced, darkest), after = at(exposed, darkest);
  return {after.x / before.x, after.y / before.y, after.z / before.z};
}

// One procedural room as a panorama, its depth, and a picture for the eye.
static int make_room_file(const RoomOptions& options) {
  const std::string stem = without_extension(options.output), depth = stem + "_depth.npy";
  if (!options.output.ends_with(".jpg")) require_writable(depth);
  if (options.width % 2 != 0)
    throw cannot("use --width", std::to_string(options.width), "a panorama is half as high as wide",
                 "Give an even number");
  Room room = make_room(options.seed);
  const Vec3 exposure = options.lamps_off ? exposure_of(room, options.threads) : Vec3{};
  if (options.lamps_off)
    for (Emitter& lamp : room.emitters) lamp.radiance = {};  // windows have none of their own
  RoomPanorama made = trace_room(room, {options.width, options.samples, options.threads});
  if (interrupted()) return k_exit_interrupted;
  if (!options.lamps_off) expose(&made.radiance, room.key);
  for (int v = 0; v < made.radiance.height && options.lamps_off; ++v)
    for (int u = 0; u < made.radiance.width; ++u)
      made.radiance.set(u, v, product(made.radiance.colour(u, v), exposure));
  const RadianceMap& map = made.radiance;
  // The panorama is written last, so if it exists, everything does.
  if (!options.picture.empty()) write_png(options.picture, tone_mapped_picture(map, greatest_luminance(map)));
  if (options.output.ends_with(".jpg")) {
    write_kept_room(options.output, map);
    return 0;
  }
  write_npy(depth, made.depth, static_cast<uint64_t>(map.height), static_cast<uint64_t>(map.width));
  write_hdr(options.output, map);
  std::printf("room %llu, %d x %d, brightest %.4g, depth in %s\n", static_cast<unsigned long long>(options.seed),
              map.width, map.height, greatest_luminance(map), depth.c_str());
  return 0;
}

static int make_dataset_folder(const DatasetOptions& options) {
  const DatasetSummary made = make_dataset(options);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu images of %zu panoramas in %s; %zu of them have no direction of light\n", made.excerpts,
              made.panoramas, options.folder.c_str(), made.without_direction);
  return k_exit_done;
}

// The features that the heads of the lighting network get for each image of a data set, as the runtime computes them.
static int write_features(const LightFeaturesOptions& options) {
  const std::string bytes = read_file(options.network, "lighting network", k_asset_limit);
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

Command room_command() {
  return command<RoomOptions>("room", "Make up an indoor room and trace its HDR panorama", room_options,
                              make_room_file);
}
Command dataset_command() {
  return command<DatasetOptions>("dataset", "Cut camera images and light labels out of HDR panoramas", dataset_options,
                                 make_dataset_folder);
}
Command light_features_command() {
  return command<LightFeaturesOptions>("light-features", "Write what the lighting network's heads see",
                                       features_options, write_features);
}

}  // namespace sandglass::host

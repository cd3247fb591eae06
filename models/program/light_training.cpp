// The commands around the training of the lighting network: `room` makes up a room to train on, `dataset` cuts training
// pairs out of panoramas, `light-features` writes what the network's heads see, and `quantise-light` turns the trained
// network into what the runtime reads.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/npy.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/quantise.h"
#include "models/program/commands.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

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

constexpr int k_width = 256, k_height = 192;
// The most by which the byte network may differ from the float network, as a median over images: the direction in
// degrees, and colours and contrast.
constexpr double k_angle_limit_deg = 1, k_difference_limit = 0.01;

// The pictures that the manifests name. An earlier data set may have left others in a folder.
std::vector<std::string> pictures_in(const std::vector<std::string>& folders) {
  std::vector<std::string> paths;
  for (const std::string& folder : folders) {
    const std::vector<std::string> images = images_of_dataset(folder);
    paths.insert(paths.end(), images.begin(), images.end());
  }
  if (paths.size() < 4) throw cannot("use", folders.at(0), "it has fewer than 4 images", "Name larger data sets");
  std::sort(paths.begin(), paths.end());
  return paths;
}

// `count` of the paths, evenly spread, or all if there are fewer.
std::vector<std::string> spread_over(const std::vector<std::string>& paths, size_t count) {
  std::vector<std::string> chosen;
  count = std::min(count, paths.size());
  for (size_t i = 0; i < count; ++i) chosen.push_back(paths[i * paths.size() / count]);
  return chosen;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

struct Differences {
  std::vector<double> angles_deg, others, features;
};

void compare(const LightValues& truth, const LightOutputs& bytes, Differences* to) {
  double dot = 0, squares = 0, greatest = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    dot += static_cast<double>(truth[axis] * bytes.direction[axis]);
    squares += static_cast<double>(bytes.direction[axis] * bytes.direction[axis]);
    greatest = std::max({greatest, static_cast<double>(std::fabs(truth[3 + axis] - bytes.light[axis])),
                         static_cast<double>(std::fabs(truth[6 + axis] - bytes.ambient[axis]))});
  }
  to->angles_deg.push_back(std::acos(std::clamp(dot / std::sqrt(squares), -1.0, 1.0)) * 180 / M_PI);
  to->others.push_back(std::max(greatest, static_cast<double>(std::fabs(truth[9] - bytes.contrast))));
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
int room_command(const RoomOptions& options) {
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

int dataset_command(const DatasetOptions& options) {
  const DatasetSummary made = make_dataset(options);
  if (interrupted()) return k_exit_interrupted;
  std::printf("%zu images of %zu panoramas in %s; %zu of them have no direction of light\n", made.excerpts,
              made.panoramas, options.folder.c_str(), made.without_direction);
  return k_exit_done;
}

// The features that the heads of the lighting network get for each image of a data set, as the runtime computes them.
// train.py fits the heads to them.
int light_features_command(const LightFeaturesOptions& options) {
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

int quantise_light_command(const QuantiseLightOptions& options) {
  const std::vector<std::string> paths = pictures_in(options.folders);
  std::vector<std::string> to_calibrate, to_measure;
  if (options.measured.empty()) {  // every other one of the chosen pictures
    const std::vector<std::string> both = spread_over(paths, 2 * size_t{options.images});
    for (size_t i = 0; i < both.size(); ++i) (i % 2 == 0 ? to_calibrate : to_measure).push_back(both[i]);
  } else {
    to_calibrate = spread_over(paths, options.images);
    to_measure = spread_over(pictures_in(options.measured), options.images);
  }
  const LightNet net = light_net_of(read_npz(options.weights));
  LightRanges ranges;
  std::vector<std::vector<uint8_t>> calibration, images;
  std::vector<FeaturePair> pairs;  // from the calibration images
  std::vector<LightValues> truths;
  std::vector<std::vector<float>> features;
  Progress progress("running the float network", to_calibrate.size() + to_measure.size());
  for (size_t i = 0; i < to_calibrate.size() && !interrupted(); ++i) {
    calibration.push_back(read_excerpt(to_calibrate[i]).rgb);
    pairs.push_back({observe(net.trunk, calibration.back(), k_width, k_height, &ranges), {}});
    progress.done(i + 1);
  }
  for (size_t i = 0; i < to_measure.size() && !interrupted(); ++i) {
    images.push_back(read_excerpt(to_measure[i]).rgb);
    features.push_back(features_of(net.trunk, images.back(), k_width, k_height));
    truths.push_back(light_of(net, features.back()));
    progress.done(to_calibrate.size() + i + 1);
  }
  if (interrupted()) return k_exit_interrupted;
  LightFile file = quantise(net, &ranges);
  file.name = options.name;
  if (options.keep_float) file.float_parameters = float_parameters(net);
  LightRunner unfitted(light_file_bytes(file), options.output);
  for (size_t i = 0; i < pairs.size(); ++i) unfitted.run(calibration[i]), pairs[i].bytes = unfitted.features();
  fit_features(net, pairs, &file);
  LightRunner runner(light_file_bytes(file), options.output);
  Differences differences;
  for (size_t i = 0; i < images.size(); ++i) {
    compare(truths[i], runner.run(images[i]), &differences);
    const std::vector<float> bytes = runner.features();
    double error = 0, square = 0;
    for (size_t c = 0; c < bytes.size(); ++c) {
      error += std::pow(static_cast<double>(bytes[c] - features[i][c]), 2);
      square += std::pow(static_cast<double>(features[i][c]), 2);
    }
    differences.features.push_back(std::sqrt(error / square));
  }
  const double angle = quantile(differences.angles_deg, 0.5), other = quantile(differences.others, 0.5);
  file.angle_deg = static_cast<float>(angle), file.difference = static_cast<float>(other);
  const std::vector<uint8_t> bytes = light_file_bytes(file);
  write_file(options.output, std::span<const uint8_t>(bytes));
  std::printf("%s: %zu bytes, calibrated on %u images; int8 against float on %zu others:\n", options.output.c_str(),
              bytes.size(), ranges.images, images.size());
  std::printf("direction            median %.3f deg, 90th percentile %.3f, greatest %.3f (limit of the median 1)\n",
              angle, quantile(differences.angles_deg, 0.9), quantile(differences.angles_deg, 1));
  std::printf("colours, contrast    median %.4f, 90th percentile %.4f, greatest %.4f (limit of the median 0.01)\n",
              other, quantile(differences.others, 0.9), quantile(differences.others, 1));
  std::printf("features             median of the relative error %.4f\n", quantile(differences.features, 0.5));
  return angle <= k_angle_limit_deg && other <= k_difference_limit ? 0 : k_exit_check_failed;
}

}  // namespace sandglass::host

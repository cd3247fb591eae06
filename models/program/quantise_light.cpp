// `sandglass quantise-light WEIGHTS.npz --calibrate DIR -o FILE`: the trained network as the runtime reads it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/picture_file.h"
#include "models/lighting/dataset.h"
#include "models/lighting/light_runner.h"
#include "models/lighting/quantise.h"
#include "models/program/commands.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

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

int run(const QuantiseLightOptions& options) {
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

}  // namespace

int quantise_light_command(const QuantiseLightOptions& options) {
  listen_for_interrupt();
  return run(options);
}

}  // namespace sandglass::host

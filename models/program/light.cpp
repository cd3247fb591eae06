// `sandglass light IMAGE... -o DIR`: the light of photographs, as numbers and as pictures.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/files/shipped_file.h"
#include "models/lighting/light_picture.h"
#include "models/lighting/room_light.h"
#include "models/program/commands.h"
#include "models/report/report.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct LightOptions {
  std::vector<std::string> images;
  std::string folder, network = shipped_file("lights", "room.light");
  double fov_deg = 75.0;
};

Options options_of(LightOptions& o) {
  return {
      required({"IMAGES", &o.images, "", "PNG or JPEG files"}),
      fills(output(o.folder, "FOLDER", "Write a JSON file and a picture for each image into this new folder")),
      {"--fov", &o.fov_deg, "DEGREES", "Field of view across the diagonal, degrees", number(10, 170)},
      standard(k_shipped, {"--network", &o.network, "FILE", "The lighting network"}),
  };
}

namespace fs = std::filesystem;
constexpr uint8_t k_black = 8;  // of 255: all of a picture that was taken through a covered lens

// The names of the outputs, without extensions. If photographs in several folders have the same name, theirs differ.
std::vector<std::string> outputs_of(const LightOptions& options) {
  std::set<std::string> names;
  std::vector<std::string> outputs;
  for (const std::string& path : options.images) {
    const std::string stem = fs::path(path).stem().string();
    std::string name = stem;
    for (int copy = 2; !names.insert(name).second; ++copy) name = stem + "_" + std::to_string(copy);
    outputs.push_back((fs::path(options.folder) / name).string());
  }
  return outputs;
}

}  // namespace

static int run(const LightOptions& options) {
  RoomLight light(options.network);
  // A photograph that cannot be read is reported before anything is written.
  std::vector<Picture> pictures;
  for (const std::string& path : options.images) {
    pictures.push_back(read_picture(path));
    const std::vector<uint8_t>& rgb = pictures.back().rgb;
    if (std::all_of(rgb.begin(), rgb.end(), [](uint8_t value) { return value <= k_black; }))
      throw cannot("estimate the light of", path, "it is black everywhere", "Take a photograph that shows something");
  }
  const std::vector<std::string> outputs = outputs_of(options);
  Progress progress("estimating light", pictures.size());
  for (size_t i = 0; i < pictures.size() && !interrupted(); ++i) {
    sandglass_camera_image image = camera_image_of(pictures[i], options.fov_deg);
    image.pose_is_upright = 1;
    image.turn_deg = 0;
    sandglass_estimator_light world;
    try {
      world = light.estimate(image);
    } catch (const Failure& failure) {
      throw cannot("estimate the light of", options.images[i], failure.what());
    }
    const sandglass_estimator_light e = in_camera_frame(world);
    const std::string name = fs::path(outputs[i]).filename().string();
    write_png(outputs[i] + ".png", light_picture(pictures[i], e, name));
    write_file(outputs[i] + ".json", light_estimate_json(options.images[i], options.fov_deg, e, world));
    std::printf("%-24s towards the light %6.3f right %6.3f down %6.3f forward, contrast %.2f, light %.2f %.2f %.2f\n",
                name.c_str(), e.direction[0], e.direction[1], e.direction[2], e.contrast, e.light[0], e.light[1],
                e.light[2]);
    progress.done(i + 1);
  }
  return interrupted() ? k_exit_interrupted : k_exit_done;
}

Command light_command() { return command<LightOptions>("light", "Estimate the light of photographs", options_of, run); }

}  // namespace sandglass::host

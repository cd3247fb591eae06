// `sandglass room --seed S -o room.hdr`: one procedural room as a panorama, its depth, and a picture for the eye.
#include <cstdio>

#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct Options {
  uint64_t seed = 1;
  RoomRenderOptions render;
  std::string output, picture;
};

std::string without_extension(const std::string& path) {
  const size_t dot = path.find_last_of('.');
  if (dot == std::string::npos || path.substr(dot) != ".hdr")
    throw cannot("write", path, "the panorama is a Radiance file", "Choose a name that ends in .hdr");
  return path.substr(0, dot);
}

int make(const Options& options) {
  const std::string stem = without_extension(options.output);
  if (options.render.width % 2 != 0)
    throw cannot("use --width", std::to_string(options.render.width), "a panorama is half as high as wide",
                 "Give an even number");
  const Room room = make_room(options.seed);
  RoomPanorama made = trace_room(room, options.render);
  if (interrupted()) return k_exit_interrupted;
  expose(&made.radiance, room.key);
  const RadianceMap& map = made.radiance;
  // The panorama is written last: where it is, everything is.
  if (!options.picture.empty()) write_png(options.picture, tone_mapped_picture(map, greatest_luminance(map)));
  write_npy(stem + "_depth.npy", made.depth, static_cast<uint64_t>(map.height), static_cast<uint64_t>(map.width));
  write_hdr(options.output, map);
  std::printf("room %llu, %d x %d, brightest %.4g, depth in %s_depth.npy\n",
              static_cast<unsigned long long>(options.seed), map.width, map.height, greatest_luminance(map),
              stem.c_str());
  return 0;
}

}  // namespace

void add_room_command(Command& program, const std::string& group) {
  const auto options = std::make_shared<Options>();
  Command& command = program.add_command("room", "Make up an indoor room and trace its HDR panorama", group);
  command.add("--seed N", options->seed, "Equal seeds give equal rooms");
  command.add("-o,--output FILE", options->output, "Write the panorama to this file, .hdr; its depth goes beside it")
      .required();
  command.add("--picture FILE", options->picture, "Also write a tone-mapped picture, .png");
  command.add("--width N", options->render.width, "Width in pixels, even; the height is half of it")
      .checked(whole_number(16, 8192));
  command.add("--samples N", options->render.samples, "Paths a pixel").checked(whole_number(1, 65536));
  add_threads(command, options->render.threads);
  command.runs([options] {
    listen_for_interrupt();
    return make(*options);
  });
}

}  // namespace sandglass::host

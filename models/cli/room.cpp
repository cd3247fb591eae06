// `sandglass room --seed S -o room.hdr`: one procedural room as a panorama, its depth, and a picture for the eye.
#include <cstdio>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/host/failure.h"
#include "models/host/npy.h"
#include "models/host/progress.h"
#include "models/lighting/panorama_file.h"
#include "models/lighting/room_render.h"

namespace sandglass::host {

namespace {

constexpr int k_exit_interrupted = 130;

struct Options {
  uint64_t seed = 1;
  RoomRenderOptions render;
  std::string output, picture;
};

std::string without_extension(const std::string& path) {
  const size_t dot = path.find_last_of('.');
  if (dot == std::string::npos || path.substr(dot) != ".hdr")
    throw Failure("room '" + path + "': the panorama is written as Radiance; give a name that ends in .hdr");
  return path.substr(0, dot);
}

int make(const Options& options) {
  const std::string stem = without_extension(options.output);
  if (options.render.width % 2 != 0)
    throw Failure("--width is odd; a panorama is half as high as wide: give an even number");
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

void add_room_command(Command& program, int* exit_code) {
  const auto options = std::make_shared<Options>();
  Command command = program.add_subcommand("room", "Make up an indoor room and trace its HDR panorama");
  command->add_option("--seed", options->seed, "Equal seeds give equal rooms")->capture_default_str();
  command->add_option("-o,--output", options->output, "Radiance file to write; the depth goes beside it")->required();
  command->add_option("--picture", options->picture, "Also write a tone-mapped PNG");
  command->add_option("--width", options->render.width, "Pixels across; half as many down")
      ->check(range(16, 8192))
      ->capture_default_str();
  command->add_option("--samples", options->render.samples, "Paths a pixel")
      ->check(range(1, 65536))
      ->capture_default_str();
  command->add_option("--threads", options->render.threads, "Threads; the result does not depend on them")
      ->check(range(1u, 256u))
      ->capture_default_str();
  command->callback([options, exit_code] {
    listen_for_interrupt();
    *exit_code = make(*options);
  });
}

}  // namespace sandglass::host

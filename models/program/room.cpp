// `sandglass room --seed S -o room.hdr`: one procedural room as a panorama, its depth, and a picture for the eye.
#include <cstdio>

#include "models/files/failure.h"
#include "models/files/npy.h"
#include "models/program/commands.h"
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

int make(const RoomOptions& options) {
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

}  // namespace

int room_command(const RoomOptions& options) {
  listen_for_interrupt();
  return make(options);
}

}  // namespace sandglass::host

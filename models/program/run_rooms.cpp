// `sandglass run SHOT --rooms`: the same shot in several made-up rooms. Each is a run of its own; one picture has their
// sheets, one below the other.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/program/run.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr int k_rows_quality = 85;  // JPEG

}  // namespace

bool read_made_up_room(const std::string& text, uint32_t* seed, double* azimuth_deg) {
  unsigned azimuth = 0;
  int read = 0;
  const bool whole = std::sscanf(text.c_str(), "%9u:%3u%n", seed, &azimuth, &read) == 2 &&
                     static_cast<size_t>(read) == text.size() && azimuth < 360;
  *azimuth_deg = azimuth;
  return whole && text.find_first_not_of("0123456789:") == std::string::npos;
}

int run_rooms(const RunOptions& options) {
  if (!options.photo.empty() || !options.record.empty() || !options.replay.empty())
    throw Failure(
        "cannot use \"--rooms\" with --photo, --record or --replay: each of those is of one run. Leave one out.");
  std::vector<Picture> sheets;
  for (const std::string& room : options.rooms) {
    RunOptions one = options;
    one.rooms = {room};
    std::string name = "room_" + room;
    std::replace(name.begin(), name.end(), ':', '_');
    if (!options.out.empty()) one.out = (fs::path(options.out) / name).string();
    if (!one.out.empty()) make_folder(one.out);
    Run run(one);
    run.execute();
    const uint64_t hash = run.hash();
    run.finish(hash);
    std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(hash));
    if (const int exit_code = run.exit_code(hash); exit_code != k_exit_done) return exit_code;
    if (run.sheet()) sheets.push_back(*run.sheet());
  }
  if (sheets.empty()) return k_exit_done;
  const std::string rows = (fs::path(options.out) / "rooms.jpg").string();
  write_file(rows, jpeg_file(picture_grid(sheets, 1, 0), k_rows_quality));
  std::puts("rooms          rooms.jpg");
  return k_exit_done;
}

}  // namespace sandglass::host

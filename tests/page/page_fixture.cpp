// Writes the page and the CSV of a run in which every number is known into the folder that the argument names.
// page_test.py looks at them in a browser. Frame i takes 1 + i/25 ms of a budget of 4 ms, so the frames after number 75
// miss it. Every stage has its own share. Quality levels are 0, 1 and 4 in turn.
#include <cstdio>
#include <exception>

#include "models/files/atomic_file.h"
#include "models/files/image.h"
#include "models/report/report_page.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_frames = 120;

RunReport known_run() {
  RunReport run;
  run.scene = "known <run> & \"page\"";
  run.isa = "scalar";
  run.clock = "virtual";
  run.memory_bytes = 3 << 20;
  for (uint32_t i = 1; i <= k_frames; ++i) {
    FrameRow row = {};
    sandglass_frame_report& r = row.report;
    uint64_t left = 1'000'000 + 40'000 * i;
    r.frame = i;
    r.time.budget_ns = 4'000'000;
    r.time.elapsed_ns = left;
    r.time.last_unit_ns = 3'000'000;
    for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) {
      r.stages[stage] = {i + stage, 0, left / 2};  // the rest is time between the units
      left -= left / 2;
    }
    r.level = i <= 60 ? 0 : i <= 100 ? 1 : 4;
    r.sand.particles = 10;
    r.sand.grains = 160;
    row.wall_ms = 6.0;
    row.cpu_ms = 0.03 * i;
    run.frames.push_back(row);
  }
  return run;
}

// More frames than bars that fit beside each other. One frame is longer than all others.
RunReport long_run() {
  RunReport run = known_run();
  const FrameRow row = run.frames[0];
  run.frames.assign(3000, row);
  for (uint32_t i = 0; i < run.frames.size(); ++i) run.frames[i].report.frame = i + 1;
  sandglass_frame_report& late = run.frames[1233].report;
  late.time.elapsed_ns = late.stages[SANDGLASS_STAGE_GRANULAR].elapsed_ns = 3'900'000;
  return run;
}

ImageFile plain(const std::string& folder, Colour colour) {
  const std::string path = folder + "/plain.png";
  write_png(path, Picture(320, 240, colour));
  const std::string content = read_file(path, "picture");
  return {content.begin(), content.end()};
}

}  // namespace
}  // namespace sandglass::host

int main(int argc, char** argv) {
  using namespace sandglass::host;
  if (argc != 2) {
    std::fputs("usage: page_fixture FOLDER\n", stderr);
    return 2;
  }
  try {
    make_folder(argv[1]);
    const RunReport run = known_run();
    const std::vector<PageFigure> figures = {
        {"Pair", "Red before blue.", plain(argv[1], {200, 0, 0}), plain(argv[1], {0, 0, 200}), "red", "blue"},
        {"Single", "</script> is text.", jpeg_file(Picture(320, 240, {0, 150, 0}), 90), {}, "", ""}};
    write_file(std::string(argv[1]) + "/report.csv", report_csv(run));
    write_file(std::string(argv[1]) + "/report.html", report_page(run, figures, {{"hash", "0x<7>"}}));
    write_file(std::string(argv[1]) + "/long.html", report_page(long_run(), {}, {}));
    write_file(std::string(argv[1]) + "/empty.html", report_page({}, {}, {}));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "page_fixture: %s\n", error.what());
    return 2;
  }
}

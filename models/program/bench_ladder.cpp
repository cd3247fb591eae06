// `sandglass bench ladder`: the error-time plane. It has every level of the quality ladder, the default scheme with
// other sub-steps, and the dissertation's scheme.
#include <cstdio>

#include "models/drawing/plot.h"
#include "models/files/atomic_file.h"
#include "models/program/bench.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

// One series of the plane.
struct Curve {
  const char* name;
  Colour colour;
  PlotSeries::Mark mark;
  bool line;
  std::vector<BenchRow> rows;
};

struct Curves {
  Curve source_3 = {"source, 3 iterations", {110, 110, 120}, PlotSeries::Mark::ring, true, {}};
  Curve source_7 = {"source, 7 iterations", {60, 60, 66}, PlotSeries::Mark::square, true, {}};
  Curve small = {"small steps, one iteration", {28, 110, 150}, PlotSeries::Mark::disk, true, {}};
  Curve levels = {"levels of the ladder", {196, 98, 16}, PlotSeries::Mark::disk, false, {}};
};

Curves measure(const SceneTable& table, const SceneFile& column, uint32_t threads, uint32_t frames) {
  Curves curves;
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_SLOW_MOTION && !interrupted(); ++level)
    curves.levels.rows.push_back(table.row("level " + std::to_string(level) + ", " + sandglass_level_name(level),
                                           column, threads, frames, level));
  for (const uint32_t steps : {24u, 32u, 48u, 64u, 96u, 128u})
    if (!interrupted())
      curves.small.rows.push_back(
          table.row("small steps " + std::to_string(steps), small_steps(column, steps), threads, frames));
  for (const uint32_t steps : {8u, 16u, 32u, 64u})
    for (const uint32_t iterations : {3u, 7u})
      if (!interrupted())
        (iterations == 7 ? curves.source_7 : curves.source_3)
            .rows.push_back(table.row("source " + std::to_string(steps) + " x (" + std::to_string(iterations) + " + 1)",
                                      source_scheme(column, steps, iterations), threads, frames));
  return curves;
}

void draw(const Curves& curves, const std::string& folder) {
  Plot overlap, angle;
  overlap.title = "Error against time: column of 14,280 particles";
  overlap.x = angle.x = {"solver, ms a frame", 10.0, 200.0, true};
  overlap.y = {"P99 of the overlap, % of r", 0.04, 100.0, true};
  angle.title = "Angle of the pile against time";
  angle.y = {"angle, degrees", 0.0, 40.0, false};
  overlap.legend_right = false, angle.legend_right = true;
  for (const Curve* curve : {&curves.source_3, &curves.source_7, &curves.small, &curves.levels}) {
    PlotSeries series;
    series.name = curve->name, series.colour = curve->colour, series.mark = curve->mark, series.line = curve->line;
    for (const BenchRow& point : curve->rows)
      series.x.push_back(point.ms_solver), series.y.push_back(100.0 * point.overlap_p99);
    overlap.series.push_back(series);
    series.y.clear();
    for (const BenchRow& point : curve->rows) series.y.push_back(point.angle_deg);
    angle.series.push_back(series);
  }
  make_folder(folder);
  write_png(folder + "/ladder_overlap.png", draw_plot(overlap));
  write_png(folder + "/ladder_angle.png", draw_plot(angle));
  std::printf("plots          %s/ladder_overlap.png, ladder_angle.png\n", folder.c_str());
}

}  // namespace

void bench_ladder(const BenchOptions& options, Bench* bench) {
  const SceneFile column = load_scene("column14k");
  const SceneTable table(bench);
  Curves curves;
  for (const uint32_t threads : options.threads)
    if (!interrupted()) curves = measure(table, column, threads, options.frames);
  if (!options.out.empty() && !interrupted()) draw(curves, options.out);
}

}  // namespace sandglass::host

// The results of a run: recording, reports, pictures, and the page that shows them.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "models/files/atomic_file.h"
#include "models/program/commands.h"
#include "models/program/run.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

void write_reports(const std::string& folder, const RunReport& report) {
  struct Part {
    const char* file;
    std::string (*content)(const RunReport& report);
  };
  constexpr Part k_parts[] = {{"report.csv", report_csv},
                              {"trace.json", report_trace},
                              {"summary.json", report_summary_json},
                              {"summary.txt", report_summary_text}};
  Progress progress("writing reports", std::size(k_parts));
  uint64_t written = 0;
  for (const Part& part : k_parts) {
    write_file((fs::path(folder) / part.file).string(), part.content(report));
    progress.done(++written);
  }
}

// Rows for the page's table.
std::vector<std::vector<std::string>> scene_facts(const SceneFile& scene) {
  const auto text = [](double value, const char* unit) {
    char words[48];
    std::snprintf(words, sizeof words, "%.6g %s", value, unit);
    return std::string(words);
  };
  const sandglass_granular_desc& g = scene.granular;
  return {{"file", fs::path(scene.source).filename().string()},
          {"frame step", text(1e3 * scene.frame_step, "ms of simulated time")},
          {"budget a frame", text(scene.budget_ms, "ms")},
          {"particle radius", text(1e3 * scene.particle_radius, "mm")},
          {"friction, static and kinetic",
           text(static_cast<double>(g.static_friction), "and ") + text(static_cast<double>(g.kinetic_friction), "")},
          {"bodies, colliders", std::to_string(scene.bodies.size()) + " and " + std::to_string(scene.colliders.size())},
          {"seed", std::to_string(scene.seed)}};
}

}  // namespace

uint32_t Run::drawing_threads() const {
  constexpr uint32_t k_at_most = 8;
  return std::min(std::max(1u, std::thread::hardware_concurrency()), k_at_most);
}

void Run::finish(uint64_t hash) {
  if (!options_.record.empty()) {
    recording_.final_hash = hash;
    save_recording(recording_, options_.record);
  }
  if (!options_.out.empty()) write_reports(options_.out, report_);
  std::fputs(report_summary_text(report_).c_str(), stdout);
  if (report_.interrupted)
    std::printf("interrupted after %zu of %u frames; the reports cover those\n", report_.frames.size(), scene_.frames);
  if (options_.out.empty()) return;
  const PictureSet set = picture_set();
  PicturePaths paths = draw_pictures(set, snapshots_);
  if (shot_) describe_light(&paths, set.threads);
  const std::string page = (fs::path(options_.out) / "report.html").string();
  write_file(page, report_page(report_, page_content(paths.figures)));
  if (!paths.film.empty()) std::printf("film           %s\n", paths.film.c_str());
  std::printf("last frame     %s\n", paths.last.c_str());
  std::printf("contact sheet  %s\n", paths.sheet.c_str());
  for (const char* file : {"trace.json", "report.csv", "summary.json", "summary.txt"})
    std::printf("report         %s\n", (fs::path(options_.out) / file).string().c_str());
  std::printf("page           %s\n", page.c_str());
}

PictureSet Run::picture_set() const {
  PictureSet set;
  set.folder = options_.out;
  set.title = scene_.name;
  set.particle_radius = scene_.particle_radius;
  set.camera = scene_.camera;
  set.threads = drawing_threads();
  set.plain = options_.plain;
  set.film = !report_.interrupted;
  if (shot_)
    set.painter = [this](const Snapshot& snapshot, int width, int height, uint32_t threads) {
      return shot_->paint(snapshot, width, height, threads);
    };
  if (snapshots_.size() > 1) set.seconds_per_snapshot = snapshots_[1].time - snapshots_[0].time;
  return set;
}

void Run::describe_light(PicturePaths* paths, uint32_t threads) const {
  std::printf("light          %s, of %s\n", name_of(shot_->source()), shot_->surroundings().name.c_str());
  if (const double angle = shot_->angle_deg(snapshots_.back().frame); angle >= 0.0)
    std::printf("               %.1f degrees from the labels in the last frame\n", angle);
  if (shot_->surroundings().has_truth() && !interrupted()) {
    const std::vector<PageFigure> figures = beside_truth(threads);
    paths->figures.insert(paths->figures.begin(), figures.begin(), figures.end());
  }
}

// The last picture beside its truth. If its light is not that of the labels, the same instant in the labels' light
// comes first. It shows what renderer and shadow can do with the right light.
std::vector<PageFigure> Run::beside_truth(uint32_t threads) const {
  const Snapshot& last = snapshots_.back();
  const RadianceMap truth = shot_->traced(last, options_.out, threads);
  const auto file = [&](const std::string& name) {
    const std::string content = read_file((fs::path(options_.out) / (name + ".png")).string(), "picture");
    return ImageFile(content.begin(), content.end());
  };
  std::vector<PageFigure> figures;
  const auto compare = [&](const Snapshot& lit, const ShotLight& light, const std::string& name,
                           const std::string& title) {
    const std::string errors = shot_errors_text(shot_->compare(lit, light, truth, options_.out, name, threads));
    std::printf("beside truth   %s: %s\n", title.c_str(), errors.c_str());
    std::printf("               %s\n", (fs::path(options_.out) / ("beside_truth" + name + ".png")).string().c_str());
    figures.push_back({"Composite and truth: " + title, errors, file("composite" + name), file("truth"), "composite",
                       "path traced", false});
  };
  if (shot_->source() != LightSource::labels)
    compare(shot_->relit(last, shot_->labels().towards), shot_->labels(), "_labels", "lit by the true labels");
  const char* title = shot_->source() == LightSource::labels     ? "lit by the true labels"
                      : shot_->source() == LightSource::estimate ? "lit by the network's estimate"
                                                                 : "lit by an arbitrary light";
  compare(last, shot_->light(last.frame), "", title);
  return figures;
}

PageContent Run::page_content(std::vector<PageFigure> figures) const {
  PageContent content;
  content.figures = std::move(figures);
  content.tables.push_back({"Scene", "", {}, scene_facts(scene_)});
  content.tables.push_back({"Machine", "", {}, machine_facts()});
  if (shot_ && shot_->source() != LightSource::labels && shot_->surroundings().has_truth() && !report_.frames.empty()) {
    LightSeries labels = {"labels", {}};
    const Vec3 d = shot_->labels().towards;
    for (const FrameRow& row : {report_.frames.front(), report_.frames.back()}) {
      LightSample sample;
      sample.time = row.report.simulated_time, sample.direction = {d.x, d.y, d.z};
      labels.samples.push_back(sample);
    }
    content.light.push_back(std::move(labels));
  }
  return content;
}

int Run::exit_code(uint64_t hash) const {
  if (report_.interrupted || interrupted()) return k_exit_interrupted;
  const bool whole = !options_.replay.empty() && report_.frames.size() == recording_.frames.size();
  if (!whole || hash == recording_.final_hash) return k_exit_done;
  std::fprintf(stderr,
               "sandglass: cannot repeat \"%s\": its run ended in hash 0x%016llx, and this one ends in another.\n",
               options_.replay.c_str(), static_cast<unsigned long long>(recording_.final_hash));
  return k_exit_check_failed;
}

}  // namespace sandglass::host

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

constexpr int k_figure_quality = 92;  // JPEG

void write_reports(const std::string& folder, const RunReport& report) {
  constexpr std::pair<const char*, std::string (*)(const RunReport&)> k_parts[] = {
      {"report.csv", report_csv},
      {"trace.json", report_trace},
      {"summary.json", report_summary_json},
      {"summary.txt", report_summary_text}};
  for (const auto& [file, content] : k_parts) write_file((fs::path(folder) / file).string(), content(report));
}

}  // namespace

uint32_t Run::drawing_threads() const {
  constexpr uint32_t k_threads_max = 8;
  return std::min(std::max(1u, std::thread::hardware_concurrency()), k_threads_max);
}

void Run::finish(uint64_t hash) {
  // One that ends early is not what was asked for, and an older file may have that name.
  if (!options_.record.empty() && !report_.interrupted) {
    recording_.final_hash = hash;
    save_recording(recording_, options_.record);
  }
  if (!options_.out.empty()) write_reports(options_.out, report_);
  std::fputs(report_summary_text(report_).c_str(), stdout);
  if (report_.interrupted)
    std::printf("interrupted after %zu of %u frames; the reports cover those\n", report_.frames.size(), scene_.frames);
  if (options_.out.empty() || report_.frames.empty()) return;  // before the first frame there is nothing to show
  const PictureSet set = picture_set();
  PicturePaths paths = draw_pictures(set, snapshots_);
  if (shot_) describe_light(&paths, set.threads);
  const std::string page = (fs::path(options_.out) / "report.html").string();
  write_file(page, report_page(report_, paths.figures, conditions(hash)));
  std::printf("pictures       contact_sheet.png, last_frame.png, the frames%s\n",
              paths.film.empty() ? "" : " and a film");
  std::puts("page           report.html; its numbers are in report.csv, trace.json, summary.json and summary.txt");
}

PictureSet Run::picture_set() const {
  PictureSet set;
  set.folder = options_.out;
  set.title = scene_.name;
  set.particle_radius = scene_.particle_radius;
  set.camera = scene_.camera;
  set.threads = drawing_threads();
  set.film = !report_.interrupted;
  if (shot_)
    set.painter = [this](const Snapshot& snapshot, int width, int height, uint32_t threads) {
      return shot_->paint(snapshot, width, height, threads);
    };
  if (snapshots_.size() > 1) set.seconds_per_snapshot = snapshots_[1].time - snapshots_[0].time;
  return set;
}

void Run::describe_light(PicturePaths* paths, uint32_t threads) {
  std::printf("light          %s, of %s\n", name_of(shot_->source()), shot_->surroundings().name.c_str());
  if (const double angle = shot_->angle_deg(snapshots_.back().frame); angle >= 0.0)
    std::printf("               the middle of the floor's light is %.1f degrees off in the last frame\n", angle);
  if (!shot_->truth() || interrupted()) return;
  std::vector<PageFigure> figures = beside_truth(threads);
  paths->figures.insert(paths->figures.begin(), figures.begin(), figures.end());
}

// The last picture, what an app could draw instead, and the truth: a sheet, and pairs for the page.
std::vector<PageFigure> Run::beside_truth(uint32_t threads) {
  const Snapshot& last = snapshots_.back();
  const RadianceMap truth = shot_->traced(last, threads);
  const Shot::Drawn lead = shot_->drawn(last, "sandglass", shot_->light(last.frame), CastShadow::textures, threads);
  const std::vector<Shot::Drawn> beside = shot_->alternatives(last, threads);
  const auto picture = [&](const char* name, const RadianceMap& shown, uint64_t seed) {
    const Picture made = shot_->developed_as_seen(shown, seed);
    write_png((fs::path(options_.out) / name).string(), made);
    return jpeg_file(made, k_figure_quality);
  };
  const ImageFile traced = picture("truth.png", truth, 1), composite = picture("composite.png", lead.picture, 2);
  const std::string errors = shot_errors_text(shot_errors(truth, lead.picture));
  std::printf("beside truth   %-20s  %s\n", lead.name.c_str(), errors.c_str());
  std::vector<PageFigure> figures = {{"Composite and truth", errors, composite, traced, "composite", "path traced"}};
  for (const Shot::Drawn& other : beside) {
    const std::string text = shot_errors_text(shot_errors(truth, other.picture));
    std::printf("               %-20s  %s\n", other.name.c_str(), text.c_str());
    figures.push_back({"Instead: " + other.name, text,
                       jpeg_file(shot_->developed_as_seen(other.picture, 3), k_figure_quality), composite, other.name,
                       "composite"});
  }
  const std::string sheet = (fs::path(options_.out) / "shot.png").string();
  write_png(sheet, shot_->sheet(lead, beside, truth));
  std::puts("               shot.png");
  return figures;
}

// What the run was given and what it ended in, for the page.
PageFacts Run::conditions(uint64_t hash) const {
  const auto text = [](const char* format, double a, double b = 0.0) {
    char words[64];
    std::snprintf(words, sizeof words, format, a, b);
    return std::string(words);
  };
  char final_hash[32];
  std::snprintf(final_hash, sizeof final_hash, "0x%016llx", static_cast<unsigned long long>(hash));
  const sandglass_granular_desc& g = scene_.granular;
  PageFacts facts = {{"hash", final_hash},
                     {"file", fs::path(scene_.source).filename().string()},
                     {"frame step", text("%.6g ms of simulated time", 1e3 * scene_.frame_step)},
                     {"particle radius", text("%.6g mm", 1e3 * scene_.particle_radius)},
                     {"friction, static and kinetic", text("%.6g and %.6g", static_cast<double>(g.static_friction),
                                                           static_cast<double>(g.kinetic_friction))},
                     {"bodies and colliders",
                      std::to_string(scene_.bodies.size()) + " and " + std::to_string(scene_.colliders.size())},
                     {"seed", std::to_string(scene_.seed)}};
  for (const auto& fact : machine_facts()) facts.push_back(fact);
  return facts;
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

// The contact sheet comes first, so that an interrupted run has one.
#include "models/report/pictures.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_shadows.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr int k_cell_width = 640, k_cell_height = 480, k_columns = 4;
constexpr size_t k_sand_cells = 12, k_particle_cells = 4;
constexpr int k_gap = 6;  // pixels between cells
constexpr int k_large_width = 1280, k_large_height = 960;
constexpr double k_film_period = 0.04;                    // seconds; 25 pictures a second
constexpr double k_snapshot_bytes = 768.0 * 1048576.0;    // memory for all snapshots of a run
constexpr int k_page_quality = 88, k_sheet_quality = 80;  // JPEG quality
constexpr uint32_t k_pile_texels = 128;

// The shadow of the sand on itself, of one that has none of its own.
SceneShadows shadow_on_sand(const Snapshot& snapshot, const Bounds& bounds, float radius) {
  PileShadowTrack track;
  const double margin = 4.0 * static_cast<double>(radius);
  const double from[2] = {bounds.low.x, bounds.low.z}, to[2] = {bounds.high.x, bounds.high.z};
  for (int axis = 0; axis < 2; ++axis) {
    track.low[axis] = from[axis] - margin;
    track.high[axis] = to[axis] + margin;
  }
  track.texels = k_pile_texels;
  PileShadow pile(track, SANDGLASS_ISA_AUTOMATIC, k_pile_texels / 2);
  pile.set_light(snapshot.to_light);
  SandShaper().shape({snapshot.particles, {}, snapshot.colliders, radius}, pile.handle());
  SceneShadows shadows;
  pile.draw(&shadows);
  return shadows;
}

Picture draw(const PictureSet& set, const Snapshot& snapshot, const SceneView& base, bool particles, int width,
             int height) {
  if (set.painter && !particles) return set.painter(snapshot, width, height, set.threads);
  SceneView view = base;
  view.spheres = snapshot.particles;
  view.radius = static_cast<float>(set.particle_radius);
  view.colliders = snapshot.colliders;
  view.shadows = snapshot.shadows.object;
  view.to_light = snapshot.to_light;
  const bool known = !snapshot.shadows.pile_on_sand.empty() && !snapshot.shadows.sky_on_sand.empty();
  const bool glass = behind_glass(snapshot.colliders);  // sand against a wall is not as high as one column says
  const SceneShadows made =
      known || glass || particles ? SceneShadows{} : shadow_on_sand(snapshot, view.bounds, view.radius);
  if (!particles) {
    view.sand = &snapshot.sand;
    view.on_sand = known ? &snapshot.shadows : &made;
  }
  RenderOptions options;
  options.width = width;
  options.height = height;
  options.threads = set.threads;
  options.coin = true;
  return render(view, options);
}

size_t evenly(size_t index, size_t count, size_t total) {
  return count <= 1 ? total - 1 : (index * (total - 1) + (count - 1) / 2) / (count - 1);
}

std::string frame_name(size_t index) {
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06zu.png", index);
  return name;
}

// Runs ffmpeg in silence. True: it ended well. Ctrl-C ends it.
bool run_ffmpeg(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "ffmpeg");
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t silence;
  posix_spawn_file_actions_init(&silence);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&silence, stream, "/dev/null", O_RDWR, 0);
  pid_t child = -1;
  const bool begun = posix_spawnp(&child, "ffmpeg", &silence, nullptr, words.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&silence);
  if (!begun) return false;
  int status = 0;
  for (pid_t ended = 0; (ended = waitpid(child, &status, WNOHANG)) != child;) {
    if (ended < 0 && errno != EINTR) return false;
    if (interrupted()) kill(child, SIGKILL);
    constexpr useconds_t k_between_looks_us = 5'000;
    usleep(k_between_looks_us);
  }
  return status == 0;
}

// Makes the film of the frames. Its path; empty where there is none.
std::string write_film(const PictureSet& set, const std::string& frames_folder) {
  const std::string film = (fs::path(set.folder) / "film.mp4").string();
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.6g", 1.0 / set.seconds_per_snapshot);
  if (run_ffmpeg({"-v", "error", "-y", "-framerate", rate, "-i", (fs::path(frames_folder) / "frame_%06d.png").string(),
                  "-pix_fmt", "yuv420p", "-movflags", "+faststart", film}))
    return film;
  std::remove(film.c_str());
  if (!interrupted())
    std::fprintf(stderr, "sandglass: note: no film, which needs ffmpeg with an H.264 encoder. Its frames are there.\n");
  return "";
}

}  // namespace

// The figures of the report's page.
static std::vector<PageFigure> page_figures(const std::vector<Snapshot>& snapshots, const Picture& first,
                                            const Picture& last, const Picture& particles, const Picture& sheet) {
  const ImageFile last_file = jpeg_file(last, k_page_quality);
  char moments[96];
  std::snprintf(moments, sizeof moments, "The scene at %.2f s and at %.2f s.", snapshots.front().time,
                snapshots.back().time);
  std::vector<PageFigure> figures = {
      {"First and last frame", moments, jpeg_file(first, k_page_quality), last_file, "first", "last"}};
  figures.push_back(
      {"What is simulated, what is drawn",
       "Particles carry contacts and friction; the sand is drawn by the surface that they have. The coin is one euro.",
       jpeg_file(particles, k_page_quality), last_file, "particles", "sand"});
  figures.push_back({"Contact sheet",
                     "The run from left to right and top to bottom; the last row shows particles.",
                     jpeg_file(sheet, k_sheet_quality),
                     {},
                     "",
                     ""});
  return figures;
}

uint32_t snapshot_step(uint32_t frames, double frame_step, uint32_t particles) {
  constexpr double k_skin_bytes = 90.0;  // a particle
  const double bytes = (12.0 + k_skin_bytes) * particles * frames;
  const double step = std::max({1.0, std::round(k_film_period / frame_step), std::ceil(bytes / k_snapshot_bytes)});
  return static_cast<uint32_t>(step);
}

// The snapshots that the sheet shows.
static std::vector<Snapshot> moments(const std::vector<Snapshot>& snapshots) {
  const size_t count = std::min(k_sand_cells, snapshots.size());
  std::vector<Snapshot> few;
  for (size_t i = 0; i < count; ++i) few.push_back(snapshots[evenly(i, count, snapshots.size())]);
  return few;
}

std::string frames_folder(const std::string& folder) { return (fs::path(folder) / "frames").string(); }

PicturePaths draw_pictures(const PictureSet& set, const std::vector<Snapshot>& snapshots) {
  PicturePaths paths;
  if (snapshots.empty()) return paths;
  if (!set.film && snapshots.size() > k_sand_cells) return draw_pictures(set, moments(snapshots));
  SceneView view;
  std::vector<Bounds> boxes;
  for (const Snapshot& snapshot : snapshots) {
    boxes.emplace_back().add_inner(snapshot.particles);
    if (boxes.back().empty()) continue;
    view.bounds.add(boxes.back().low);
    view.bounds.add(boxes.back().high);
  }
  if (view.bounds.empty()) throw cannot("draw", set.title, "no particle has a finite position", "Report this");
  view.camera = set.camera ? *set.camera : automatic_camera(boxes, static_cast<double>(k_cell_width) / k_cell_height);

  const size_t total = snapshots.size();
  Progress progress("drawing", total + k_particle_cells + 2);
  uint64_t drawn = 0;
  std::vector<Picture> film(total), cells;
  const auto film_picture = [&](size_t i) -> const Picture& {
    if (film[i].width == 0) {
      film[i] = draw(set, snapshots[i], view, false, k_cell_width, k_cell_height);
      progress.done(++drawn);
    }
    return film[i];
  };
  const size_t sand_cells = std::min(k_sand_cells, total), particle_cells = std::min(k_particle_cells, total);
  for (size_t i = 0; i < sand_cells; ++i) cells.push_back(film_picture(evenly(i, sand_cells, total)));
  while (cells.size() % k_columns != 0) cells.emplace_back(k_cell_width, k_cell_height, Colour{255, 255, 255});
  for (size_t i = 0; i < particle_cells; ++i) {
    cells.push_back(draw(set, snapshots[evenly(i, particle_cells, total)], view, true, k_cell_width, k_cell_height));
    progress.done(++drawn);
  }
  paths.sheet = (fs::path(set.folder) / "contact_sheet.png").string();
  const Picture sheet = picture_grid(cells, k_columns, k_gap);
  write_png(paths.sheet, sheet);
  paths.last = (fs::path(set.folder) / "last_frame.png").string();
  write_png(paths.last, draw(set, snapshots.back(), view, false, k_large_width, k_large_height));
  progress.done(++drawn);
  paths.figures = page_figures(snapshots, film_picture(0), film_picture(total - 1), cells.back(), sheet);
  progress.done(++drawn);

  if (!set.film || interrupted()) return paths;
  const std::string folder = frames_folder(set.folder);
  make_folder(folder);
  for (size_t i = 0; i < total; ++i) {
    if (interrupted()) return paths;
    write_png((fs::path(folder) / frame_name(i)).string(), film_picture(i));
    film[i] = {};
  }
  paths.film = write_film(set, folder);
  return paths;
}

}  // namespace sandglass::host

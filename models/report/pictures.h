// Pictures of a run: a contact sheet (twelve moments of the sand, below them four of the particles), a large picture
// of the last frame, pairs for the report's page, the film's frames as PNG, and the film, an MP4, where the program
// ffmpeg is there to make it. One fixed camera serves the whole run.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "models/drawing/render.h"
#include "models/report/report_page.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct Snapshot {
  uint32_t frame = 0;  // 0 is the state before the first frame
  double time = 0.0;   // seconds
  SandShape sand;
  std::vector<float> particles;  // those that are not there any more: not a number
  std::vector<sandglass_collider> colliders;
  SceneShadows shadows;
  Vec3 to_light = k_sun;
};

// The number of frames from one snapshot to the next, so that the snapshots play smoothly and fit into memory.
uint32_t snapshot_step(uint32_t frames, double frame_step, uint32_t particles);

struct PictureSet {
  std::string folder, title;
  double particle_radius = 0.01, seconds_per_snapshot = 0.04;
  std::optional<Camera> camera;
  uint32_t threads = 4;
  bool film = true;  // without a film, only the sheet's moments are drawn
  // If set, this function draws the pictures of sand instead of render.h.
  std::function<Picture(const Snapshot& snapshot, int width, int height, uint32_t threads)> painter;
};

struct PicturePaths {
  std::string sheet, last, film;  // film: empty without a film, without ffmpeg, and after Ctrl-C
  // First and last frame; particles and sand; the sheet.
  std::vector<PageFigure> figures;
};

// Where draw_pictures puts the frames of the film.
std::string frames_folder(const std::string& folder);

// Draws everything into set.folder. After the sheet and the last frame, Ctrl-C ends the drawing after the current
// picture. Every file that is there is complete.
PicturePaths draw_pictures(const PictureSet& set, const std::vector<Snapshot>& snapshots);

}  // namespace sandglass::host

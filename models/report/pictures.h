// Pictures of a run: a contact sheet (twelve moments of the grains, four of the particles under them), the last frame
// large, pairs for the report's page, the film's frames as PNG, and the film as MP4 by the ffmpeg program or as GIF
// without it. One fixed camera for the whole run.
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
  std::vector<float> grains, particles;
  std::vector<sandglass_collider> colliders;
  std::vector<FloorShadow> shadows;
  std::vector<FloorShadow> pile, pile_surface;  // the sand's own shadow: on the floor, and on itself
  Vec3 to_light;                                // of length 0: none in the scene
};

// Every how many frames a snapshot is due, so that a run's snapshots play smoothly and fit into memory.
uint32_t snapshot_step(uint32_t frames, double frame_step, uint32_t particles, uint32_t grains);

struct PictureSet {
  std::string folder, title;
  double particle_radius = 0.01, seconds_per_snapshot = 0.04;
  std::optional<Camera> camera;
  uint32_t threads = 4;
  bool plain = false;  // without label, ruler and checker
  bool film = true;    // without a film, only the moments of the sheet are looked at
  // Draws the grains of a snapshot instead of the renderer of render.h, if it is set.
  std::function<Picture(const Snapshot& snapshot, int width, int height, uint32_t threads)> painter;
};

struct PicturePaths {
  std::string sheet, last, film;    // film empty without, and when interrupted
  std::vector<PageFigure> figures;  // first and last frame, grains and particles, with and without shadow; the sheet
};

// Draws everything into set.folder. Ctrl-C ends the drawing after the picture that is being made. What is there then is
// complete.
PicturePaths draw_pictures(const PictureSet& set, const std::vector<Snapshot>& snapshots);

}  // namespace sandglass::host

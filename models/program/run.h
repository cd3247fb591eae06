// One run of a scene, for `sandglass run`: it starts and executes its frames (run.cpp), and writes
// what came of them (run_results.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "models/compositing/shot.h"
#include "models/files/failure.h"
#include "models/phones/phone.h"
#include "models/program/commands.h"
#include "models/report/pictures.h"
#include "models/report/report.h"
#include "models/report/report_page.h"
#include "models/simulation/recording.h"
#include "models/simulation/scene_file.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"
#include "models/work/thread_pool.h"
#include "platform/virtual_clock.h"

namespace sandglass::host {

struct RunOptions {
  std::string scene, mesh, collider_mesh, clock = "real", isa = "automatic", record, replay, out;
  std::string panorama, later, photo, asset, light;
  uint32_t frames = 0, threads = 1;  // frames 0: the scene's
  double budget_ms = -1.0;           // below 0: the scene's
  double fov_deg = 0.0;
  MeshOptions as_mesh;
  std::string as;  // a core of models/phones, or empty
};

class Run {
 public:
  // Loads the scene, fills it, and is ready for the first frame.
  // `finest_level`: quality levels better than this are not used.
  explicit Run(const RunOptions& options, uint32_t finest_level = 0);

  void execute();
  uint64_t hash() const;  // of every active stage
  // Writes recording, reports and pictures, as the options ask for.
  void finish(uint64_t hash);
  int exit_code(uint64_t hash) const;
  const RunReport& report() const { return report_; }
  const PhoneClock* phone() const { return phone_ ? &*phone_ : nullptr; }

 private:
  void load_replay();
  void expect_start(uint64_t start_hash);
  Failure of_another_scene() const;
  void replace_shadow();
  void take_shot();
  sandglass_scene_desc describe(const Material& material, sandglass_isa isa);
  void begin_report();
  void take_snapshot(uint32_t frame, std::vector<sandglass_collider> colliders);

  void light_shadows(uint32_t frame);  // turns them to the frame's light
  sandglass_frame_report advance(uint32_t frame, std::vector<sandglass_collider>* colliders);

  uint32_t drawing_threads() const;
  PictureSet picture_set() const;
  void describe_light(PicturePaths* paths, uint32_t threads);
  std::vector<PageFigure> beside_truth(uint32_t threads);
  PageFacts conditions(uint64_t hash) const;

  const RunOptions& options_;
  const uint32_t finest_level_;
  SceneFile scene_;
  VirtualClock virtual_time_;
  std::optional<PhoneClock> phone_;
  TraceRecorder recorder_;
  std::optional<CollisionFields> fields_;
  std::optional<ThreadPool> pool_;
  std::optional<Simulation> simulation_;
  std::optional<StandingShadows> shadows_;
  std::optional<PileShadow> pile_, drawn_pile_;  // the frames', of their grains, and that of the pictures' skin
  SandShaper shaper_;                            // of the pictures: the frames make no skin
  std::optional<Shot> shot_;
  RunReport report_;
  std::vector<Snapshot> snapshots_;
  Recording recording_;  // --replay: what to execute; --record: what was executed
};

}  // namespace sandglass::host

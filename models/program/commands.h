// The commands of the program: the options of each, and what it does with them. Each function returns the exit code.
// command_options.cpp declares the options for the command line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/files/shipped_file.h"
#include "models/lighting/dataset.h"
#include "models/mesh/mesh.h"
#include "models/program/command_line.h"
#ifdef SANDGLASS_HAVE_BAKE
#include "models/baking/bake.h"
#endif

namespace sandglass::host {

// What --scale and --up say of mesh files.
struct MeshOptions {
  double scale = 1.0;
  std::string up = "y";
  MeshUnits units() const { return {scale, up == "z"}; }
};

struct RunOptions {
  std::string scene, mesh, collider_mesh, clock = "real", isa = "automatic", record, replay, out;
  std::string panorama, later, photo, asset, light;
  uint32_t frames = 0, threads = 1;  // frames 0: the scene's
  double budget_ms = -1.0;           // below 0: the scene's
  double fov_deg = 0.0;
  MeshOptions as_mesh;
  std::string as;  // a core of models/phones, or empty
};
int run_command(const RunOptions& options);

struct BudgetOptions {
  std::string scene, mesh;
  uint32_t frames = 0;  // 0: the scene's
};
int budget_command(const BudgetOptions& options);

struct LightOptions {
  std::vector<std::string> images;
  std::string folder, network = shipped_file("lights", "room.light");
  double fov_deg = 75.0;
};
int light_command(const LightOptions& options);

struct InspectOptions {
  std::string file;
  MeshOptions as_mesh;
};
int inspect_command(const InspectOptions& options);

struct SampleOptions {
  std::string mesh;     // a file, or the name of a generated mesh
  std::string where;    // "surface", "volume" or "lattice"
  double distance = 0;  // metres
  uint64_t seed = 1;
  std::string picture, output;
  MeshOptions as_mesh;
};
int sample_command(const SampleOptions& options);

struct RoomOptions {
  std::string output, picture;
  uint64_t seed = 1;
  int width = 512, samples = 64;  // of the panorama, and paths a pixel
  uint32_t threads = 1;
  bool lamps_off = false;
};
int room_command(const RoomOptions& options);

int dataset_command(const DatasetOptions& options);

struct LightFeaturesOptions {
  std::string network, folder, output;
  bool mirror = false;
};
int light_features_command(const LightFeaturesOptions& options);

#ifdef SANDGLASS_HAVE_BAKE
struct BakeOptions {
  std::string mesh, output, json;
  BakeSettings settings;
  MeshOptions as_mesh;
  bool quick = false;
};
int bake_command(const BakeOptions& options);
#endif

}  // namespace sandglass::host

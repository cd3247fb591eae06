// From a mesh to a baked shadow: trace, train, round, validate, write. Interrupted, it leaves a checkpoint beside the
// output, from which it goes on to the same bytes.
#pragma once

#include <cstdint>
#include <string>

#include "models/baking/trainer.h"
#include "models/baking/validate.h"

namespace sandglass::host {

struct BakeSettings {
  NetworkShape shape;
  PlaneRule plane = PlaneRule::fitted;
  double angular_diameter = 20, polar_max = 70;  // degrees
  uint64_t seed = 1;
  uint32_t threads = 1;
  uint32_t textures = 301;   // rays as for so many whole textures of 256 x 256 (6.19)
  uint32_t steps = 400'000;  // of training in float
  uint32_t quantised_steps = 10'000;
  uint32_t batch = 2048;
  double rate = 3e-3;  // of learning, at the start
  uint32_t validation_lights = 1000;
  bool keep_float = false;  // the file carries the float network too, for measurements
};

struct BakeReport {
  bool interrupted = false;
  Validation validation;
  struct Stage {
    double seconds = 0, cpu_seconds = 0;  // of this run; CPU time of all threads
  };
  Stage tracing, training, rounding, validating;  // rounding: the steps with rounded weights
  uint64_t file_bytes = 0;
  double ms_full = 0, ms_adaptive = 0;  // a texture, one thread of this machine
};

// `picture`: a PNG beside the file; empty: none. Failures are sentences.
BakeReport bake(const Mesh& mesh, const std::string& name, const BakeSettings& settings, const std::string& output,
                const std::string& picture, bool resume);

// The light and plane of a mesh as the settings say; also what the benchmark traces its truth with.
LightGeometry light_geometry(const Mesh& mesh, const std::string& name, const BakeSettings& settings);

}  // namespace sandglass::host

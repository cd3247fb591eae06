// From a mesh to a baked shadow: trace, train, round, validate, write. An interrupted bake writes nothing.
#pragma once

#include <cstdint>
#include <string>

#include "models/baking/bake_ambient.h"
#include "models/baking/trainer.h"
#include "models/baking/validate.h"

namespace sandglass::host {

struct BakeSettings {
  NetworkShape shape;
  double angular_diameter = 20, polar_max = 70;  // degrees
  uint64_t seed = 1;
  uint32_t threads = 1;
  // The bake traces as many rays as this many whole textures of 256 x 256 need, (6.19) of the dissertation.
  uint32_t textures = 301;
  uint32_t steps = 400'000;  // training steps in float
  uint32_t quantised_steps = 10'000;
  uint32_t batch = 2048;
  uint32_t validation_lights = 1000;
  bool keep_float = false;  // the file also holds the float network, for measurements
  AmbientSettings ambient;
};

struct BakeReport {
  bool interrupted = false;
  Validation validation;
  struct Stage {
    double seconds = 0, cpu_seconds = 0;  // CPU time of all threads
  };
  Stage tracing, training, rounding, validating;  // rounding: the steps with rounded weights
  Stage ambient_stage;
  AmbientReport ambient;
  uint64_t file_bytes = 0;
  double ms_full = 0, ms_adaptive = 0;  // CPU time of one texture on this machine (median)
};

// A rough bake of some seconds: a hundredth of the steps and rays, to see whether the mesh and its light are what was meant.
void make_quick(BakeSettings* settings);

// `picture` is the path of a PNG to write; empty: no picture. Throws a Failure with a sentence.
BakeReport bake(const Mesh& mesh, const std::string& name, const BakeSettings& settings, const std::string& output,
                const std::string& picture);

// The light and the plane of a mesh, from the settings. The benchmark traces its truth with the same geometry.
LightGeometry light_geometry(const Mesh& mesh, const std::string& name, const BakeSettings& settings);

}  // namespace sandglass::host

// The part of a bake that needs no training: the ambient shadow and the surface, traced, put into bytes and measured.
#pragma once

#include <string>
#include <vector>

#include "models/baking/ambient_errors.h"
#include "models/baking/shadow_file.h"

namespace sandglass::host {

struct AmbientSettings {
  uint32_t texels = 128;  // a side; 0: neither ambient shadow nor surface
  uint32_t components = 24;
  uint32_t rooms = 8;  // made-up rooms that the error is measured in
  std::string data;    // folder of captured rooms that it is measured in too; empty: none
};

struct AmbientReport {
  AmbientErrors made_up, captured;
  uint32_t components = 0, points = 0;
  double ms = 0;  // CPU time of one texture on this machine (median)
};

// Fills file->ambient and file->surface, and the pictures of two rooms. Returns false where the user interrupted it.
bool bake_ambient(const AmbientSettings& settings, uint64_t seed, uint32_t threads, ShadowFile* file,
                  AmbientReport* report, std::vector<Picture>* pictures);

}  // namespace sandglass::host

// The pairs that a network learns from: textures for a set of lights, each in the rectangle of its own light.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/shadow/truth.h"

namespace sandglass::host {

// What a light's texture is about.
struct LightGeometry {
  StandingObject object;
  PlaneRule plane = PlaneRule::fitted;
  double half_angle = 0, polar_max = 0;  // radians

  ShadowRectangle rectangle(const Direction& light) const;
};

struct TrainingSet {
  uint32_t size = 0;  // texels a side
  std::vector<Direction> lights;
  std::vector<uint16_t> texels;    // transparency times 65535, texture after texture
  std::vector<uint32_t> penumbra;  // indices of texels that are neither lit nor dark, nor next to such a one

  double transparency(uint64_t index) const { return texels[index] * (1.0 / 65535); }
};

// Traces texture after texture, beginning behind those that `set` holds; `go_on` is asked after each with the number
// done. False: interrupted, with whole textures.
bool trace_training_set(const LightGeometry& geometry, const ShadowCaster& caster, ThreadPool& pool,
                        const std::function<bool(uint32_t)>& go_on, TrainingSet* set);

// Fills `penumbra`.
void find_penumbra(TrainingSet* set);

}  // namespace sandglass::host

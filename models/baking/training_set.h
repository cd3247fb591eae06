// The pairs that a network learns from: texels of textures for a set of lights, each in the rectangle of its own light.
//
// The source takes every texel of 301 textures (6.19). The same number of rays teaches more when it is spread over more
// lights: of each cell of stride x stride texels one is traced, another one for every light, and there are stride^2
// times as many lights. (Measured on the armadillo, README: the error over unseen lights falls by a third.)
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/baking/truth.h"

namespace sandglass::host {

// What a light's texture is about.
struct LightGeometry {
  StandingObject object;
  PlaneRule plane = PlaneRule::fitted;
  double half_angle = 0, polar_max = 0;  // radians

  ShadowRectangle rectangle(const Direction& light) const;
};

struct TrainingSet {
  uint32_t size = 0;    // texels a side
  uint32_t stride = 1;  // divides size
  std::vector<Direction> lights;
  std::vector<uint16_t> values;    // transparency times 65535: light by light, cell by cell
  std::vector<uint32_t> penumbra;  // indices of values that are neither lit nor dark, or next to such a one
  std::vector<bool> in_penumbra;   // one a value: whether its index is among them

  struct Texel {
    uint32_t light, u, v;
  };
  uint32_t cells() const { return size / stride; }  // a side
  Texel texel(uint64_t index) const;
  double transparency(uint64_t index) const { return values[index] * (1.0 / 65535); }
};

// Traces lights in order, beginning behind those that `set` holds; `go_on` is asked every few with the number done.
// False: interrupted, with whole lights.
bool trace_training_set(const LightGeometry& geometry, const ShadowCaster& caster, ThreadPool& pool,
                        const std::function<bool(uint32_t)>& go_on, TrainingSet* set);

// Fills `penumbra` and `in_penumbra`.
void find_penumbra(TrainingSet* set);

}  // namespace sandglass::host

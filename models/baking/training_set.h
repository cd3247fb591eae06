// The pairs that a network learns from: texels and their transparency, for a set of lights. Each light's texture covers
// the rectangle of that light.
//
// The dissertation takes every texel of 301 textures (6.19). The same number of rays teaches more when it is spread
// over more lights. So one texel of each cell of stride x stride is traced, chosen anew for every light, and there are
// stride^2 times as many lights. On the armadillo the error over unseen lights falls by a third.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "models/baking/truth.h"

namespace sandglass::host {

// What decides where a light's texture lies: the object, the rule for the plane, and the light's size and range.
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
  std::vector<uint16_t> values;  // transparency times 65535: light by light, cell by cell
  // Indices of the values in the penumbra or at its edge: neither lit nor dark, or beside a value of another class.
  std::vector<uint32_t> penumbra;
  std::vector<bool> in_penumbra;  // one entry per value: whether `penumbra` holds its index

  struct Texel {
    uint32_t light, u, v;
  };
  uint32_t cells() const { return size / stride; }  // a side
  Texel texel(uint64_t index) const;
  double transparency(uint64_t index) const { return values[index] * (1.0 / 65535); }
};

// Traces the lights in order. After every few it calls `go_on` with the number done. When that returns false, it stops
// and returns false.
bool trace_training_set(const LightGeometry& geometry, const ShadowCaster& caster, ThreadPool& pool,
                        const std::function<bool(uint32_t)>& go_on, TrainingSet* set);

}  // namespace sandglass::host

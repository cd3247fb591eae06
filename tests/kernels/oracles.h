// What the oracles of the kernels share: the tables of this machine, vectors in double, clusters of particles.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <type_traits>
#include <vector>

#include "kernels/kernels.h"
#include "runtime/sand/particles.h"
#include "tests/vector.h"

namespace sandglass::tests {

constexpr uint32_t k_slack = 2 * k_lane_group;
constexpr float k_cluster_radius = 0.01f;

inline std::vector<const Kernels*> tables() {
  std::vector<const Kernels*> all;
  for (const sandglass_isa isa :
       {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_AVX2, SANDGLASS_ISA_AVX512, SANDGLASS_ISA_WASM}) {
    if (const Kernels* kernels = select_kernels(isa)) all.push_back(kernels);
  }
  return all;
}

// Whether each of the results has the bits of the first.
class SameBits {
 public:
  template <class Item>
  bool operator()(const std::vector<Item>& result) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(result.data());
    const std::vector<uint8_t> bits(bytes, bytes + result.size() * sizeof(Item));
    if (first_.empty()) first_ = bits;
    return bits == first_;
  }

 private:
  std::vector<uint8_t> first_;
};

// Calls check(kernels), or check(kernels, same), with each of them, until one fails.
template <class Check>
void on_every_table(const Check& check) {
  SameBits same;
  for (const Kernels* kernels : tables()) {
    if (testing::Test::HasFatalFailure()) return;
    SCOPED_TRACE(sandglass_isa_name(kernels->isa));
    if constexpr (std::is_invocable_v<Check, const Kernels&, SameBits&>) check(*kernels, same);
    else check(*kernels);
  }
}

// A kernel's result, of n items.
template <class Args, class Result>
Result run(void (*kernel)(const Args*, uint32_t, uint32_t, Result*), const Args& args, uint32_t n) {
  Result result = {};
  kernel(&args, 0, n, &result);
  return result;
}

inline uint32_t whole_groups(uint32_t n) { return (n + k_lane_group - 1) / k_lane_group * k_lane_group; }

// A moving particle or a grain.
template <class Item>
Item item_at(Vector position, Vector velocity, uint32_t number) {
  float x[3], v[3];
  set(x, position);
  set(v, velocity);
  if constexpr (std::is_same_v<Item, Particle>) return moving_particle(x, v, number);
  else return moving_grain(x, v, number);
}

// n particles in a cube that holds about `density` of them per diameter cubed, then `fixed` boundary particles, then
// the inert one.
struct Cluster {
  Cluster(uint32_t n, uint32_t fixed, double density, uint32_t seed)
      : count(n), rows(whole_groups(n) + k_slack), boundary(fixed), inert(rows + fixed), records(inert + k_slack) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-0.5, 0.5);
    side = 0.02 * std::cbrt((n + fixed + 1) / density);
    for (uint32_t i = 0; i < rows + fixed; ++i) {
      if (i >= n && i < rows) {
        records[i] = inert_particle();
        continue;
      }
      const Vector x = {side * unit(random), side * unit(random), side * unit(random)};
      if (i < n) {
        records[i] = item_at<Particle>(x, {unit(random), unit(random), unit(random)}, i);
      } else {
        float position[3];
        set(position, x);
        records[i] = fixed_particle(position, i);
      }
    }
    records[inert] = inert_particle();
  }
  uint32_t count, rows, boundary, inert;
  std::vector<Particle> records;
  double side;
};

// Masses, sleepers and rigid bodies among the particles of a cluster.
inline void mix(Cluster* c) {
  for (uint32_t i = 0; i < c->count; ++i) {
    join_body(&c->records[i], i % 6 == 1 ? 1 : i % 6 == 4 ? 2 : 0, i % 7 == 3 ? 0.25f : 1.0f);
    if (i % 5 == 2) put_to_sleep(&c->records[i]);
  }
}

inline double distance(const Particle& a, const Particle& b) {
  const Vector offset = at(a.position) - at(b.position);
  return std::hypot(offset.x, offset.y, offset.z);
}

// A collider that is not turned.
inline ColliderFrame upright(sandglass_shape shape, Vector place, float size = 0.0f) {
  ColliderFrame frame = {};
  frame.shape = shape;
  set(frame.position, place);
  frame.size[0] = size;
  for (int k = 0; k < 3; ++k) frame.axes[k][k] = 1.0f;
  return frame;
}

// Positions sorted by cell, one array an axis, as the stage makes them.
struct Sorted {
  Sorted(const Particle* source, uint32_t n, float cell, const Kernels& kernels, uint32_t bits_min)
      : records(n + k_slack) {
    starts.resize(4096 + k_slack);
    keys.resize(n + k_slack);
    for (auto& axis : axes) axis.resize(n + k_slack);
    sort.cells_max = 4096;
    sort.starts = starts.data();
    sort.keys = keys.data();
    float low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
    for (uint32_t i = 0; i < n; ++i) {
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], source[i].position[k]);
        high[k] = std::max(high[k], source[i].position[k]);
      }
    }
    cell_sort_begin(&sort, cell, low, high, bits_min);
    const SortTarget target = {as_records(records.data()), {axes[0].data(), axes[1].data(), axes[2].data()}, false};
    while (sort.phase != k_sort_done) cell_sort_run(&sort, kernels, as_records(source), n, 64, target);
  }
  std::vector<Particle> records;
  std::vector<float> axes[3];
  std::vector<uint32_t> starts, keys;
  CellSort sort = {};
};

// The checks: check_<name>(n) of each kernel, with n items.
#define SANDGLASS_KERNEL(user, name, Args, Result) void check_##name(uint32_t n);
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL

}  // namespace sandglass::tests

// What the oracles of the kernels share: the tables of this machine, vectors in double, clusters of particles.
#pragma once

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

// A moving particle or a grain.
template <class Item>
Item item_at(Vector position, Vector velocity, uint32_t number) {
  float x[3], v[3];
  set(x, position);
  set(v, velocity);
  if constexpr (std::is_same_v<Item, Particle>) return moving_particle(x, v, number);
  else return moving_grain(x, v, number);
}

// The same bits, number by number.
template <class Item>
bool same_bits(const std::vector<Item>& a, const std::vector<Item>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0;
}

// n particles in a cube that holds about `density` of them per diameter cubed, then `fixed` boundary particles, then
// the inert one.
struct Cluster {
  Cluster(uint32_t n, uint32_t fixed, double density, uint32_t seed)
      : count(n), rows((n + 15) / 16 * 16 + k_slack), boundary(fixed), inert(rows + fixed), records(inert + k_slack) {
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

inline double distance(const Particle& a, const Particle& b) {
  const Vector apart = at(a.position) - at(b.position);
  return std::hypot(apart.x, apart.y, apart.z);
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

// In motion_oracle_test.cpp.
void check_scatter_motion(uint32_t n);
void check_count_grains(uint32_t n);
void check_refine_grains(uint32_t n);

}  // namespace sandglass::tests

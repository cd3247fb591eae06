// The oracles of the kernels that find neighbours: the cell of each particle, and the list of those within reach.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/kernels/oracles.h"

namespace sandglass::tests {

void check_grid_cells(uint32_t n) {
  Cluster cluster(n, 0, 0.001, 7);
  const Grid grid = {1.0f / 0.024f, {3, 2, 4}, nullptr};
  for (const int32_t serpentine : {0, 1}) {
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      std::vector<uint32_t> keys(cluster.rows + k_slack);
      const GridCellsArgs args = {grid, as_records(cluster.records.data()), keys.data(), serpentine, {-3, 2, -1}};
      run(kernels.grid_cells, args, n);
      keys.resize(n);
      for (uint32_t i = 0; i < n; ++i) {
        int64_t c[3], cells[3];
        for (int k = 0; k < 3; ++k) {
          cells[k] = int64_t{1} << grid.bits[k];
          c[k] =
              static_cast<int64_t>(std::floor(static_cast<double>(cluster.records[i].position[k] * grid.inverse_cell)));
          if (serpentine != 0) c[k] -= args.first[k];
          c[k] = (c[k] % cells[k] + cells[k]) % cells[k];
        }
        if (serpentine != 0 && c[2] % 2 == 1) c[1] = cells[1] - 1 - c[1];
        if (serpentine != 0 && c[1] % 2 == 1) c[0] = cells[0] - 1 - c[0];
        ASSERT_EQ(keys[i], c[0] + cells[0] * (c[1] + cells[1] * c[2]));
      }
      ASSERT_TRUE(same(keys));
    });
  }
}

void check_neighbour_lists(uint32_t n) {
  Cluster cluster(n, n, 0.8, 11);
  const float reach = 2.4f * k_cluster_radius;
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    Sorted moving(cluster.records.data(), n, reach, kernels, 2);
    Sorted fixed(&cluster.records[cluster.rows], n, reach, kernels, 2);
    std::vector<uint32_t> lists(uint64_t{cluster.rows} * k_list_slots);
    std::vector<uint8_t> counts(cluster.rows), near_counts(cluster.rows);
    ListArgs args = {};
    args.grid = moving.sort.grid;
    args.boundary_grid = fixed.sort.grid;
    for (int k = 0; k < 3; ++k) {
      args.positions[k] = moving.axes[k].data();
      args.boundary_positions[k] = fixed.axes[k].data();
    }
    args.boundary_count = n;
    args.boundary_first = cluster.rows;
    args.inert = cluster.inert;
    args.reach_squared = reach * reach;
    args.near_squared = 0.021f * 0.021f;
    args.lists = lists.data();
    args.counts = counts.data();
    args.near_counts = near_counts.data();
    EXPECT_EQ(run(kernels.neighbour_lists, args, n), 0u) << "dropped";
    for (uint32_t i = 0; i < n; ++i) {
      std::vector<uint32_t> found(&lists[i * k_list_slots], &lists[i * k_list_slots] + counts[i]);
      for (uint32_t s = counts[i]; s < k_list_slots; ++s) ASSERT_EQ(lists[i * k_list_slots + s], cluster.inert);
      const auto near = [&](uint32_t j) {
        const Particle& other = j < cluster.rows ? moving.records[j] : fixed.records[j - cluster.rows];
        return distance(moving.records[i], other) < 0.021;
      };
      ASSERT_TRUE(std::is_partitioned(found.begin(), found.end(), near));
      ASSERT_EQ(near_counts[i], std::count_if(found.begin(), found.end(), near));
      std::sort(found.begin(), found.end());
      std::vector<uint32_t> expected;
      for (uint32_t j = 0; j < n; ++j) {
        // A pair may or may not count if its distance equals the reach to within rounding. This seed has no such pair.
        const double d = distance(moving.records[i], moving.records[j]),
                     b = distance(moving.records[i], fixed.records[j]);
        ASSERT_GT(std::min(std::fabs(d - 0.024), std::fabs(b - 0.024)), 1e-8);
        if (j != i && d < 0.024) expected.push_back(j);
        if (b < 0.024) expected.push_back(cluster.rows + j);
      }
      std::sort(expected.begin(), expected.end());
      ASSERT_EQ(found, expected);
    }
    ASSERT_TRUE(same(lists)) << "the order of the neighbours is part of the contract";

    // Halves: of the moving neighbours those that come later, in the same order; all of the boundary.
    std::vector<uint32_t> halves(lists.size());
    std::vector<uint8_t> half_counts(cluster.rows);
    args.halves = 1;
    args.lists = halves.data();
    args.counts = half_counts.data();
    run(kernels.neighbour_lists, args, n);
    for (uint32_t i = 0; i < n; ++i) {
      std::vector<uint32_t> later;
      for (uint32_t s = 0; s < counts[i]; ++s) {
        if (lists[i * k_list_slots + s] > i) later.push_back(lists[i * k_list_slots + s]);
      }
      const uint32_t* half = &halves[i * k_list_slots];
      ASSERT_EQ(std::vector<uint32_t>(half, half + half_counts[i]), later);
    }
  });
}

}  // namespace sandglass::tests

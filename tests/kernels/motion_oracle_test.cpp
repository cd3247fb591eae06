// The oracles of the kernels that grains follow by: the motion on the grid, the grains' density, the sweep itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "tests/kernels/oracles.h"
#include "tests/motion_arrays.h"
#include "tests/own_particle_rule.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

// Of three particles one falls freely and one half so.
void fall_in_part(Cluster* particles) {
  for (uint32_t i = 0; i < particles->count; ++i)
    set_free_fall(&particles->records[i], 0.5f * static_cast<float>(i % 3));
}

// ---- scatter_motion

// A motion grid whose reach is round numbers.
struct Motion : MotionArrays {
  explicit Motion(uint32_t capacity = 1000) : MotionArrays(capacity) {
    grid.spacing = 0.015f;
    grid.inverse_spacing = 1.0f / grid.spacing;
    grid.support = 0.03f;
    grid.reach = 0.025f;
    grid.gain = 1.728f;
    const float origin[3] = {0.004f, -0.011f, 0.023f};
    for (int k = 0; k < 3; ++k) grid.origin[k] = origin[k];
  }
  void fill(const Kernels& kernels, const Cluster& particles) {
    scatter(kernels, particles.records.data(), particles.count, k_time);
  }
  void measure_density(const Kernels& kernels, const std::vector<Grain>& grains, uint32_t n) {
    std::fill(counts.begin(), counts.end(), uint8_t{0});
    const CountGrainsArgs args = {&grid, grains.data(), n};
    run(kernels.count_grains, args, whole_groups(n));
    for (uint32_t b = 0; b < grid.block_count; ++b) motion_smooth(grid, b);
  }
  static constexpr float k_time = 0.02f;
};

constexpr double k_origin[3] = {0.004, -0.011, 0.023};

// What a node at x holds.
struct Node {
  Node(const Cluster& particles, Vector x) {
    for (uint32_t i = 0; i < particles.count; ++i) {
      const Vector u = at(particles.records[i].velocity), p = at(particles.records[i].position) - 0.02 * u;
      const double d2 = dot(p - x, p - x), w = 1.728 * std::pow(std::max(0.0, 1 - d2 / 6.25e-4), 3);
      weight += w;
      momentum = momentum + w * u;
      if (w > largest) {
        largest = w;
        nearest = p;
        number = i;
      }
    }
  }
  double weight = 0, largest = 0;
  uint32_t number = 0;
  Vector momentum, nearest = {1e6, 1e6, 1e6};
};

}  // namespace

void sandglass::tests::check_scatter_motion(uint32_t n) {
  Cluster particles(n, 0, 0.5, 61);
  if (n > 3) {
    join_body(&particles.records[3], 1, 1.0f);
    particles.records[3].position[0] = 3.0f;  // adds nothing
  }
  fall_in_part(&particles);
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    Motion motion;
    motion.fill(kernels, particles);
    const MotionGrid& grid = motion.grid;
    ASSERT_EQ(grid.overflowed, 0u);
    Cluster sand = particles;
    if (n > 3) sand.records[3].position[0] = 1e5f;
    double added = 0, expected = 0;
    for (uint32_t b = 0; b < grid.block_count; ++b) {
      const MotionBlock& block = grid.blocks[b];
      ASSERT_EQ(motion_find(grid, block.at[0], block.at[1], block.at[2]), b);
      for (int side = 0; side < 27; ++side) {
        const int32_t x = block.at[0] + side % 3 - 1, y = block.at[1] + side / 3 % 3 - 1,
                      z = block.at[2] + side / 9 - 1;
        ASSERT_EQ(block.around[side], motion_find(grid, x, y, z)) << side;
      }
      for (uint32_t r = 0; r < 125; ++r) {
        const int32_t place[3] = {static_cast<int32_t>(r % 5), static_cast<int32_t>(r / 5 % 5),
                                  static_cast<int32_t>(r / 25)};
        const Vector origin = {k_origin[0], k_origin[1], k_origin[2]};
        const Vector x = origin + Vector{0.015 * (4 * grid.blocks[b].at[0] + place[0]),
                                         0.015 * (4 * grid.blocks[b].at[1] + place[1]),
                                         0.015 * (4 * grid.blocks[b].at[2] + place[2])};
        const Node node(sand, x);
        const float* record = grid.nodes + (b * k_block_records + r) * k_record_floats;
        ASSERT_NEAR(record[k_node_weight], node.weight, 2e-5);
        ASSERT_LT(length(at(record + k_node_momentum) - node.momentum), 2e-5);
        if (node.largest > 1e-6) {
          // Another particle may be as near.
          const double d = length(origin + at(record + k_node_nearest) - x), nearest = length(node.nearest - x);
          ASSERT_NEAR(d, nearest, 1e-6) << r;
          const Particle& named = sand.records[static_cast<uint32_t>(record[k_node_number])];
          const Vector start = at(named.position) - 0.02 * at(named.velocity);
          ASSERT_NEAR(length(start - x), nearest, 1e-6) << r;
        }
        if (place[0] < 4 && place[1] < 4 && place[2] < 4) added += static_cast<double>(record[k_node_weight]);
      }
    }
    // Nothing is left out: the weights of all nodes are those of all particles.
    for (uint32_t i = 0; i < n; ++i) {
      if (n > 3 && i == 3) continue;
      const Vector p = at(particles.records[i].position) - 0.02 * at(particles.records[i].velocity);
      const Vector q = p - Vector{k_origin[0], k_origin[1], k_origin[2]};
      const auto low = [](double c) { return static_cast<int>(std::floor((c - 0.026) / 0.015)); };
      for (int z = low(q.z); z < low(q.z) + 5; ++z)
        for (int y = low(q.y); y < low(q.y) + 5; ++y)
          for (int x = low(q.x); x < low(q.x) + 5; ++x) {
            const Vector offset = Vector{0.015 * x, 0.015 * y, 0.015 * z} - q;
            expected += 1.728 * std::pow(std::max(0.0, 1 - dot(offset, offset) / 6.25e-4), 3);
          }
    }
    ASSERT_NEAR(added, expected, 1e-4 * n);
    std::vector<float> all;
    for (uint32_t b = 0; b < grid.block_count; ++b)
      all.insert(all.end(), grid.nodes + b * 1024, grid.nodes + b * 1024 + 125 * k_record_floats);
    ASSERT_TRUE(same(all));
  });
}

// ---- count_grains

void sandglass::tests::check_count_grains(uint32_t n) {
  const Cluster particles(200, 0, 0.5, 61);
  std::mt19937 random(67);
  std::uniform_real_distribution<double> unit(-0.7, 0.7);
  std::vector<Grain> grains(n + k_slack);
  for (uint32_t i = 0; i < n; ++i)
    grains[i] = item_at<Grain>(
        {particles.side * unit(random), particles.side * unit(random), particles.side * unit(random)}, {}, i);
  on_every_table([&](const Kernels& kernels) {
    Motion motion;
    motion.fill(kernels, particles);
    const CountGrainsArgs args = {&motion.grid, grains.data(), n};
    uint32_t counted = 0, within = 0;
    run(kernels.count_grains, args, whole_groups(n));
    for (uint32_t b = 0; b < motion.grid.block_count; ++b) {
      for (uint32_t c = 0; c < k_block_counts; ++c) {
        uint32_t expected = 0;
        for (uint32_t i = 0; i < n && motion.counts[b * k_block_counts + c] != 0; ++i) {
          const uint32_t cell[3] = {c % 12, c / 12 % 12, c / 144};
          bool inside = true;
          for (int k = 0; k < 3; ++k) {
            const double x = (static_cast<double>(grains[i].position[k]) - k_origin[k]) / 0.005;
            inside = inside && std::floor(x) == 12.0 * motion.grid.blocks[b].at[k] + cell[k];
          }
          expected += inside ? 1 : 0;
        }
        counted += motion.counts[b * k_block_counts + c] / k_grain_count;
        ASSERT_EQ(motion.counts[b * k_block_counts + c], std::min(expected, 15u) * k_grain_count);
      }
    }
    for (uint32_t i = 0; i < n; ++i) {
      int32_t block[3];
      for (int k = 0; k < 3; ++k)
        block[k] = static_cast<int32_t>(std::floor((static_cast<double>(grains[i].position[k]) - k_origin[k]) / 0.06));
      within += motion_find(motion.grid, block[0], block[1], block[2]) != k_no_block ? 1 : 0;
    }
    ASSERT_EQ(counted, within);
  });
}

namespace {

// A grain weighs 6/8 along an axis in its own cell and 1/8 in the next, across the faces of blocks too. Each of the
// three roundings adds less than one.
TEST(MotionGrid, DensitySpreadsEachGrainOverTheCellsAround) {
  const Cluster particles(200, 0, 0.5, 61);
  Motion motion;
  motion.fill(*tables()[0], particles);
  const MotionGrid& grid = motion.grid;
  // The last cell of a block along x that has a next one.
  uint32_t block = 0;
  const auto next_of = [&](uint32_t b) {
    return motion_find(grid, grid.blocks[b].at[0] + 1, grid.blocks[b].at[1], grid.blocks[b].at[2]);
  };
  while (next_of(block) == k_no_block) ++block;
  constexpr int count = 192;
  motion.counts[block * k_block_counts + (5 * 12 + 6) * 12 + 11] = count;
  motion.blocks[block].state |= k_block_holds;
  const uint32_t next = next_of(block);
  motion.blocks[next].state |= k_block_holds;
  for (uint32_t b = 0; b < grid.block_count; ++b) motion_smooth(grid, b);
  const auto density = [&](uint32_t b, int x, int y, int z) {
    return static_cast<double>(density_of(grid, b)[((z + 1) * 14 + y + 1) * 14 + x + 1]);
  };
  const auto near = [](double value, double expected) { return value >= expected && value < expected + 3; };
  EXPECT_PRED2(near, density(block, 11, 6, 5), count * 216 / 512.0);
  EXPECT_PRED2(near, density(block, 10, 6, 5), count * 36 / 512.0);
  EXPECT_PRED2(near, density(block, 11, 7, 6), count * 6 / 512.0);
  EXPECT_PRED2(near, density(block, 12, 6, 5), count * 36 / 512.0) << "beside the block";
  EXPECT_EQ(density(block, 9, 6, 5), 0);
  EXPECT_PRED2(near, density(next, 0, 6, 5), count * 36 / 512.0) << "in the next block";
  EXPECT_PRED2(near, density(next, -1, 6, 5), count * 216 / 512.0);
  EXPECT_EQ(density(next, 1, 6, 5), 0);
}

TEST(MotionGrid, WithoutRoomItSaysSo) {
  Cluster particles(64, 0, 0.5, 61);
  on_every_table([&](const Kernels& kernels) {
    Motion motion(3);
    motion.fill(kernels, particles);
    EXPECT_EQ(motion.grid.block_count, 3u);
    EXPECT_EQ(motion.grid.overflowed, 1u);
    for (uint32_t b = 0; b < 3; ++b) EXPECT_NE(motion.grid.blocks[b].state & k_block_incomplete, 0u) << b;
  });
}

// ---- refine_grains

struct Refinement {
  Refinement(uint32_t n, bool source_rule, bool uniform) : particles(200, 0, 0.8, 31), grains(n + k_slack) {
    std::mt19937 random(37);
    std::uniform_real_distribution<double> unit(-0.7, 0.7);
    fall_in_part(&particles);
    if (uniform) {
      for (uint32_t j = 0; j < 200; ++j) set(particles.records[j].velocity, {0.3, -0.2, 0.1});
    }
    for (uint32_t i = 0; i < n; ++i) {
      const double side = particles.side * (uniform ? 0.4 : 1.0);
      const Vector x = {side * unit(random), side * unit(random), side * unit(random)};
      grains[i] = item_at<Grain>(x, {unit(random), unit(random), unit(random)}, i);
    }
    count = n;
    args.support = 3 * k_cluster_radius;
    args.speed_scale = std::sqrt(2 * 9.81f * k_cluster_radius);
    args.step = 0.004f;
    args.steps = 1;
    args.gravity[1] = -9.81f;
    args.source_rule = source_rule ? 1 : 0;
    args.own_particles = 1;
    args.weight_at_radius = 512.0f / 729.0f;
    args.grain_radius = 0.003f;
    args.grain_count = n;
    for (uint32_t g = 0; g * k_lane_group < n; ++g) groups.push_back(g);
    still.resize(groups.size());
    stamps.resize(groups.size());
    args.stamps = stamps.data();
    args.stamp = 7;
    args.groups = groups.data();
    args.still = still.data();
    args.still_distance = 0.004f;
    args.still_sweeps = 2.0f;
  }
  std::vector<Grain> run(const Kernels& kernels) {
    Sorted snapshot(particles.records.data(), 200, 3 * k_cluster_radius, kernels, 3);
    std::vector<Grain> moved = grains;
    args.grid = snapshot.sort.grid;
    args.snapshot = snapshot.records.data();
    for (int k = 0; k < 3; ++k) args.positions[k] = snapshot.axes[k].data();
    args.grains = moved.data();
    if (motion) {
      motion->fill(kernels, particles);
      args.motion = &motion->grid;
      args.snapshot = particles.records.data();
    }
    if (args.push != 0.0f) motion->measure_density(kernels, grains, count);
    RefineExtent extent = {};
    kernels.refine_grains(&args, 0, count, &extent);
    EXPECT_EQ(extent.quarantined, 0u);
    moved.resize(count);
    return moved;
  }
  Cluster particles;
  std::vector<Grain> grains;
  uint32_t count;
  std::vector<uint32_t> groups;
  std::vector<uint8_t> still;
  std::vector<uint32_t> stamps;
  std::unique_ptr<Motion> motion;  // null: every grain looks the particles up
  RefineArgs args = {};
};

// What the particles within h say at x.
struct Sums {
  double weight = 0, largest = 0, nearest2 = 9e-4;  // squared distance of the nearest particle, h^2 at most
  double falling = 0;                               // the share of the weight that falls freely
  const Particle* own = nullptr;                    // the nearest, as the nodes know it
  Vector flow;
};

Sums sums_of_particles(const Cluster& particles, Vector x) {
  Sums s;
  for (uint32_t j = 0; j < particles.count; ++j) {
    const double d = length(at(particles.records[j].position) - x);
    const double w = std::pow(std::max(0.0, 1 - d * d / 9e-4), 3);
    s.weight += w;
    s.largest = std::max(s.largest, w);
    s.falling += w * static_cast<double>(free_fall(particles.records[j]));
    s.flow = s.flow + w * at(particles.records[j].velocity);
  }
  if (s.weight > 0) s.falling /= s.weight;
  return s;
}

// The same between the nodes of a motion grid. The largest weight is that of the nearest of the corners' nearest
// particles.
Sums sums_of_nodes(const Cluster& particles, Vector x) {
  Sums s;
  const Vector origin = {k_origin[0], k_origin[1], k_origin[2]}, q = x - origin;
  const int cell[3] = {static_cast<int>(std::floor(q.x / 0.015)), static_cast<int>(std::floor(q.y / 0.015)),
                       static_cast<int>(std::floor(q.z / 0.015))};
  for (int c = 0; c < 8; ++c) {
    const Vector corner =
        origin + Vector{0.015 * (cell[0] + (c & 1)), 0.015 * (cell[1] + (c >> 1 & 1)), 0.015 * (cell[2] + (c >> 2))};
    const Vector offset = corner - x;
    const double share =
        (1 - std::abs(offset.x) / 0.015) * (1 - std::abs(offset.y) / 0.015) * (1 - std::abs(offset.z) / 0.015);
    const Node node(particles, corner);
    s.weight += share * node.weight;
    s.flow = s.flow + share * node.momentum;
    const double squared = dot(node.nearest - x, node.nearest - x);
    if (squared < s.nearest2) {
      s.nearest2 = squared;
      s.own = &particles.records[node.number];
    }
  }
  if (s.weight >= 2) s.own = nullptr;
  if (s.own != nullptr) s.falling = static_cast<double>(free_fall(*s.own));
  s.largest = std::pow(1 - s.nearest2 / 9e-4, 3);
  s.weight = std::max(s.weight, s.largest);
  return s;
}

// Down the gradient of the density, which is read linearly between the centres of cells: all of it inside the pile,
// near a particle, and around a lone one as far as its weight reaches.
Vector push_at(const RefineArgs& args, const Sums& s, Vector x) {
  const MotionGrid& grid = *args.motion;
  const Vector q = (1 / 0.06) * (x - Vector{k_origin[0], k_origin[1], k_origin[2]});
  const double blocks[3] = {std::floor(q.x), std::floor(q.y), std::floor(q.z)};
  const uint32_t block = motion_find(grid, static_cast<int32_t>(blocks[0]), static_cast<int32_t>(blocks[1]),
                                     static_cast<int32_t>(blocks[2]));
  if (block == k_no_block) return {};
  // In cells from the centre of the one before the block's first.
  const Vector in = 12 * (q - Vector{blocks[0], blocks[1], blocks[2]}) + Vector{0.5, 0.5, 0.5};
  const int cell[3] = {static_cast<int>(in.x), static_cast<int>(in.y), static_cast<int>(in.z)};
  double value = 0;
  Vector slope;
  for (int c = 0; c < 8; ++c) {
    const int side[3] = {c & 1, c >> 1 & 1, c >> 2};
    const double density =
        density_of(grid, block)[((cell[2] + side[2]) * 14 + cell[1] + side[1]) * 14 + cell[0] + side[0]];
    const double share[3] = {side[0] != 0 ? in.x - cell[0] : 1 - in.x + cell[0],
                             side[1] != 0 ? in.y - cell[1] : 1 - in.y + cell[1],
                             side[2] != 0 ? in.z - cell[2] : 1 - in.z + cell[2]};
    value += density * share[0] * share[1] * share[2];
    slope = slope + density * Vector{(2 * side[0] - 1) * share[1] * share[2], (2 * side[1] - 1) * share[0] * share[2],
                                     (2 * side[2] - 1) * share[0] * share[1]};
  }
  Vector push = (-static_cast<double>(args.push) / std::max(value, 1.0)) * slope;
  const double push_max = static_cast<double>(args.push_max), reach = static_cast<double>(args.push_reach);
  if (length(push) > push_max) push = (push_max / length(push)) * push;
  const double lone = s.weight > 0 ? (1 - fade(s.largest / s.weight, 0.6, 0.8)) * (1 - fade(s.weight, 0, 0.02)) : 0;
  return std::max({1 - fade(s.weight, 1.6, 2), fade(s.nearest2 / (reach * reach), 0.7, 1.3), lone}) * push;
}

// That of the grain with this number, which is at x.
void follow_own(const Sums& s, Vector x, uint32_t number, Vector* mean, Vector* velocity) {
  const Vector u = at(s.own->velocity);
  const OwnParticle own = {u, x - (at(s.own->position) - 0.004 * u), static_cast<double>(free_fall(*s.own)),
                           1 - fade(s.largest / s.weight, 0.6, 0.8)};
  stay_with_own({0.01, 0.004, 0.004, {0, -9.81, 0}}, own, s.weight, number, mean, velocity);
}

}  // namespace

void sandglass::tests::check_refine_grains(uint32_t n) {
  enum Rule { k_source, k_particles, k_means, k_grid, k_pushed };
  for (const Rule rule : {k_source, k_particles, k_means, k_grid, k_pushed}) {
    const bool source_rule = rule == k_source;
    Refinement refinement(n, source_rule, false);
    if (rule >= k_means) refinement.motion = std::make_unique<Motion>();
    if (rule == k_means) refinement.args.own_particles = 0;
    if (rule == k_pushed) {
      refinement.args.push = 0.0015f;
      refinement.args.push_max = 0.001f;
      refinement.args.push_reach = 0.012f;
    }
    uint32_t pushed = 0;
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      const std::vector<Grain> all = refinement.run(kernels);
      for (uint32_t i = 0; i < n; ++i) {
        const Vector x = at(refinement.grains[i].position), v = at(refinement.grains[i].velocity);
        const Sums sums =
            rule >= k_means ? sums_of_nodes(refinement.particles, x) : sums_of_particles(refinement.particles, x);
        const double weight = sums.weight, largest = sums.largest;
        const double radius_weight = 512.0 / 729.0, ratio = weight > 0 ? largest / weight : 0;
        double lambda;
        if (source_rule) {
          lambda = largest <= radius_weight || ratio >= 0.6 ? 1 - largest : 0;
        } else {
          const double few = fade(largest, radius_weight - 0.1, radius_weight + 0.1) * fade(weight, 1.2, 2.0);
          lambda = std::max({(1 - largest) * few, 1 - fade(ratio, 0.5, 0.7), sums.falling * fade(weight, 1.6, 2.0)});
        }
        if (weight == 0) lambda = 1;
        Vector mean = weight > 0 ? (1 / weight) * sums.flow : Vector{}, own = v;
        if (sums.own != nullptr && rule >= k_grid) follow_own(sums, x, all[i].number, &mean, &own);
        const Vector fall = own + 0.004 * Vector{0, -9.81, 0};
        const Vector expected = weight > 0 ? (1 - lambda) * mean + lambda * fall : fall;
        const Vector push = rule == k_pushed ? push_at(refinement.args, sums, x) : Vector{};
        pushed += length(push) > 1e-5 ? 1 : 0;
        ASSERT_LT(length(at(all[i].velocity) - expected), 2e-5) << "grain " << i;
        ASSERT_LT(length(at(all[i].position) - (x + push + 0.004 * expected)), 2e-7);
      }
      ASSERT_GE(pushed, rule == k_pushed && n >= 64 ? n / 4 : 0);
      pushed = 0;
      ASSERT_TRUE(same(all));
    });
  }
}

namespace {

// Sixteen grains at a time, a little inside the surface of a slab that stands askew, on its faces, edges and corners: so
// whole vectors are hardly near to it.
TEST(Refinement, GrainsLeaveABoxOnAllItsSides) {
  constexpr uint32_t n = 27 * 16;
  constexpr double half[3] = {0.03, 0.1, 0.004}, radius = 0.003;
  ColliderFrame slab = {};
  slab.shape = SANDGLASS_SHAPE_BOX;
  slab.position[0] = 0.7f;
  for (int k = 0; k < 3; ++k) slab.size[k] = static_cast<float>(half[k]);
  const Vector axes[3] = {{0.48, 0.6, -0.64}, {0.8, 0, 0.6}, {0.36, -0.8, -0.48}};  // orthonormal
  for (int k = 0; k < 3; ++k) set(slab.axes[k], axes[k]);
  find_extent(&slab);
  const auto beyond = [&](const Grain& grain) {
    const Vector from = at(grain.position) - Vector{0.7, 0, 0};
    Vector out;
    double* const out_of[3] = {&out.x, &out.y, &out.z};
    for (int k = 0; k < 3; ++k) *out_of[k] = std::max(std::abs(dot(from, axes[k])) - half[k], 0.0);
    return length(out);
  };
  on_every_table([&](const Kernels& kernels) {
    Refinement refinement(n, false, true);
    refinement.motion = std::make_unique<Motion>();
    refinement.args.colliders = &slab;
    refinement.args.collider_count = 1;
    refinement.args.gravity[1] = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
      const int side = static_cast<int>(i / 16), to[3] = {side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1};
      const double sides = std::sqrt(std::max(1, std::abs(to[0]) + std::abs(to[1]) + std::abs(to[2])));
      Vector x = {0.7, 0, 0};
      for (int k = 0; k < 3; ++k) {
        const double along = to[k] == 0 ? 0.3 * half[k] * (i % 16 / 15.0) : to[k] * (half[k] + 0.98 * radius / sides);
        x = x + along * axes[k];
      }
      refinement.grains[i] = item_at<Grain>(x, {}, i);
      if (side != 13) {
        ASSERT_NEAR(beyond(refinement.grains[i]), 0.98 * radius, 1e-6);
      }
    }
    for (const Grain& grain : refinement.run(kernels)) ASSERT_NEAR(beyond(grain), radius, 1e-6) << grain.number / 16;
  });
}

TEST(Refinement, AStillGrainAmongSleepersStaysAndOthersCountTheirStillSweeps) {
  constexpr uint32_t n = 64;
  on_every_table([&](const Kernels& kernels) {
    Refinement refinement(n, false, true);
    for (uint32_t j = 0; j < 200; ++j) set(refinement.particles.records[j].velocity, {});
    // Every third grain has been still for two sweeps, the others have not. Grain 40 falls, far from all particles.
    for (uint32_t i = 0; i < n; ++i) {
      refinement.grains[i].still_sweeps = i % 3 == 0 ? 2.0f : 0.0f;
      set(refinement.grains[i].velocity, {});
    }
    refinement.grains[40].position[0] = 5.0f;
    refinement.grains[40].velocity[1] = -4.0f;
    const std::vector<Grain> all = refinement.run(kernels);
    for (uint32_t i = 0; i < n; ++i) {
      const double moved = length(at(all[i].position) - at(refinement.grains[i].position));
      if (i % 3 == 0) {
        EXPECT_EQ(moved, 0.0) << i;
        EXPECT_EQ(all[i].still_sweeps, 2.0f);
      } else {
        EXPECT_EQ(all[i].still_sweeps, moved <= 0.004 ? 1.0f : 0.0f) << i;
      }
    }
    EXPECT_EQ(all[40].still_sweeps, 0.0f);
    for (uint32_t g = 0; g < n / k_lane_group; ++g) EXPECT_EQ(refinement.still[g], 0) << "not all of them";
    for (uint32_t i = 16; i < 32; ++i) refinement.grains[i].still_sweeps = 1.0f;
    const std::vector<Grain> twice = refinement.run(kernels);
    EXPECT_EQ(refinement.still[0], 0);
    EXPECT_EQ(refinement.still[1], 0) << "the second still sweep of all sixteen, but some still move";
    EXPECT_EQ(refinement.stamps[1], 7u);
    std::copy(twice.begin(), twice.end(), refinement.grains.begin());
    refinement.run(kernels);
    EXPECT_EQ(refinement.still[1], 1) << "they rest";
    refinement.args.stamp = 8;
    for (uint32_t i = 16; i < 32; ++i) {
      set(refinement.grains[i].velocity, {});
      refinement.grains[i].still_sweeps = 2.0f;
    }
    refinement.run(kernels);
    EXPECT_EQ(refinement.stamps[1], 7u) << "what rests has not changed";
    EXPECT_EQ(refinement.stamps[0], 8u);
  });
}

}  // namespace

// Every kernel is compared with a naive oracle in double, on every table that this machine can run. Every table is
// compared with the scalar one to the bit, for all tail lengths. kernels.inc expands into the list of tests, so a
// kernel without a check_<name> does not compile.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "kernels/kernels.h"
#include "tests/kernels/oracles.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

// ---- grid_cells

void check_grid_cells(uint32_t n) {
  Cluster cluster(n, 0, 0.001, 7);
  const Grid grid = {1.0f / 0.024f, {3, 2, 4}, nullptr};
  for (const int32_t serpentine : {0, 1}) {
    std::vector<uint32_t> first;
    for (const Kernels* kernels : tables()) {
      std::vector<uint32_t> keys(cluster.rows + k_slack);
      const GridCellsArgs args = {grid, as_records(cluster.records.data()), keys.data(), serpentine, {-3, 2, -1}};
      uint32_t unused = 0;
      kernels->grid_cells(&args, 0, n, &unused);
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
        ASSERT_EQ(keys[i], c[0] + cells[0] * (c[1] + cells[1] * c[2])) << sandglass_isa_name(kernels->isa);
      }
      if (first.empty()) first = keys;
      ASSERT_EQ(keys, first);
    }
  }
}

// ---- neighbour_lists

void check_neighbour_lists(uint32_t n) {
  Cluster cluster(n, n, 0.8, 11);
  const float reach = 2.4f * k_cluster_radius;
  std::vector<uint32_t> first;
  for (const Kernels* kernels : tables()) {
    Sorted moving(cluster.records.data(), n, reach, *kernels, 2);
    Sorted fixed(&cluster.records[cluster.rows], n, reach, *kernels, 2);
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
    uint32_t dropped = 0;
    kernels->neighbour_lists(&args, 0, n, &dropped);
    EXPECT_EQ(dropped, 0u);
    for (uint32_t i = 0; i < n; ++i) {
      std::vector<uint32_t> found(&lists[i * k_list_slots], &lists[i * k_list_slots] + counts[i]);
      for (uint32_t s = counts[i]; s < k_list_slots; ++s) ASSERT_EQ(lists[i * k_list_slots + s], cluster.inert);
      const auto near = [&](uint32_t j) {
        const Particle& other = j < cluster.rows ? moving.records[j] : fixed.records[j - cluster.rows];
        return distance(moving.records[i], other) < 0.021;
      };
      ASSERT_TRUE(std::is_partitioned(found.begin(), found.end(), near)) << sandglass_isa_name(kernels->isa);
      ASSERT_EQ(near_counts[i], std::count_if(found.begin(), found.end(), near)) << sandglass_isa_name(kernels->isa);
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
      ASSERT_EQ(found, expected) << sandglass_isa_name(kernels->isa);
    }
    if (first.empty()) first = lists;
    ASSERT_EQ(lists, first) << "the order of the neighbours is part of the contract";

    // Halves: of the moving neighbours those that come later, in the same order; all of the boundary.
    std::vector<uint32_t> halves(lists.size());
    std::vector<uint8_t> half_counts(cluster.rows);
    args.halves = 1;
    args.lists = halves.data();
    args.counts = half_counts.data();
    kernels->neighbour_lists(&args, 0, n, &dropped);
    for (uint32_t i = 0; i < n; ++i) {
      std::vector<uint32_t> later;
      for (uint32_t s = 0; s < counts[i]; ++s) {
        if (lists[i * k_list_slots + s] > i) later.push_back(lists[i * k_list_slots + s]);
      }
      const uint32_t* half = &halves[i * k_list_slots];
      ASSERT_EQ(std::vector<uint32_t>(half, half + half_counts[i]), later) << sandglass_isa_name(kernels->isa);
    }
  }
}

// ---- contact_stabilise, contact_solve

// Masses, sleepers and rigid bodies among the particles of a cluster.
void mix(Cluster* c) {
  for (uint32_t i = 0; i < c->count; ++i) {
    join_body(&c->records[i], i % 6 == 1 ? 1 : i % 6 == 4 ? 2 : 0, i % 7 == 3 ? 0.25f : 1.0f);
    if (i % 5 == 2) put_to_sleep(&c->records[i]);
  }
}

constexpr double k_step = 3e-4, k_static = 0.6, k_kinetic = 0.4, k_omega = 0.3, k_weight = 0.6, k_lift = 2e-5,
                 k_wake = 1e-4, k_separation = 4e-4, k_leave = 3e-4, k_stick = 0.4;

ContactLaw contact_law() {
  ContactLaw law = {};
  law.diameter = 2 * k_cluster_radius;
  law.static_friction = static_cast<float>(k_static);
  law.kinetic_friction = static_cast<float>(k_kinetic);
  law.relaxation = static_cast<float>(k_omega);
  law.weight_linear = static_cast<float>(-k_weight / 4);
  law.weight_cubic = static_cast<float>(k_weight * k_weight * k_weight / 48);
  law.lift_max = static_cast<float>(k_lift);
  law.up[1] = 1.0f;
  law.bodies = 1;
  law.wake_displacement = static_cast<float>(k_wake);
  return law;
}

// A collider that is not turned.
ColliderFrame upright(sandglass_shape shape, Vector place, float size = 0.0f) {
  ColliderFrame frame = {};
  frame.shape = shape;
  set(frame.position, place);
  frame.size[0] = size;
  for (int k = 0; k < 3; ++k) frame.axes[k][k] = 1.0f;
  return frame;
}

std::vector<uint32_t> all_groups(const Cluster& cluster) {
  std::vector<uint32_t> groups(cluster.rows / k_lane_group);
  for (uint32_t g = 0; g < groups.size(); ++g) groups[g] = g;
  return groups;
}

// One pass for particle i: (4.14-4.27) of the dissertation averaged by (4.37), then the floor y = -0.004.
// *runs_into_sleeper tells whether it touches a sleeper.
Vector displacement_oracle(Cluster& c, uint32_t i, bool solve, bool* runs_into_sleeper) {
  const Vector g = {0, -9.81 * k_step * k_step, 0};
  const auto weight = [&](uint32_t j) { return static_cast<double>(inverse_mass(c.records[j])); };
  const auto moved = [&](uint32_t j) {
    return solve && j < c.count ? k_step * at(c.records[j].velocity) + (is_awake(c.records[j]) ? 1.0 : 0.0) * g
                                : Vector{};
  };
  *runs_into_sleeper = false;
  Vector sum, lift;
  int contacts = 0;
  for (uint32_t j = 0; j < c.inert; ++j) {
    if (j == i || (j >= c.count && j < c.rows)) continue;
    if (in_body(c.records[i]) && body_of(c.records[i]) == body_of(c.records[j])) continue;
    const bool fixed = !is_awake(c.records[j]);
    const Vector relative = moved(j) - moved(i);
    const Vector e = at(c.records[j].position) - at(c.records[i].position) + relative;
    const double d = length(e);
    if (d >= 0.02) continue;
    if (is_asleep(c.records[j])) *runs_into_sleeper = true;
    const Vector n = (1 / d) * e;
    const double z = k_weight * n.y;
    const double overlap = d - 0.02;
    ++contacts;
    // The lower of two equal particles takes 1/2 + asymmetry, times its share by mass. The masses are m exp(-k h), the
    // correction to (4.38) of the dissertation.
    const double asymmetry = -z / 4 + z * z * z / 48;
    const double share = fixed ? 1.0 : weight(i) / (weight(i) + weight(j));
    const double a = weight(i) * (0.5 + asymmetry), b = weight(j) * (0.5 - asymmetry);
    sum = sum + share * overlap * n;
    if (!fixed) lift = lift + overlap * (a / (a + b) - share) * n;
    if (!solve) continue;
    const Vector t = share * (relative - dot(relative, n) * n);
    const double limit = share * std::fabs(overlap);
    sum = sum + (length(t) <= k_static * limit ? 1.0 : std::min(1.0, k_kinetic * limit / length(t))) * t;
  }
  // The part that the weighting adds raises a particle by at most k_lift.
  const double omega = std::min(1.0, k_omega / std::max(contacts, 1)), rise = omega * lift.y;
  Vector move = moved(i) + omega * (sum + std::min(1.0, k_lift / std::max(rise, 1e-30)) * lift);
  const double inside = k_cluster_radius - (at(c.records[i].position).y + move.y + 0.004);
  const double depth = solve ? std::min(inside, std::max(k_leave - move.y, 0.0)) : inside;  // that is undone
  if (inside > 0) {
    if (solve) {
      const Vector t = {-move.x, 0, -move.z};
      move = move + (length(t) <= k_static * depth ? 1.0 : std::min(1.0, k_kinetic * depth / length(t))) * t;
    }
    move.y += depth;
  }
  return move;
}

void check_contact(uint32_t n, bool solve) {
  Cluster cluster(n, n / 2, 0.6, 23);
  mix(&cluster);
  std::vector<uint32_t> lists(uint64_t{cluster.rows} * k_list_slots, cluster.inert);
  std::vector<uint8_t> counts(cluster.rows);
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < cluster.inert; ++j) {
      if (j != i && (j < n || j >= cluster.rows) && distance(cluster.records[i], cluster.records[j]) < 0.022) {
        ASSERT_LT(counts[i], k_list_slots);
        lists[i * k_list_slots + counts[i]++] = j;
      }
    }
  }
  const ColliderFrame floor = upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.004, 0});
  AveragedArgs args = {};
  args.law = contact_law();
  args.end.in = cluster.records.data();
  args.lists = lists.data();
  args.counts = counts.data();
  args.end.particle_count = n;
  args.end.radius = k_cluster_radius;
  args.end.static_friction = static_cast<float>(k_static);
  args.end.kinetic_friction = static_cast<float>(k_kinetic);
  args.scale = static_cast<float>(k_step);
  args.gravity[1] = static_cast<float>(-9.81 * k_step * k_step);
  args.end.step = static_cast<float>(k_step);
  args.last = 0;
  args.end.leave_max = static_cast<float>(k_leave);
  args.end.displacement_max = 1.0f;
  args.end.colliders = &floor;
  args.end.collider_count = 1;
  const std::vector<uint32_t> groups = all_groups(cluster);
  args.end.groups = groups.data();
  std::vector<Particle> first;
  for (const Kernels* kernels : tables()) {
    std::vector<Particle> out(cluster.inert + k_slack);
    args.end.out = out.data();
    ContactExtent extent = {};
    (solve ? kernels->contact_solve : kernels->contact_stabilise)(&args, 0, n, &extent);
    const std::vector<Particle> all(out.begin(), out.begin() + n);
    for (uint32_t i = 0; i < n; ++i) {
      bool into_sleeper = false;
      const Vector expected =
          is_awake(cluster.records[i]) ? displacement_oracle(cluster, i, solve, &into_sleeper) : Vector{};
      const Vector result = solve ? at(all[i].velocity) : at(all[i].position) - at(cluster.records[i].position);
      // Positions of a few centimetres are rounded to 4e-9 m in float, and there are a dozen contacts.
      ASSERT_LT(length(result - expected), 1e-7) << sandglass_isa_name(kernels->isa) << " particle " << i;
    }
    if (first.empty()) first = all;
    ASSERT_TRUE(same_bits(all, first)) << sandglass_isa_name(kernels->isa);
    if (!solve) continue;

    // The kernel runs as the last pass. It marks the groups in which a fast particle runs into a sleeper, and no
    // others.
    std::vector<uint8_t> touched(groups.size(), 0);
    args.law.touched = touched.data();
    args.last = 1;
    kernels->contact_solve(&args, 0, n, &extent);
    args.last = 0;
    std::vector<uint8_t> expected(groups.size(), 0);
    for (uint32_t i = 0; i < n; ++i) {
      bool into_sleeper = false;
      if (!is_awake(cluster.records[i])) continue;
      const double moved = length(displacement_oracle(cluster, i, true, &into_sleeper));
      ASSERT_GT(std::fabs(moved - k_wake), 1e-8) << "too near the threshold to decide; change the seed";
      if (into_sleeper && moved > k_wake) expected[i / k_lane_group] = 1;
    }
    ASSERT_EQ(touched, expected) << sandglass_isa_name(kernels->isa);
    ASSERT_EQ(extent.touched != 0, std::count(expected.begin(), expected.end(), 1) != 0);
  }
}

void check_contact_solve(uint32_t n) { check_contact(n, true); }
void check_contact_stabilise(uint32_t n) { check_contact(n, false); }

// ---- predict_motion, contact_pairs, complete_motion

void check_predict_motion(uint32_t n) {
  Cluster cluster(n, 0, 0.6, 29);
  mix(&cluster);
  const std::vector<uint32_t> groups = all_groups(cluster);
  PredictArgs args = {};
  args.in = cluster.records.data();
  args.groups = groups.data();
  args.scale = static_cast<float>(k_step);
  args.gravity[1] = static_cast<float>(-9.81 * k_step * k_step);
  std::vector<Particle> first;
  for (const Kernels* kernels : tables()) {
    std::vector<Particle> out(cluster.inert + k_slack);
    args.out = out.data();
    uint32_t unused = 0;
    kernels->predict_motion(&args, 0, n, &unused);
    const std::vector<Particle> all(out.begin(), out.begin() + n);
    for (uint32_t i = 0; i < n; ++i) {
      Vector expected = k_step * at(cluster.records[i].velocity);
      if (is_awake(cluster.records[i])) expected.y -= 9.81 * k_step * k_step;
      ASSERT_LT(length(at(all[i].velocity) - expected), 1e-9) << sandglass_isa_name(kernels->isa);
      ASSERT_EQ(length(at(all[i].position) - at(cluster.records[i].position)), 0.0);
      ASSERT_EQ(all[i].mobility, cluster.records[i].mobility);
      ASSERT_EQ(all[i].identity, cluster.records[i].identity);
    }
    if (first.empty()) first = all;
    ASSERT_TRUE(same_bits(all, first)) << sandglass_isa_name(kernels->isa);
  }
}

// What a pair adds to the displacements of its particles a and b.
struct PairOracle {
  Vector a, b;
  bool touches = false;
};
PairOracle pair_oracle(const Particle& a, const Particle& b) {
  PairOracle result;
  const double wa = is_awake(a) ? static_cast<double>(inverse_mass(a)) : 0.0,
               wb = is_awake(b) ? static_cast<double>(inverse_mass(b)) : 0.0;
  const Vector relative = at(b.velocity) - at(a.velocity), e = at(b.position) - at(a.position) + relative;
  const double d = length(e);
  if (d >= 0.02 || wa + wb == 0.0 || (in_body(a) && body_of(a) == body_of(b))) return result;
  result.touches = true;
  const Vector n = (1 / d) * e;
  const double along = dot(relative, n), z = k_weight * n.y, share = wa / (wa + wb);
  const double overlap = std::max(d - 0.02, std::min(0.0, along - k_separation) / k_omega);
  const double lower = wa * (0.5 - z / 4 + z * z * z / 48), upper = wb * (0.5 + z / 4 - z * z * z / 48);
  double lift = lower / (lower + upper) - share;
  // The lift ends where the two rise by k_lift on average.
  const double rise = overlap * lift * n.y, room = std::max(0.0, k_lift - 0.5 * (a.velocity[1] + b.velocity[1]));
  if (rise > room) lift *= room / rise;
  // With a body it is upright.
  const Vector raised = (lift * overlap) * (in_body(a) || in_body(b) ? Vector{0.0, n.y, 0.0} : n);
  const Vector t = k_stick * (relative - along * n);
  const double limit = std::fabs(overlap);
  const double grip = length(t) <= k_static * limit ? 1.0 : std::min(1.0, k_kinetic * limit / length(t));
  result.a = k_omega * ((share * overlap) * n + raised + (share * grip) * t);
  result.b = -k_omega * (((1 - share) * overlap) * n - raised + ((1 - share) * grip) * t);
  return result;
}

void check_contact_pairs(uint32_t n) {
  for (const bool fixed : {false, true}) {
    Cluster cluster(2 * n, n, 0.6, 31);
    mix(&cluster);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<uint32_t> first(2 * n + k_slack, cluster.inert), second = first;
    for (uint32_t q = 0; q < n; ++q) {
      first[q] = 2 * q;
      second[q] = fixed ? cluster.rows + q : 2 * q + 1;
      // Two of three pairs touch. All have displacements as large as those of a sub-step.
      Particle &a = cluster.records[first[q]], &b = cluster.records[second[q]];
      const Vector way = {unit(random), unit(random), unit(random)};
      set(b.position, at(a.position) + ((q % 3 == 0 ? 0.021 : 0.0195) / length(way)) * way);
      set(a.velocity, 1e-4 * Vector{unit(random), unit(random), unit(random)});
      if (!fixed) set(b.velocity, 1e-4 * Vector{unit(random), unit(random), unit(random)});
    }
    // Groups in any order.
    std::vector<uint32_t> groups((n + k_lane_group - 1) / k_lane_group);
    for (size_t at = 0; at < groups.size(); ++at) groups[at] = static_cast<uint32_t>(groups.size() - 1 - at);
    PairArgs args = {};
    args.first = first.data();
    args.second = second.data();
    args.groups = groups.data();
    args.fixed = fixed ? 1 : 0;
    args.law = contact_law();
    args.inverse_relaxation = static_cast<float>(1.0 / k_omega);
    args.separation_max = static_cast<float>(k_separation);
    args.stick = static_cast<float>(k_stick);
    std::vector<Particle> all_first;
    for (const Kernels* kernels : tables()) {
      std::vector<Particle> all = cluster.records;
      std::vector<uint8_t> touched(cluster.rows / k_lane_group, 0), expected_touched = touched;
      args.particles = all.data();
      args.law.touched = touched.data();
      uint32_t any_touched = 0;
      kernels->contact_pairs(&args, 0, (n + k_lane_group - 1) / k_lane_group * k_lane_group, &any_touched);
      uint32_t touching = 0;
      for (uint32_t q = 0; q < n; ++q) {
        const Particle &a = cluster.records[first[q]], &b = cluster.records[second[q]];
        const PairOracle pair = pair_oracle(a, b);
        touching += pair.touches ? 1 : 0;
        const Vector moved_a = at(all[first[q]].velocity) - at(a.velocity),
                     moved_b = at(all[second[q]].velocity) - at(b.velocity);
        // Positions of a few centimetres are rounded to 4e-9 m in float.
        ASSERT_LT(length(moved_a - pair.a), 2e-8) << sandglass_isa_name(kernels->isa) << " pair " << q;
        ASSERT_LT(length(moved_b - pair.b), 2e-8) << sandglass_isa_name(kernels->isa) << " pair " << q;
        if (pair.touches && is_asleep(b) && length(at(a.velocity)) > k_wake)
          expected_touched[first[q] / k_lane_group] = 1;
        if (pair.touches && is_asleep(a) && !fixed && length(at(b.velocity)) > k_wake)
          expected_touched[second[q] / k_lane_group] = 1;
      }
      if (n >= 9) {
        ASSERT_GT(touching, n / 4) << "the pairs test little";
      }
      ASSERT_EQ(touched, expected_touched) << sandglass_isa_name(kernels->isa);
      ASSERT_EQ(any_touched != 0, std::count(touched.begin(), touched.end(), 1) != 0);
      if (all_first.empty()) all_first = all;
      ASSERT_TRUE(same_bits(all, all_first)) << sandglass_isa_name(kernels->isa);
    }
  }
}

void check_complete_motion(uint32_t n) {
  constexpr double k_most = 2e-4;
  Cluster cluster(n, 0, 0.6, 37);
  mix(&cluster);
  for (uint32_t i = 0; i < n; ++i) {
    if (is_awake(cluster.records[i])) set(cluster.records[i].velocity, 4e-4 * at(cluster.records[i].velocity));
    set_departed(&cluster.records[i], i % 5 == 0);
  }
  // It takes some of the particles by a little, so that it does not drive them beyond the limit.
  const ColliderFrame floor = upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.5 * cluster.side, 0});
  const std::vector<uint32_t> groups = all_groups(cluster);
  CompleteArgs args = {};
  args.groups = groups.data();
  args.particle_count = n;
  args.radius = k_cluster_radius;
  args.static_friction = static_cast<float>(k_static);
  args.kinetic_friction = static_cast<float>(k_kinetic);
  args.step = static_cast<float>(k_step);
  args.displacement_max = static_cast<float>(k_most);
  args.leave_max = static_cast<float>(k_leave);
  args.colliders = &floor;
  args.collider_count = 1;
  args.departed = n % 2 == 0 ? 1 : 0;
  std::vector<Particle> first;
  for (const Kernels* kernels : tables()) {
    std::vector<Particle> all = cluster.records;
    args.in = args.out = all.data();
    ContactExtent extent = {};
    kernels->complete_motion(&args, 0, n, &extent);
    double fastest = 0.0;
    uint32_t deep = 0;  // deeper in the floor than they may leave it in one step
    for (uint32_t i = 0; i < n; ++i) {
      const Particle& before = cluster.records[i];
      Vector move = is_awake(before) ? at(before.velocity) : Vector{};
      const double inside = k_cluster_radius - (at(before.position).y + move.y + 0.5 * cluster.side);
      const double depth = std::min(inside, std::max(k_leave - move.y, 0.0));
      deep += is_awake(before) && depth < inside ? 1u : 0u;
      if (is_awake(before) && inside > 0) {
        const Vector t = {-move.x, 0, -move.z};
        move = move + (length(t) <= k_static * depth ? 1.0 : std::min(1.0, k_kinetic * depth / length(t))) * t;
        move.y += depth;
      }
      const bool departed = args.departed != 0 && has_departed(before);
      if (length(move) > k_most && !departed) move = (k_most / length(move)) * move;
      ASSERT_LT(length(at(all[i].position) - (at(before.position) + move)), 1e-8) << sandglass_isa_name(kernels->isa);
      ASSERT_LT(length(at(all[i].velocity) - (1 / k_step) * move), 1e-4) << sandglass_isa_name(kernels->isa);
      if (!departed) fastest = std::max(fastest, length(at(all[i].velocity)));
    }
    ASSERT_NEAR(std::sqrt(static_cast<double>(extent.speed_squared)), fastest, 1e-5);
    if (n >= 16) {
      ASSERT_GT(deep, 0u);
    }
    const std::vector<Particle> moved(all.begin(), all.begin() + n);
    if (first.empty()) first = moved;
    ASSERT_TRUE(same_bits(moved, first)) << sandglass_isa_name(kernels->isa);
  }
}

// ---- wake_near

void check_wake_near(uint32_t n) {
  Cluster cluster(n, 0, 0.3, 41);
  mix(&cluster);
  const ColliderFrame colliders[2] = {upright(SANDGLASS_SHAPE_SPHERE, {0.01, 0, 0}, 0.02f),
                                      upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.03, 0})};
  const float margins[2] = {0.005f, 0.012f};
  std::vector<Sleeper> sleepers(cluster.inert + k_slack);
  std::memcpy(sleepers.data(), cluster.records.data(), sleepers.size() * sizeof(Sleeper));
  for (uint32_t i = 0; i < n; i += 3) sleepers[i].radius = 0.004f;
  std::vector<Sleeper> first;
  for (const Kernels* kernels : tables()) {
    std::vector<Sleeper> moved = sleepers;
    const WakeArgs args = {moved.data(), n, colliders, margins, 2};
    uint32_t woken = 0, expected = 0;
    kernels->wake_near(&args, 0, n, &woken);
    for (uint32_t i = 0; i < n; ++i) {
      const Sleeper& sleeper = sleepers[i];
      const Vector x = at(sleeper.position);
      const double ball = length(x - Vector{0.01, 0, 0}) - 0.02 - 0.005, floor = x.y + 0.03 - 0.012;
      const double gap = std::min(ball, floor) - static_cast<double>(sleeper.radius);
      ASSERT_GT(std::fabs(gap), 1e-8);
      const bool wakes = sleeper.mobility < 0.0f && gap < 0;
      expected += wakes ? 1 : 0;
      ASSERT_EQ(moved[i].mobility, wakes ? -sleeper.mobility : sleeper.mobility) << sandglass_isa_name(kernels->isa);
    }
    ASSERT_EQ(woken, expected);
    if (first.empty()) first = moved;
    ASSERT_TRUE(same_bits(moved, first));
  }
}

// ---- find_inside

void check_find_inside(uint32_t n) {
  Cluster cluster(n, 0, 0.3, 43);
  const ColliderFrame shapes[2] = {upright(SANDGLASS_SHAPE_SPHERE, {0, 0, 0.02}, 0.015f),
                                   upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.01, 0})};
  for (const Kernels* kernels : tables()) {
    std::vector<uint8_t> inside(cluster.rows, 7);
    const InsideArgs args = {as_records(cluster.records.data()), n, shapes, 2, inside.data()};
    uint32_t found = 0, expected = 0;
    kernels->find_inside(&args, 0, n, &found);
    for (uint32_t i = 0; i < n; ++i) {
      const Vector x = at(cluster.records[i].position);
      const double gap = std::min(length(x - Vector{0, 0, 0.02}) - 0.015, x.y + 0.01);
      ASSERT_GT(std::fabs(gap), 1e-8);
      ASSERT_EQ(inside[i], gap < 0 ? 1 : 0) << sandglass_isa_name(kernels->isa);
      expected += gap < 0 ? 1 : 0;
    }
    ASSERT_EQ(found, expected);
  }
}

// ---- surface_at

// The value and gradient of the trilinear interpolant at a point within the grid, in double.
double trilinear(const FieldGrid& grid, Vector p, Vector* gradient) {
  const double at[3] = {(p.x - static_cast<double>(grid.low[0])) / static_cast<double>(grid.spacing),
                        (p.y - static_cast<double>(grid.low[1])) / static_cast<double>(grid.spacing),
                        (p.z - static_cast<double>(grid.low[2])) / static_cast<double>(grid.spacing)};
  uint32_t cell[3];
  double f[3], slope[3] = {0, 0, 0}, value = 0;
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::min(static_cast<uint32_t>(at[k]), grid.counts[k] - 2);
    f[k] = at[k] - cell[k];
  }
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const uint32_t d[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const uint32_t index = (cell[0] + d[0]) + grid.counts[0] * ((cell[1] + d[1]) + grid.counts[1] * (cell[2] + d[2]));
    const double v = static_cast<double>(grid.values[index]);
    double weight[3], sign[3];
    for (int k = 0; k < 3; ++k) {
      weight[k] = d[k] != 0 ? f[k] : 1 - f[k];
      sign[k] = d[k] != 0 ? 1 : -1;
    }
    value += v * weight[0] * weight[1] * weight[2];
    for (int k = 0; k < 3; ++k) slope[k] += v * sign[k] * weight[(k + 1) % 3] * weight[(k + 2) % 3];
  }
  *gradient = (1 / std::sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2])) *
              Vector{slope[0], slope[1], slope[2]};
  return value;
}

void check_surface_at(uint32_t n) {
  // A field of waves that is turned by a quarter about z. Local x is world y, and local y is world -x.
  std::vector<float> values(7 * 6 * 5);
  for (size_t i = 0; i < values.size(); ++i) values[i] = 0.01f * std::sin(0.7f * static_cast<float>(i));
  ColliderFrame frame = {};
  frame.shape = SANDGLASS_SHAPE_FIELD;
  frame.axes[0][1] = 1.0f;
  frame.axes[1][0] = -1.0f;
  frame.axes[2][2] = 1.0f;
  frame.position[0] = 0.01f;
  for (const float outward : {1.0f, -1.0f}) {
    frame.field = {values.data(), {7, 6, 5}, {-0.03f, -0.025f, -0.02f}, 0.01f, 100.0f, outward, outward * 0.002f};
    Cluster cluster(n, 0, 0.1, 47);
    std::vector<SurfacePoint> first;
    for (const Kernels* kernels : tables()) {
      std::vector<SurfacePoint> found(cluster.inert + k_slack);
      std::memcpy(found.data(), cluster.records.data(), found.size() * sizeof(SurfacePoint));
      const SurfaceArgs args = {found.data(), &frame};
      uint32_t unused = 0;
      kernels->surface_at(&args, 0, n, &unused);
      for (uint32_t i = 0; i < n; ++i) {
        const Vector world = at(cluster.records[i].position) - Vector{static_cast<double>(frame.position[0]), 0, 0};
        const Vector local = {world.y, -world.x, world.z};
        const Vector near = {std::clamp(local.x, -0.03, 0.03), std::clamp(local.y, -0.025, 0.025),
                             std::clamp(local.z, -0.02, 0.02)};
        const double out = length(local - near);
        Vector normal;
        double distance;
        if (out > 1e-7) {
          normal = (static_cast<double>(outward) / out) * (local - near);
          distance = outward > 0 ? std::max(out, static_cast<double>(frame.field.border))
                                 : static_cast<double>(frame.field.border) - out;
        } else {
          distance = trilinear(frame.field, local, &normal);
        }
        const Vector turned = {-normal.y, normal.x, normal.z};
        ASSERT_NEAR(found[i].distance, distance, 1e-7) << sandglass_isa_name(kernels->isa) << " point " << i;
        ASSERT_LT(length(at(found[i].normal) - turned), 2e-4) << sandglass_isa_name(kernels->isa) << " point " << i;
      }
      found.resize(n);
      if (first.empty()) first = found;
      ASSERT_TRUE(same_bits(found, first));
    }
  }
}

// ---- pile_light

// Random columns in the middle of a row-padded grid. Some are empty, thinly filled or in the air. The light has two
// azimuths with random steps. On the floor the own column of one of them is a factor.
void check_pile_light_of(uint32_t n, uint32_t on_floor) {
  const uint32_t rows = 5, padded = (n + 15) / 16 * 16, pitch = padded + k_lane_group;
  std::mt19937 random(53);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<float> tops(rows * pitch + 3 * k_lane_group, -1e30f), bottoms(tops.size(), 1e30f),
      fills(tops.size(), 0.0f);
  const auto place = [&](uint32_t row, uint32_t column) { return k_lane_group + row * pitch + column; };
  for (uint32_t v = 0; v < rows; ++v)
    for (uint32_t u = 0; u < n; ++u) {
      if (unit(random) < 0.3) continue;
      tops[place(v, u)] = static_cast<float>(0.05 + 0.1 * unit(random));
      bottoms[place(v, u)] = static_cast<float>(0.06 * unit(random) - 0.02);
      fills[place(v, u)] = unit(random) < 0.4 ? 1.0f : static_cast<float>(unit(random));
    }
  std::vector<float> receivers(padded);
  for (float& r : receivers) r = static_cast<float>(0.02 * unit(random));
  std::vector<PileStep> steps(12);
  for (PileStep& step : steps)
    step = {static_cast<int32_t>(7 * unit(random)) - 3, static_cast<int32_t>(9 * unit(random)) - 4,
            static_cast<float>(20 + 60 * unit(random))};
  // The slopes whose sin^2 are 0.2 and 0.83, 0.1 and 0.73.
  const PileAzimuth azimuths[2] = {
      {0.2f, 0.9f, 1.0f, 0.5f, 2.2096042f, 0, 5, {-0.6f, 0.1f, 0.2f, 0.25f, 0.05f}, 1.2f, 20.0f, 1},
      {0.1f, 0.8f, 0.7f, 0.33333333f, 1.6442943f, 5, 12, {}, 0, 0, 0}};
  const double total = 0.7 + 0.7 * 0.7;
  std::vector<float> first;
  for (const Kernels* kernels : tables()) {
    std::vector<float> shares(padded);
    PileLightArgs args = {};
    args.tops = tops.data() + k_lane_group;
    args.bottoms = bottoms.data() + k_lane_group;
    args.fills = fills.data() + k_lane_group;
    args.pitch = pitch;
    args.row = 2;
    args.sand_rows[0] = 0;
    args.sand_rows[1] = rows - 1;
    args.sand_columns[0] = 0;
    args.sand_columns[1] = static_cast<int32_t>(n) - 1;
    args.receivers = receivers.data();
    args.azimuths = azimuths;
    args.azimuth_count = 2;
    args.steps = steps.data();
    args.on_floor = on_floor;
    args.inverse_total = static_cast<float>(1 / total);
    args.shares = shares.data();
    uint32_t unused = 0;
    kernels->pile_light(&args, 0, padded, &unused);
    for (uint32_t i = 0; i < n; ++i) {
      double sum = 0;
      for (const PileAzimuth& azimuth : azimuths) {
        // `reached` is the slope up to which the azimuth is dark. A column closes its filled share of the way that is
        // left up to its own top.
        const double foot = static_cast<double>(azimuth.foot), cap = static_cast<double>(azimuth.cap);
        double high = 0, low = 1e30, reached = foot;
        const bool thin = on_floor != 0 && azimuth.thin != 0;
        for (uint32_t s = azimuth.last_step; s-- > azimuth.first_step + (thin ? 1 : 0);) {
          const int row = 2 + steps[s].rows, column = static_cast<int>(i) + steps[s].columns;
          if (row < 0 || row >= static_cast<int>(rows) || column < 0 || column >= static_cast<int>(n)) continue;
          const uint32_t at = place(static_cast<uint32_t>(row), static_cast<uint32_t>(column));
          if (tops[at] < 0) continue;
          const double inverse = static_cast<double>(steps[s].inverse_distance);
          const double slope = static_cast<double>(tops[at] - receivers[i]) * inverse;
          high = std::max(high, slope);
          if (std::min(slope, cap) > reached)
            reached += static_cast<double>(fills[at]) * (std::min(slope, cap) - reached);
          low = std::min(low, static_cast<double>(bottoms[at] - receivers[i]) * inverse);
        }
        // The share of the azimuth that no column hides.
        const double from = std::pow(std::sin(std::atan(std::max(low, 0.0))), 2),
                     to = std::pow(std::sin(std::atan(high)), 2);
        const double hidden = std::max(
            0.0, std::min(to, static_cast<double>(azimuth.high)) - std::max(from, static_cast<double>(azimuth.low)));
        const double dark = high > foot ? (reached - foot) / (std::min(high, cap) - foot) : 0.0;
        double left = 1;
        if (thin && tops[place(2, i)] > 0) {
          const double open = 1 - static_cast<double>(fills[place(2, i)]), powers[5] = {0, 0.25, 0.5, 1, 2};
          double change = 0;
          for (int k = 0; k < 5; ++k) change += static_cast<double>(azimuth.own[k]) * std::pow(open, powers[k]);
          left += std::clamp(static_cast<double>(azimuth.near_from) - static_cast<double>(bottoms[place(2, i)]) *
                                                                          static_cast<double>(azimuth.near_per_metre),
                             0.0, 1.0) *
                  change;
        }
        sum += static_cast<double>(azimuth.weight) * std::clamp(left, 0.0, 1.0) *
               (static_cast<double>(azimuth.high - azimuth.low) - hidden * dark);
      }
      ASSERT_NEAR(shares[i], std::min(sum / total, 1.0), 2e-6) << sandglass_isa_name(kernels->isa) << " texel " << i;
    }
    shares.resize(n);
    if (first.empty()) first = shares;
    ASSERT_EQ(std::memcmp(shares.data(), first.data(), n * sizeof(float)), 0);
  }
}

void check_pile_light(uint32_t n) {
  for (const uint32_t on_floor : {0u, 1u}) check_pile_light_of(n, on_floor);
}

// ---- pile_sky

// Random columns in four padded rows. Some are empty, thinly filled or in the air. Three sectors walk steps that leave
// the columns on both sides; of the third all columns stand on the floor.
void check_pile_sky(uint32_t n) {
  constexpr uint32_t rows = 4, sector_count = 3, steps_each = 5;
  const uint32_t padded = (n + 15) / 16 * 16, pitch = padded + 2 * k_lane_group;
  std::mt19937 random(59);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<float> tops(rows * pitch + 3 * k_lane_group, -1e30f), bottoms(tops.size(), 1e30f),
      fills(tops.size(), 0.0f);
  const auto row_start = [&](uint32_t row) { return 2 * k_lane_group + row * pitch; };
  for (uint32_t v = 0; v < rows; ++v)
    for (uint32_t u = 0; u < n; ++u) {
      if (unit(random) < 0.3) continue;
      tops[row_start(v) + u] = static_cast<float>(0.05 + 0.1 * unit(random));
      bottoms[row_start(v) + u] = v == rows - 1 ? 0.0f : static_cast<float>(0.06 * unit(random) - 0.02);
      fills[row_start(v) + u] = unit(random) < 0.4 ? 1.0f : static_cast<float>(unit(random));
    }
  std::vector<float> receivers(padded);
  for (float& r : receivers) r = static_cast<float>(0.02 * unit(random));
  PileSector sectors[sector_count];
  double shares[sector_count][4];
  std::vector<PileSkyStep> steps;
  for (uint32_t k = 0; k < sector_count; ++k) {
    for (uint32_t ring = 0; ring < 4; ++ring) {
      shares[k][ring] = 0.08 * unit(random);
      sectors[k].bends[ring] = static_cast<float>(shares[k][ring] - (ring > 0 ? shares[k][ring - 1] : 0.0));
    }
    sectors[k].first_step = k * steps_each;
    sectors[k].last_step = (k + 1) * steps_each;
    sectors[k].in_air = k + 1 < sector_count;
    for (uint32_t s = 0; s < steps_each; ++s) {
      const uint32_t row = k + 1 < sector_count ? s % rows : rows - 1;
      const int32_t columns = static_cast<int32_t>(21 * unit(random)) - 10;
      steps.push_back({static_cast<int32_t>(row_start(row)) + columns, -columns, static_cast<int32_t>(n) - 1 - columns,
                       static_cast<float>(3 + 40 * unit(random))});
    }
  }
  std::vector<float> first;
  for (const Kernels* kernels : tables()) {
    std::vector<float> lights(padded);
    PileSkyArgs args = {};
    args.tops = tops.data();
    args.bottoms = bottoms.data();
    args.fills = fills.data();
    args.steps = steps.data();
    args.sectors = sectors;
    args.sector_count = sector_count;
    args.cap = 2.0f;
    args.receivers = receivers.data();
    args.lights = lights.data();
    uint32_t unused = 0;
    kernels->pile_sky(&args, 0, padded, &unused);
    for (uint32_t i = 0; i < n; ++i) {
      double left = 1;
      for (uint32_t k = 0; k < sector_count; ++k) {
        double high = 0, low = 1e30, reached = 0;
        for (uint32_t s = sectors[k].first_step; s < sectors[k].last_step; ++s) {
          const int texel = static_cast<int>(i);
          if (texel < steps[s].first || texel > steps[s].last) continue;
          const int at = steps[s].at + texel;
          if (tops[at] < 0) continue;
          const double inverse = static_cast<double>(steps[s].inverse_distance);
          const double slope = static_cast<double>(tops[at] - receivers[i]) * inverse;
          high = std::max(high, slope);
          reached += static_cast<double>(fills[at]) * std::max(std::min(slope, 2.0) - reached, 0.0);
          low = std::min(low, static_cast<double>(bottoms[at] - receivers[i]) * inverse);
        }
        if (!(high > 0)) continue;
        const double from = 4 * std::pow(std::sin(std::atan(std::max(low, 0.0))), 2);
        const double to = 4 * std::pow(std::sin(std::atan(high)), 2);
        for (uint32_t ring = 0; ring < 4; ++ring) {
          const auto part = [&](double x) { return std::clamp(x - ring, 0.0, 1.0); };
          left -= shares[k][ring] * std::max(part(to) - part(from), 0.0) * reached / std::min(high, 2.0);
        }
      }
      ASSERT_NEAR(lights[i], std::max(left, 0.0), 2e-6) << sandglass_isa_name(kernels->isa) << " texel " << i;
    }
    lights.resize(n);
    if (first.empty()) first = lights;
    ASSERT_EQ(std::memcmp(lights.data(), first.data(), n * sizeof(float)), 0);
  }
}

// ---- cast_triangles

// Triangles of all sizes, some of which leave the image; every one is tested against every texel's middle.
void check_cast_triangles(uint32_t n) {
  constexpr uint32_t texels = 128, words = texels / 64;
  std::mt19937 random(67);
  std::uniform_real_distribution<double> unit(-1, 1);
  const uint32_t padded = (n + 15) / 16 * 16;
  std::vector<float> corners[9];
  for (auto& array : corners) array.assign(padded + k_lane_group, 0.0f);
  for (uint32_t i = 0; i < n; ++i) {
    const double size = i % 3 == 0 ? 0.5 : 0.03, x = unit(random), y = 0.3 + 0.3 * unit(random), z = unit(random);
    for (uint32_t c = 0; c < 3; ++c) {
      corners[3 * c][i] = static_cast<float>(x + size * unit(random));
      corners[3 * c + 1][i] = static_cast<float>(y + 0.2 * size * unit(random));
      corners[3 * c + 2][i] = static_cast<float>(z + size * unit(random));
    }
  }
  for (const uint32_t closed : {0u, 1u}) {
    std::vector<uint64_t> first;
    CastExtent first_extent = {};
    for (const Kernels* kernels : tables()) {
      std::vector<uint64_t> image(texels * words);
      CastTrianglesArgs args = {};
      for (uint32_t c = 0; c < 9; ++c) args.corners[c] = corners[c].data();
      const float scale[2] = {70, 60}, shear[2] = {25, -14}, offset[2] = {63.2f, 60.9f};
      for (uint32_t axis = 0; axis < 2; ++axis) {
        args.scale[axis] = scale[axis];
        args.shear[axis] = shear[axis];
        args.offset[axis] = offset[axis];
      }
      args.texels = texels;
      args.words = words;
      args.closed = closed;
      args.image = image.data();
      CastExtent extent = {0, 0, ~0u, 0};
      kernels->cast_triangles(&args, 0, padded, &extent);
      if (first.empty()) {
        first = image;
        first_extent = extent;
        uint32_t certain = 0;
        for (uint32_t v = 0; v < texels; ++v)
          for (uint32_t u = 0; u < texels; ++u) {
            bool hidden = false, near_edge = false;
            for (uint32_t i = 0; i < n; ++i) {
              double p[3][2];
              for (uint32_t c = 0; c < 3; ++c) {
                const double y = static_cast<double>(corners[3 * c + 1][i]);
                p[c][0] = static_cast<double>(corners[3 * c][i]) * 70.0 - y * 25.0 + static_cast<double>(offset[0]) - u;
                p[c][1] =
                    static_cast<double>(corners[3 * c + 2][i]) * 60.0 + y * 14.0 + static_cast<double>(offset[1]) - v;
              }
              const double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
              if (closed != 0 && area > 1e-3) continue;
              double least = 1e9;  // the distance of the middle from the edges, inwards
              for (uint32_t e = 0; e < 3; ++e) {
                const double *a = p[e], *b = p[(e + 1) % 3], cross = a[0] * b[1] - a[1] * b[0];
                least = std::min(least, (area < 0 ? -cross : cross) / std::hypot(b[0] - a[0], b[1] - a[1]));
              }
              hidden = hidden || least > 1e-4;
              near_edge = near_edge || std::fabs(least) <= 1e-4 || std::fabs(area) <= 1e-3;
            }
            if (near_edge && !hidden) continue;
            ++certain;
            ASSERT_EQ(image[v * words + u / 64] >> (u % 64) & 1, hidden ? 1u : 0u)
                << u << " " << v << " closed " << closed;
          }
        ASSERT_GT(certain, texels * texels * 9 / 10);
      }
      ASSERT_EQ(image, first) << sandglass_isa_name(kernels->isa);
      ASSERT_EQ(std::memcmp(&extent, &first_extent, sizeof extent), 0) << sandglass_isa_name(kernels->isa);
    }
  }
}

// ---- cast_window, cast_calm

std::vector<float> counts_of(uint32_t n, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> counts(n + 4 * k_lane_group);
  for (float& count : counts) count = static_cast<float>(random() % 12);
  return counts;
}

void check_cast_window(uint32_t n) {
  const uint32_t padded = (n + 15) / 16 * 16;
  const std::vector<float> row = counts_of(padded, 71);
  for (const uint32_t radius : {1u, 2u, 4u})
    for (const Kernels* kernels : tables()) {
      std::vector<float> low(padded), high(padded), sum(padded);
      const CastWindowArgs args = {row.data() + k_lane_group, radius, low.data(), high.data(), sum.data()};
      uint32_t unused = 0;
      kernels->cast_window(&args, 0, padded, &unused);
      for (uint32_t i = 0; i < n; ++i) {
        const auto from = row.begin() + k_lane_group + i - radius, to = from + 2 * radius + 1;
        ASSERT_EQ(low[i], *std::min_element(from, to));
        ASSERT_EQ(high[i], *std::max_element(from, to));
        ASSERT_EQ(sum[i], std::accumulate(from, to, 0.0f)) << sandglass_isa_name(kernels->isa);  // whole numbers: exact
      }
    }
}

void check_cast_calm(uint32_t n) {
  const uint32_t padded = (n + 15) / 16 * 16;
  for (const uint32_t rows : {3u, 5u, 9u}) {
    std::vector<float> low[k_cast_rows], high[k_cast_rows], sum[k_cast_rows];
    CastCalmArgs args = {};
    for (uint32_t k = 0; k < rows; ++k) {
      low[k] = counts_of(padded, k);
      high[k] = low[k];
      sum[k] = counts_of(padded, 100 + k);
      for (float& x : high[k]) x += static_cast<float>(k % 4);
      args.low[k] = low[k].data();
      args.high[k] = high[k].data();
      args.sum[k] = sum[k].data();
    }
    args.rows = rows;
    args.most = 8;
    const std::vector<float> before = counts_of(padded, 73);
    std::vector<float> first;
    for (const Kernels* kernels : tables()) {
      std::vector<float> row = before;
      args.row = row.data();
      uint32_t unused = 0;
      kernels->cast_calm(&args, 0, padded, &unused);
      for (uint32_t i = 0; i < n; ++i) {
        double least = 1e9, most = -1e9, all = 0;
        for (uint32_t k = 0; k < rows; ++k) {
          least = std::min(least, static_cast<double>(low[k][i]));
          most = std::max(most, static_cast<double>(high[k][i]));
          all += static_cast<double>(sum[k][i]);
        }
        const double share = std::clamp(2 - (most - least) / 4, 0.0, 1.0), x = static_cast<double>(before[i]);
        ASSERT_NEAR(row[i], x + share * (all / (rows * rows) - x), 1e-5) << sandglass_isa_name(kernels->isa);
      }
      row.resize(n);
      if (first.empty()) first = row;
      ASSERT_EQ(std::memcmp(row.data(), first.data(), n * sizeof(float)), 0);
    }
  }
}

// All tail lengths of the widest instruction set, and one cluster of many vectors.
void check_all_sizes(void (*check)(uint32_t)) {
  for (uint32_t n = 1; n <= 2 * k_lane_group + 1; ++n) {
    check(n);
    if (testing::Test::HasFatalFailure()) FAIL() << n << " items";
  }
  check(150);
}

#define SANDGLASS_KERNEL(user, name, Args, Result) \
  TEST(Oracle, name) { check_all_sizes(check_##name); }
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL

}  // namespace

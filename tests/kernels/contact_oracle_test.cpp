// The oracles of contact: the two averaged passes, the pairs, and what comes before and after them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/kernels/oracles.h"

namespace sandglass::tests {

namespace {

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

std::vector<uint32_t> all_groups(const Cluster& cluster) {
  std::vector<uint32_t> groups(cluster.rows / k_lane_group);
  for (uint32_t g = 0; g < groups.size(); ++g) groups[g] = g;
  return groups;
}

// How a pass ends: on one floor.
CompleteArgs ending(const Cluster& cluster, const std::vector<uint32_t>& groups, const ColliderFrame* floor,
                    float displacement_max) {
  CompleteArgs end = {};
  end.groups = groups.data();
  end.particle_count = cluster.count;
  end.radius = k_cluster_radius;
  end.static_friction = static_cast<float>(k_static);
  end.kinetic_friction = static_cast<float>(k_kinetic);
  end.step = static_cast<float>(k_step);
  end.displacement_max = displacement_max;
  end.leave_max = static_cast<float>(k_leave);
  end.colliders = floor;
  end.collider_count = 1;
  return end;
}

// The part of a slip that friction takes where a contact pushes by `limit`.
double grip(Vector slip, double limit) {
  return length(slip) <= k_static * limit ? 1.0 : std::min(1.0, k_kinetic * limit / length(slip));
}

// The displacement of what is `inside` the floor: it leaves by at most k_leave, with friction.
Vector out_of_floor(Vector move, double inside) {
  const double depth = std::min(inside, std::max(k_leave - move.y, 0.0));
  const Vector slip = {-move.x, 0, -move.z};
  return move + grip(slip, depth) * slip + Vector{0, depth, 0};
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
    sum = sum + grip(t, limit) * t;
  }
  // The part that the weighting adds raises a particle by at most k_lift.
  const double omega = std::min(1.0, k_omega / std::max(contacts, 1)), rise = omega * lift.y;
  Vector move = moved(i) + omega * (sum + std::min(1.0, k_lift / std::max(rise, 1e-30)) * lift);
  const double inside = k_cluster_radius - (at(c.records[i].position).y + move.y + 0.004);
  if (!(inside > 0)) return move;
  return solve ? out_of_floor(move, inside) : move + Vector{0, inside, 0};
}

// As the last pass the kernel marks the groups in which a fast particle runs into a sleeper, and no others.
void check_touched(const Kernels& kernels, Cluster* cluster, AveragedArgs args) {
  std::vector<uint8_t> touched(cluster->rows / k_lane_group, 0), expected = touched;
  args.law.touched = touched.data();
  args.last = 1;
  const ContactExtent extent = run(kernels.contact_solve, args, cluster->count);
  for (uint32_t i = 0; i < cluster->count; ++i) {
    bool into_sleeper = false;
    if (!is_awake(cluster->records[i])) continue;
    const double moved = length(displacement_oracle(*cluster, i, true, &into_sleeper));
    ASSERT_GT(std::fabs(moved - k_wake), 1e-8) << "too near the threshold to decide; change the seed";
    if (into_sleeper && moved > k_wake) expected[i / k_lane_group] = 1;
  }
  ASSERT_EQ(touched, expected);
  ASSERT_EQ(extent.touched != 0, std::count(expected.begin(), expected.end(), 1) != 0);
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
  const std::vector<uint32_t> groups = all_groups(cluster);
  AveragedArgs args = {};
  args.law = contact_law();
  args.end = ending(cluster, groups, &floor, 1.0f);
  args.end.in = cluster.records.data();
  args.lists = lists.data();
  args.counts = counts.data();
  args.scale = static_cast<float>(k_step);
  args.gravity[1] = static_cast<float>(-9.81 * k_step * k_step);
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<Particle> out(cluster.inert + k_slack);
    args.end.out = out.data();
    run(solve ? kernels.contact_solve : kernels.contact_stabilise, args, n);
    const std::vector<Particle> all(out.begin(), out.begin() + n);
    for (uint32_t i = 0; i < n; ++i) {
      bool into_sleeper = false;
      const Vector expected =
          is_awake(cluster.records[i]) ? displacement_oracle(cluster, i, solve, &into_sleeper) : Vector{};
      const Vector result = solve ? at(all[i].velocity) : at(all[i].position) - at(cluster.records[i].position);
      // Positions of a few centimetres are rounded to 4e-9 m in float, and there are a dozen contacts.
      ASSERT_LT(length(result - expected), 1e-7) << "particle " << i;
    }
    ASSERT_TRUE(same(all));
    if (solve) check_touched(kernels, &cluster, args);
  });
}

}  // namespace

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
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<Particle> out(cluster.inert + k_slack);
    args.out = out.data();
    run(kernels.predict_motion, args, n);
    const std::vector<Particle> all(out.begin(), out.begin() + n);
    for (uint32_t i = 0; i < n; ++i) {
      Vector expected = k_step * at(cluster.records[i].velocity);
      if (is_awake(cluster.records[i])) expected.y -= 9.81 * k_step * k_step;
      ASSERT_LT(length(at(all[i].velocity) - expected), 1e-9);
      ASSERT_EQ(length(at(all[i].position) - at(cluster.records[i].position)), 0.0);
      ASSERT_EQ(all[i].mobility, cluster.records[i].mobility);
      ASSERT_EQ(all[i].identity, cluster.records[i].identity);
    }
    ASSERT_TRUE(same(all));
  });
}

namespace {

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
  const Vector held = grip(t, std::fabs(overlap)) * t;
  result.a = k_omega * (share * (overlap * n + held) + raised);
  result.b = -k_omega * ((1 - share) * (overlap * n + held) - raised);
  return result;
}

}  // namespace

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
      const Vector direction = {unit(random), unit(random), unit(random)};
      set(b.position, at(a.position) + ((q % 3 == 0 ? 0.021 : 0.0195) / length(direction)) * direction);
      set(a.velocity, 1e-4 * Vector{unit(random), unit(random), unit(random)});
      if (!fixed) set(b.velocity, 1e-4 * Vector{unit(random), unit(random), unit(random)});
    }
    // Groups in any order.
    std::vector<uint32_t> groups(whole_groups(n) / k_lane_group);
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
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      std::vector<Particle> all = cluster.records;
      std::vector<uint8_t> touched(cluster.rows / k_lane_group, 0), expected_touched = touched;
      args.particles = all.data();
      args.law.touched = touched.data();
      const uint32_t any_touched = run(kernels.contact_pairs, args, whole_groups(n));
      uint32_t touching = 0;
      for (uint32_t q = 0; q < n; ++q) {
        const Particle &a = cluster.records[first[q]], &b = cluster.records[second[q]];
        const PairOracle pair = pair_oracle(a, b);
        touching += pair.touches ? 1 : 0;
        const Vector moved_a = at(all[first[q]].velocity) - at(a.velocity),
                     moved_b = at(all[second[q]].velocity) - at(b.velocity);
        // Positions of a few centimetres are rounded to 4e-9 m in float.
        ASSERT_LT(length(moved_a - pair.a), 2e-8) << "pair " << q;
        ASSERT_LT(length(moved_b - pair.b), 2e-8) << "pair " << q;
        if (pair.touches && is_asleep(b) && length(at(a.velocity)) > k_wake)
          expected_touched[first[q] / k_lane_group] = 1;
        if (pair.touches && is_asleep(a) && !fixed && length(at(b.velocity)) > k_wake)
          expected_touched[second[q] / k_lane_group] = 1;
      }
      if (n >= 9) {
        ASSERT_GT(touching, n / 4) << "the pairs test little";
      }
      ASSERT_EQ(touched, expected_touched);
      ASSERT_EQ(any_touched != 0, std::count(touched.begin(), touched.end(), 1) != 0);
      ASSERT_TRUE(same(all));
    });
  }
}

void check_complete_motion(uint32_t n) {
  constexpr double k_displacement_max = 2e-4;
  Cluster cluster(n, 0, 0.6, 37);
  mix(&cluster);
  for (uint32_t i = 0; i < n; ++i) {
    if (is_awake(cluster.records[i])) set(cluster.records[i].velocity, 4e-4 * at(cluster.records[i].velocity));
    set_departed(&cluster.records[i], i % 5 == 0);
  }
  // It takes some of the particles by a little, so that it does not drive them beyond the limit.
  const ColliderFrame floor = upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.5 * cluster.side, 0});
  const std::vector<uint32_t> groups = all_groups(cluster);
  CompleteArgs args = ending(cluster, groups, &floor, static_cast<float>(k_displacement_max));
  args.departed = n % 2 == 0 ? 1 : 0;
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<Particle> all = cluster.records;
    args.in = args.out = all.data();
    const ContactExtent extent = run(kernels.complete_motion, args, n);
    double fastest = 0.0;
    uint32_t deep = 0;  // deeper in the floor than they may leave it in one step
    for (uint32_t i = 0; i < n; ++i) {
      const Particle& before = cluster.records[i];
      Vector move = is_awake(before) ? at(before.velocity) : Vector{};
      const double inside = k_cluster_radius - (at(before.position).y + move.y + 0.5 * cluster.side);
      if (is_awake(before) && inside > 0) {
        deep += std::max(k_leave - move.y, 0.0) < inside ? 1u : 0u;
        move = out_of_floor(move, inside);
      }
      const bool departed = args.departed != 0 && has_departed(before);
      if (length(move) > k_displacement_max && !departed) move = (k_displacement_max / length(move)) * move;
      ASSERT_LT(length(at(all[i].position) - (at(before.position) + move)), 1e-8);
      ASSERT_LT(length(at(all[i].velocity) - (1 / k_step) * move), 1e-4);
      if (!departed) fastest = std::max(fastest, length(at(all[i].velocity)));
    }
    ASSERT_NEAR(std::sqrt(static_cast<double>(extent.speed_squared)), fastest, 1e-5);
    if (n >= 16) {
      ASSERT_GT(deep, 0u);
    }
    const std::vector<Particle> moved(all.begin(), all.begin() + n);
    ASSERT_TRUE(same(moved));
  });
}

}  // namespace sandglass::tests

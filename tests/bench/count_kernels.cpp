// The workloads on which each float kernel is counted by itself: about a thousand items, without a scene. kernels.inc
// expands into the list, so a kernel without a function work_<name> does not compile.
//   count_kernels        prints the workloads' names, one a line
//   count_kernels NAME   runs one of them
//   count_kernels all    runs all of them between one pair of marks
#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

#include "kernels/kernels.h"
#include "runtime/sand/particles.h"
#include "tests/bench/counting.h"
#include "tests/motion_arrays.h"

namespace {

using namespace sandglass;

constexpr uint32_t k_items = 960, k_slack = 2 * k_lane_group;
constexpr float k_radius = 0.01f;

bool g_all = false;  // all run between one pair of marks

template <class Args, class Result>
void count(void (*kernel)(const Args*, uint32_t, uint32_t, Result*), const Args& args) {
  Result result = {};
  if (!g_all) counting_begins();
  kernel(&args, 0, k_items, &result);
  if (!g_all) counting_ends();
}

// Aligned like the scene's block: two particles or grains in a cache line.
template <class Item>
struct Records {
  struct alignas(64) Line {
    Item items[2] = {};
  };
  explicit Records(uint32_t count) : lines((count + 1) / 2) {}
  Item* data() { return lines[0].items; }
  Item& operator[](uint32_t i) { return data()[i]; }
  std::vector<Line> lines;
};

// Particles in a pile as dense as sand, every fifth asleep, every sixth of a rigid body. Behind them lies the inert
// particle.
struct Pile {
  Pile() : records(k_items + k_slack), lists(k_items * k_list_slots, k_items), counts(k_items) {
    CountingRandom random;
    for (uint32_t i = 0; i < k_items + k_slack; ++i) {
      if (i >= k_items) {
        records[i] = inert_particle();
        continue;
      }
      const bool asleep = i % 5 == 2;
      const float x[3] = {side * random(), side * random(), side * random()};
      float v[3] = {0, 0, 0};
      for (int k = 0; !asleep && k < 3; ++k) v[k] = random() - 0.5f;
      records[i] = moving_particle(x, v, i);
      join_body(&records[i], i % 6 == 1 ? 1 : 0, 1.0f);
      if (asleep) put_to_sleep(&records[i]);
    }
    for (uint32_t i = 0; i < k_items; ++i)
      for (uint32_t j = 0; j < k_items && counts[i] < k_list_slots; ++j) {
        float squared = 0;
        for (int k = 0; k < 3; ++k) {
          const float difference = records[i].position[k] - records[j].position[k];
          squared += difference * difference;
        }
        if (j != i && squared < reach * reach) lists[i * k_list_slots + counts[i]++] = j;
      }
    for (uint32_t g = 0; g < k_items / k_lane_group; ++g) groups.push_back(g);
  }
  static constexpr float reach = 2.4f * k_radius, side = 0.22f;  // 0.7 particles per diameter cubed
  Records<Particle> records;
  std::vector<uint32_t> lists, groups;
  std::vector<uint8_t> counts;
};

// The pile sorted by cell.
struct Sorted {
  Sorted(Pile* pile, const Kernels& kernels, float cell, uint32_t bits_min)
      : records(k_items + k_slack), starts(4096 + k_slack), keys(k_items + k_slack) {
    for (std::vector<float>& axis : axes) axis.resize(k_items + k_slack, k_inert_position);
    const float low[3] = {0, 0, 0}, high[3] = {Pile::side, Pile::side, Pile::side};
    sort.cells_max = 4096;
    sort.starts = starts.data();
    sort.keys = keys.data();
    cell_sort_begin(&sort, cell, low, high, bits_min);
    const SortTarget target = {as_records(records.data()), {axes[0].data(), axes[1].data(), axes[2].data()}, false};
    while (sort.phase != k_sort_done)
      cell_sort_run(&sort, kernels, as_records(pile->records.data()), k_items, k_items, target);
  }
  Records<Particle> records;
  std::vector<float> axes[3];
  std::vector<uint32_t> starts, keys;
  CellSort sort = {};
};

ColliderFrame still(sandglass_shape shape, float size, float height) {
  ColliderFrame frame = {};
  frame.shape = shape;
  frame.position[0] = frame.position[2] = 0.5f * Pile::side;
  frame.position[1] = height;
  for (int k = 0; k < 3; ++k) {
    frame.axes[k][k] = 1.0f;
    frame.size[k] = size;
  }
  return frame;
}

// A ball of 4 cm as a field, in the middle of the pile.
struct Field {
  static constexpr uint32_t n = 17;
  Field() : values(n * n * n), frame(still(SANDGLASS_SHAPE_FIELD, 0.0f, 0.5f * Pile::side)) {
    constexpr float half = 0.08f, spacing = 2 * half / (n - 1);
    for (uint32_t i = 0; i < n * n * n; ++i) {
      const float x = spacing * static_cast<float>(i % n) - half, y = spacing * static_cast<float>(i / n % n) - half,
                  z = spacing * static_cast<float>(i / n / n) - half;
      values[i] = std::sqrt(x * x + y * y + z * z) - 0.04f;
    }
    frame.field = {values.data(), {n, n, n}, {-half, -half, -half}, spacing, 1.0f / spacing, 1.0f, half - 0.04f};
  }
  std::vector<float> values;
  ColliderFrame frame;
};

// Books of 1 cm cells under the pile.
struct Books {
  static constexpr uint32_t n = 48;
  Books() : heights(n * n + 1, 0.03f), frame(still(SANDGLASS_SHAPE_RELIEF, 0.0f, 0.0f)) {
    for (uint32_t i = 0; i < n * n; ++i) heights[i] = i % n / 7 % 2 + i / n / 9 % 2 == 2 ? 0.03f : 0.0f;
    constexpr float half = 0.005f * (n - 1);
    frame.field = {heights.data(), {n, 1, n}, {-half, 0, -half}, 0.01f, 100.0f, 1.0f, 0.0f};
    frame.offset = k_radius;
  }
  std::vector<float> heights;
  ColliderFrame frame;
};

void work_grid_cells(const Kernels& kernels) {
  Pile pile;
  std::vector<uint32_t> keys(k_items + k_slack);
  const GridCellsArgs args = {
      {1.0f / Pile::reach, {3, 3, 3}, nullptr}, as_records(pile.records.data()), keys.data(), 0, {0, 0, 0}};
  count(kernels.grid_cells, args);
}

void work_neighbour_lists(const Kernels& kernels) {
  Pile pile;
  Sorted sorted(&pile, kernels, Pile::reach, 2);
  std::vector<uint8_t> near_counts(k_items);
  ListArgs args = {};
  args.grid = sorted.sort.grid;
  for (int k = 0; k < 3; ++k) args.positions[k] = sorted.axes[k].data();
  args.inert = k_items;
  args.reach_squared = Pile::reach * Pile::reach;
  args.near_squared = 4.4f * k_radius * k_radius;
  args.lists = pile.lists.data();
  args.counts = pile.counts.data();
  args.near_counts = near_counts.data();
  count(kernels.neighbour_lists, args);
}

// A pass of the pile on a floor, with a second collider `beside`.
struct Pass {
  explicit Pass(const ColliderFrame* beside)
      : out(k_items + k_slack), touched(pile.groups.size()), colliders(1, still(SANDGLASS_SHAPE_HALF_SPACE, 0, 0)) {
    constexpr float step = 3e-4f;
    if (beside != nullptr) colliders.push_back(*beside);
    law.diameter = 2 * k_radius;
    law.static_friction = law.kinetic_friction = 0.14f;
    law.relaxation = 0.3f;
    law.weight_linear = -0.15f;
    law.weight_cubic = 0.0045f;
    law.lift_max = 2e-5f;
    law.up[1] = 1.0f;
    law.bodies = 1;
    law.wake_displacement = 1e-4f;
    law.touched = touched.data();
    predict = {pile.records.data(), out.data(), pile.groups.data(), step, {0.0f, -9.81f * step * step, 0.0f}};
    complete.in = pile.records.data();
    complete.out = out.data();
    complete.groups = pile.groups.data();
    complete.particle_count = k_items;
    complete.radius = k_radius;
    complete.step = step;
    complete.static_friction = complete.kinetic_friction = 0.14f;
    complete.displacement_max = 1.0f;
    complete.leave_max = 3e-5f;
    complete.colliders = colliders.data();
    complete.collider_count = static_cast<uint32_t>(colliders.size());
    averaged.law = law;
    averaged.end = complete;
    averaged.lists = pile.lists.data();
    averaged.counts = pile.counts.data();
    averaged.last = 1;
    averaged.scale = step;
    averaged.gravity[1] = predict.gravity[1];
  }
  Pile pile;
  Records<Particle> out;
  std::vector<uint8_t> touched;
  std::vector<ColliderFrame> colliders;
  ContactLaw law = {};
  PredictArgs predict = {};
  CompleteArgs complete = {};
  AveragedArgs averaged = {};
};

void work_contact_stabilise(const Kernels& kernels) { count(kernels.contact_stabilise, Pass(nullptr).averaged); }
void work_contact_solve(const Kernels& kernels) { count(kernels.contact_solve, Pass(nullptr).averaged); }
void work_contact_solve_beside_a_field(const Kernels& kernels) {
  const Field field;
  count(kernels.contact_solve, Pass(&field.frame).averaged);
}
void work_predict_motion(const Kernels& kernels) { count(kernels.predict_motion, Pass(nullptr).predict); }
void work_complete_motion(const Kernels& kernels) { count(kernels.complete_motion, Pass(nullptr).complete); }
void work_complete_motion_beside_a_relief(const Kernels& kernels) {
  const Books books;
  count(kernels.complete_motion, Pass(&books.frame).complete);
}

// As many pairs of the lists as there are items. No two of a lane group share a particle. Every third touches.
void work_contact_pairs(const Kernels& kernels) {
  Pass pass(nullptr);
  Pile& pile = pass.pile;
  std::vector<uint32_t> first(k_items, k_items), second(k_items, k_items), filled(k_items / k_lane_group);
  for (uint32_t i = 0; i < k_items; ++i) {
    for (int k = 0; k < 3; ++k) pile.records[i].velocity[k] *= pass.complete.step;
    for (uint32_t n = 0; n < pile.counts[i]; ++n) {
      const uint32_t j = pile.lists[i * k_list_slots + n];
      if (j < i) continue;
      for (uint32_t g = 0; g < filled.size(); ++g) {
        uint32_t* const ours = &first[g * k_lane_group];
        uint32_t* const others = &second[g * k_lane_group];
        bool free = filled[g] < k_lane_group;
        for (uint32_t l = 0; free && l < filled[g]; ++l)
          free = ours[l] != i && ours[l] != j && others[l] != i && others[l] != j;
        if (!free) continue;
        ours[filled[g]] = i;
        others[filled[g]++] = j;
        break;
      }
    }
  }
  std::vector<uint32_t> groups(filled.size());
  for (uint32_t at = 0; at < groups.size(); ++at) groups[at] = at;
  const PairArgs args = {pass.law, pile.records.data(), first.data(), second.data(), groups.data(),
                         0,        1.0f / 0.3f,         4e-4f,        0.25f};
  count(kernels.contact_pairs, args);
}

void work_wake_near(const Kernels& kernels) {
  Pile pile;
  const ColliderFrame colliders[2] = {still(SANDGLASS_SHAPE_HALF_SPACE, 0, 0),
                                      still(SANDGLASS_SHAPE_SPHERE, 0.04f, 0.1f)};
  const float margins[2] = {0.01f, 0.01f};
  const WakeArgs args = {as_sleepers(pile.records.data()), k_items, colliders, margins, 2};
  count(kernels.wake_near, args);
}

void work_find_inside(const Kernels& kernels) {
  Pile pile;
  const ColliderFrame shapes[2] = {still(SANDGLASS_SHAPE_BOX, 0.04f, 0.1f),
                                   still(SANDGLASS_SHAPE_CAPSULE, 0.03f, 0.15f)};
  std::vector<uint8_t> inside(k_items);
  const InsideArgs args = {as_records(pile.records.data()), k_items, shapes, 2, inside.data()};
  count(kernels.find_inside, args);
}

void work_surface_at(const Kernels& kernels) {
  Pile pile;
  const Field field;
  Records<SurfacePoint> points(k_items + k_slack);
  for (uint32_t i = 0; i < k_items; ++i)
    for (int k = 0; k < 3; ++k) points[i].position[k] = pile.records[i].position[k];
  const SurfaceArgs args = {points.data(), &field.frame};
  count(kernels.surface_at, args);
}

// Grains all over the pile, sixteen near to each other as after sorting.
Records<Grain> grains_of_the_pile() {
  Records<Grain> grains(k_items + k_slack);
  CountingRandom random = {7};
  for (uint32_t i = 0; i < k_items; i += k_lane_group) {
    float corner[3];
    for (float& c : corner) c = (Pile::side - 2 * k_radius) * random();
    for (uint32_t l = 0; l < k_lane_group; ++l)
      for (int k = 0; k < 3; ++k) grains[i + l].position[k] = corner[k] + 2 * k_radius * random();
  }
  return grains;
}

// The grid of the pile's motion.
struct Motion : MotionArrays {
  Motion() : MotionArrays(512) {
    ParticleMotion configured = {};
    configured.grid = grid;
    sandglass_granular_desc desc = {};
    desc.particle_radius = k_radius;
    motion_configure(&configured, desc);
    grid = configured.grid;
  }
  void fill(const Kernels& kernels, Pile* pile) {
    scatter(kernels, pile->records.data(), k_items, k_time);
    for (uint32_t b = 0; b < grid.block_count; ++b) motion_smooth(grid, b);
  }
  static constexpr float k_time = 0.016f;
};

void work_scatter_motion(const Kernels& kernels) {
  Pile pile;
  Motion motion;
  const ScatterMotionArgs args = {&motion.grid, pile.records.data(), k_items, Motion::k_time, nullptr, nullptr};
  count(kernels.scatter_motion, args);
}

void work_count_grains(const Kernels& kernels) {
  Pile pile;
  Motion motion;
  motion.fill(kernels, &pile);
  Records<Grain> grains = grains_of_the_pile();
  const CountGrainsArgs args = {&motion.grid, grains.data(), k_items};
  count(kernels.count_grains, args);
}

// Two steps of grains all over the pile; without `motion` each looks the particles up.
void refine(const Kernels& kernels, const ColliderFrame& beside, Motion* motion) {
  Pile pile;
  Sorted snapshot(&pile, kernels, 3 * k_radius, 3);
  Records<Grain> grains = grains_of_the_pile();
  std::vector<uint8_t> still_groups(pile.groups.size());
  std::vector<uint32_t> stamps(pile.groups.size());
  RefineArgs args = {};
  args.grid = snapshot.sort.grid;
  args.snapshot = snapshot.records.data();
  for (int k = 0; k < 3; ++k) args.positions[k] = snapshot.axes[k].data();
  args.grains = grains.data();
  args.grain_count = k_items;
  args.groups = pile.groups.data();
  args.still = still_groups.data();
  args.stamps = stamps.data();
  args.still_distance = 1e-4f;
  args.still_sweeps = 4.0f;
  args.support = 3 * k_radius;
  args.step = 0.008f;
  args.steps = 2;
  args.gravity[1] = -9.81f;
  args.speed_scale = 0.443f;
  args.push = 0.15f * k_radius;
  args.push_max = 0.1f * k_radius;
  args.push_reach = 1.2f * k_radius;
  if (motion != nullptr) {
    motion->fill(kernels, &pile);
    args.motion = &motion->grid;
  }
  args.weight_at_radius = 512.0f / 729.0f;
  args.colliders = &beside;
  args.collider_count = 1;
  args.grain_radius = 0.35f * k_radius;
  args.friction = 0.14f;
  count(kernels.refine_grains, args);
}

void work_refine_grains(const Kernels& kernels) {
  Motion motion;
  refine(kernels, still(SANDGLASS_SHAPE_HALF_SPACE, 0, 0), &motion);
}
void work_refine_grains_beside_a_field(const Kernels& kernels) {
  Motion motion;
  const Field field;
  refine(kernels, field.frame, &motion);
}
void work_refine_grains_beside_a_relief(const Kernels& kernels) {
  Motion motion;
  const Books books;
  refine(kernels, books.frame, &motion);
}
void work_refine_grains_without_a_grid(const Kernels& kernels) {
  refine(kernels, still(SANDGLASS_SHAPE_HALF_SPACE, 0, 0), nullptr);
}

// One row of columns, half of them empty, along eight azimuths of eight steps each.
void work_pile_light(const Kernels& kernels) {
  constexpr uint32_t rows = 17, pitch = k_items + k_lane_group, azimuth_count = 8, steps_each = 8;
  CountingRandom random;
  std::vector<float> tops(rows * pitch + 2 * k_lane_group, -1e30f), bottoms(tops.size(), 1e30f), fills(tops.size());
  for (uint32_t i = 0; i < tops.size(); ++i)
    if (i % pitch >= k_lane_group && random() < 0.5f) {
      tops[i] = 0.1f * random();
      bottoms[i] = 0.0f;
      fills[i] = random();
    }
  std::vector<float> receivers(k_items), shares(k_items);
  PileAzimuth azimuths[azimuth_count];
  PileStep steps[azimuth_count * steps_each];
  for (uint32_t a = 0; a < azimuth_count; ++a) {
    azimuths[a] = {0.2f, 0.8f, 1.0f, 0.5f, 2.0f, a * steps_each, (a + 1) * steps_each, {-1, 0, 0, 1, 0}, 1, 10, 1};
    for (uint32_t s = 0; s < steps_each; ++s)
      steps[a * steps_each + s] = {static_cast<int32_t>(s + 1), static_cast<int32_t>(a * s / 8),
                                   200.0f / static_cast<float>(s + 1)};
  }
  PileLightArgs args = {};
  args.tops = tops.data() + k_lane_group;
  args.bottoms = bottoms.data() + k_lane_group;
  args.fills = fills.data() + k_lane_group;
  args.pitch = pitch;
  args.row = rows / 2;
  args.sand_rows[1] = rows - 1;
  args.sand_columns[1] = static_cast<int32_t>(k_items) - 1;
  args.receivers = receivers.data();
  args.azimuths = azimuths;
  args.azimuth_count = azimuth_count;
  args.steps = steps;
  args.on_floor = 1;
  args.inverse_total = 1.0f / (0.6f * azimuth_count);
  args.shares = shares.data();
  count(kernels.pile_light, args);
}

// One row of columns, half of them empty, in sixteen sectors of ten steps each.
void work_pile_sky(const Kernels& kernels) {
  constexpr uint32_t rows = 10, pitch = k_items + 2 * k_lane_group, sector_count = 16;
  CountingRandom random;
  std::vector<float> tops(rows * pitch + k_lane_group, -1e30f), bottoms(tops.size(), 1e30f), fills(tops.size());
  for (uint32_t i = 0; i < tops.size(); ++i)
    if (i % pitch >= k_lane_group && random() < 0.5f) {
      tops[i] = 0.1f * random();
      bottoms[i] = 0.0f;
      fills[i] = random();
    }
  std::vector<float> receivers(k_items), lights(k_items);
  PileSector sectors[sector_count];
  PileSkyStep steps[sector_count * rows];
  for (uint32_t k = 0; k < sector_count; ++k) {
    sectors[k] = {{0.01f, 0.01f, -0.005f, -0.005f}, k * rows, (k + 1) * rows, k % 2};
    for (uint32_t s = 0; s < rows; ++s)
      steps[k * rows + s] = {static_cast<int32_t>(s * pitch + k_lane_group + k), 0, static_cast<int32_t>(k_items) - 1,
                             200.0f / static_cast<float>(s + 1)};
  }
  PileSkyArgs args = {};
  args.tops = tops.data();
  args.bottoms = bottoms.data();
  args.fills = fills.data();
  args.steps = steps;
  args.sectors = sectors;
  args.sector_count = sector_count;
  args.cap = 2.0f;
  args.receivers = receivers.data();
  args.lights = lights.data();
  count(kernels.pile_sky, args);
}

// Small triangles over an image of 128 x 128 texels.
void work_cast_triangles(const Kernels& kernels) {
  constexpr uint32_t texels = 128, words = texels / 64;
  CountingRandom random;
  std::vector<float> corners[9];
  for (auto& array : corners) array.resize(k_items + k_slack);
  for (uint32_t i = 0; i < k_items; ++i) {
    const float middle[3] = {random(), 0.3f * random(), random()};
    for (uint32_t c = 0; c < 9; ++c) corners[c][i] = middle[c % 3] + 0.05f * random();
  }
  std::vector<uint64_t> image(texels * words);
  CastTrianglesArgs args = {};
  for (uint32_t c = 0; c < 9; ++c) args.corners[c] = corners[c].data();
  for (uint32_t axis = 0; axis < 2; ++axis) {
    args.scale[axis] = 110;
    args.shear[axis] = 40;
    args.offset[axis] = 10;
  }
  args.texels = texels;
  args.words = words;
  args.image = image.data();
  count(kernels.cast_triangles, args);
}

// The widest of the filter's windows.
void work_cast_window(const Kernels& kernels) {
  std::vector<float> row(k_items + k_slack), low(k_items), high(k_items), sum(k_items);
  const CastWindowArgs args = {row.data() + k_lane_group, 4, low.data(), high.data(), sum.data()};
  count(kernels.cast_window, args);
}
void work_cast_calm(const Kernels& kernels) {
  std::vector<float> row(k_items), window(k_items);
  CastCalmArgs args = {};
  for (uint32_t k = 0; k < k_cast_rows; ++k) args.low[k] = args.high[k] = args.sum[k] = window.data();
  args.rows = k_cast_rows;
  args.difference_max = 8;
  args.row = row.data();
  count(kernels.cast_calm, args);
}

struct Work {
  const char* name;
  void (*run)(const Kernels& kernels);
};
constexpr Work k_works[] = {
#define SANDGLASS_KERNEL(user, name, Args, Result) {#name, work_##name},
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL
    {"contact_solve_beside_a_field", work_contact_solve_beside_a_field},
    {"refine_grains_beside_a_field", work_refine_grains_beside_a_field},
    {"complete_motion_beside_a_relief", work_complete_motion_beside_a_relief},
    {"refine_grains_beside_a_relief", work_refine_grains_beside_a_relief},
    {"refine_grains_without_a_grid", work_refine_grains_without_a_grid},
};

}  // namespace

int main(int argument_count, char** arguments) {
  const Kernels& kernels = *select_kernels(SANDGLASS_ISA_AUTOMATIC);
  bool found = argument_count < 2;
  g_all = argument_count > 1 && std::strcmp(arguments[1], "all") == 0;
  if (g_all) counting_begins();
  for (const Work& work : k_works) {
    if (argument_count < 2) std::printf("%s\n", work.name);
    else if (g_all || std::strcmp(arguments[1], work.name) == 0) {
      work.run(kernels);
      found = true;
    }
  }
  if (g_all) counting_ends();
  if (!found) return wrong("count_kernels: no kernel has the name ", arguments[1]);
  if (argument_count > 1) std::printf("isa %s\nitems %u\n", sandglass_isa_name(kernels.isa), k_items);
  return 0;
}

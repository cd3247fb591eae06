// The caller's memory: exactly the stated bytes suffice; one byte less is refused and nothing is touched. Also
// capacity, alignment and bad arguments.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "models/mesh/generated.h"
#include "tests/guarded_block.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

constexpr float k_distance = 0.1f;
constexpr float k_mark = -77.0f;
constexpr uint32_t k_plenty = 5000;
constexpr sandglass_status k_invalid = SANDGLASS_ERROR_INVALID_ARGUMENT;

// A sampler with its memory.
struct Run {
  const char* name;
  sandglass_sample_desc desc;

  uint64_t bytes(uint32_t capacity) const {
    uint64_t need = 0;
    EXPECT_EQ(sandglass_sample_bytes(&desc, capacity, &need, nullptr), SANDGLASS_OK);
    return need;
  }
  // The points of a run that must succeed.
  Points points(GuardedBlock* scratch, uint32_t capacity) const {
    Points points(3 * capacity);
    uint32_t count = 0;
    const char* reason = "not cleared";
    EXPECT_EQ(
        sandglass_sample_points(&desc, scratch->data(), scratch->bytes(), points.data(), capacity, &count, &reason),
        SANDGLASS_OK);
    EXPECT_EQ(reason, nullptr);
    EXPECT_TRUE(scratch->guards_intact());
    points.resize(3 * count);
    return points;
  }
  // A run that must be refused, and leave the points as they are.
  void refused(sandglass_status expected, void* scratch, uint64_t bytes, uint32_t capacity) const {
    Points points(3 * k_plenty, k_mark);
    uint32_t count = 99;
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_sample_points(&desc, scratch, bytes, points.data(), capacity, &count, &reason), expected);
    EXPECT_NE(reason, nullptr);
    EXPECT_EQ(count, 0u);
    EXPECT_EQ(points, Points(3 * k_plenty, k_mark));
  }
};

const host::Mesh& ball() {
  static const host::Mesh mesh = host::make_icosphere(0.5f, 2);
  return mesh;
}

// Of a ball's surface or of the unit cube.
sandglass_sample_desc desc_of(sandglass_sample_method method) {
  static const sandglass_mesh mesh = ball().view();
  sandglass_sample_desc desc = desc_with_seed(1);
  desc.method = method;
  desc.distance = k_distance;
  desc.mesh = &mesh;
  for (float& edge : desc.bounds_max) edge = 1;
  desc.inside = [](void*, const float*) { return int32_t{1}; };
  return desc;
}

Run geodesic_run() {
  Run run = {"geodesic", desc_of(SANDGLASS_SAMPLE_SURFACE)};
  run.desc.metric = SANDGLASS_METRIC_GEODESIC;
  return run;
}

class Memory : public testing::TestWithParam<Run> {};

TEST_P(Memory, exactly_the_named_bytes_and_capacity_suffice) {
  GuardedBlock ample(GetParam().bytes(k_plenty));
  const Points points = GetParam().points(&ample, k_plenty);
  const uint32_t count = static_cast<uint32_t>(points.size() / 3);
  EXPECT_GT(count, 100u);
  GuardedBlock exact(GetParam().bytes(count));
  EXPECT_EQ(GetParam().points(&exact, count), points);
  for (uint32_t capacity : {count - 1, 1u, 0u}) {
    GuardedBlock block(GetParam().bytes(capacity));
    GetParam().refused(SANDGLASS_ERROR_CAPACITY, block.data(), block.bytes(), capacity);
    EXPECT_TRUE(block.guards_intact());
  }
}

TEST_P(Memory, one_byte_less_or_a_wrong_alignment_is_refused_and_nothing_touched) {
  const uint64_t need = GetParam().bytes(k_plenty);
  GuardedBlock scratch(need + 64);
  for (uint64_t bytes : {need - 1, need / 2, uint64_t{0}})
    GetParam().refused(SANDGLASS_ERROR_MEMORY_TOO_SMALL, scratch.data(), bytes, k_plenty);
  GetParam().refused(SANDGLASS_ERROR_MEMORY_ALIGNMENT, scratch.data() + 4, need, k_plenty);
  EXPECT_TRUE(scratch.untouched());
}

INSTANTIATE_TEST_SUITE_P(Samplers, Memory,
                         testing::Values(Run{"surface", desc_of(SANDGLASS_SAMPLE_SURFACE)}, geodesic_run(),
                                         Run{"volume", desc_of(SANDGLASS_SAMPLE_VOLUME)},
                                         Run{"lattice", desc_of(SANDGLASS_SAMPLE_LATTICE)}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(Arguments, bad_meshes_are_refused_everywhere) {
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> vertices = {0, 0, 0, 1, 0, 0, 0, 0, 1};
  const std::vector<uint32_t> indices = {0, 1, 2}, beyond = {0, 1, 3}, line = {0, 1, 1};
  std::vector<sandglass_mesh> bad = {{vertices.data(), 3, beyond.data(), 1},
                                     {vertices.data(), 3, indices.data(), 0},
                                     {vertices.data(), 0, indices.data(), 1},
                                     {nullptr, 3, indices.data(), 1},
                                     {vertices.data(), 3, nullptr, 1}};
  std::vector<Points> poisoned(4, vertices);
  for (size_t i = 0; i < 4; ++i) {
    poisoned[i][4] = std::array{nan, infinity, -infinity, 1001.0f}[i];
    bad.push_back({poisoned[i].data(), 3, indices.data(), 1});
  }
  const float place[3] = {0, 0, 0};
  sandglass_sample_desc desc = desc_of(SANDGLASS_SAMPLE_SURFACE);
  uint32_t capacity = 0;
  for (size_t i = 0; i < bad.size(); ++i) {
    const sandglass_mesh* mesh = &bad[i];
    float low[3], high[3];
    double number = 0;
    uint64_t bytes = 0;
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_mesh_bounds(mesh, low, high, &reason), k_invalid) << i;
    EXPECT_NE(reason, nullptr);
    EXPECT_EQ(sandglass_mesh_area(mesh, &number, nullptr), k_invalid) << i;
    EXPECT_EQ(sandglass_mesh_winding_number(mesh, place, &number, nullptr), k_invalid) << i;
    EXPECT_EQ(sandglass_mesh_inside_bytes(mesh, SANDGLASS_INSIDE_PARITY, &bytes, nullptr), k_invalid) << i;
    desc.mesh = mesh;
    EXPECT_EQ(sandglass_sample_capacity(&desc, &capacity, nullptr), k_invalid) << i;
  }
  const sandglass_mesh flat = {vertices.data(), 3, line.data(), 1};
  desc.mesh = &flat;
  EXPECT_EQ(sandglass_sample_capacity(&desc, &capacity, nullptr), k_invalid);
  uint64_t bytes = 0;
  const sandglass_mesh good = ball().view();
  EXPECT_EQ(sandglass_mesh_inside_bytes(&good, 2, &bytes, nullptr), k_invalid);
}

TEST(Arguments, every_field_out_of_range_is_refused) {
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  const auto refused = [](const sandglass_sample_desc& desc) {
    uint32_t capacity = 0;
    uint64_t bytes = 0;
    const char* reason = nullptr;
    EXPECT_EQ(sandglass_sample_capacity(&desc, &capacity, &reason), k_invalid);
    EXPECT_NE(reason, nullptr);
    EXPECT_EQ(sandglass_sample_bytes(&desc, k_plenty, &bytes, nullptr), k_invalid);
  };
  for (int method = 0; method < 3; ++method) {
    SCOPED_TRACE(method);
    const sandglass_sample_desc good = desc_of(method);
    for (const float distance : {nan, infinity, 0.0f, -1.0f, 1e-9f, 1e-38f}) {
      sandglass_sample_desc desc = good;
      desc.distance = distance;
      refused(desc);
    }
    const float boxes[4][3] = {{nan, 1, 1}, {1, infinity, 1}, {1, 1, -1}, {1, 1001, 1}};
    for (const auto& high : boxes) {
      sandglass_sample_desc desc = good;
      std::copy(high, high + 3, desc.bounds_max);
      if (method != SANDGLASS_SAMPLE_SURFACE) refused(desc);
    }
    for (int field = 0; field < 5; ++field) {
      sandglass_sample_desc desc = good;
      if (field == 0) desc.struct_size = 4;
      if (field == 1) desc.tries = 0;
      if (field == 2) desc.tries = 1001;
      if (field == 3) desc.metric = 2;
      if (field == 4) desc.method = 3;
      refused(desc);
    }
  }
}

TEST(Arguments, progress_is_told_and_never_beyond_the_total) {
  struct Progress {
    int calls = 0;
    uint64_t last = 0;
    bool ordered = true;
  } progress;
  sandglass_sample_desc desc = desc_with_seed(1);
  desc.progress_user = &progress;
  desc.progress = [](void* user, uint64_t done, uint64_t total) {
    auto* t = static_cast<Progress*>(user);
    t->ordered = t->ordered && done >= t->last && (total == 0 || done <= total);
    t->last = done;
    ++t->calls;
  };
  for (const bool surface : {true, false}) {
    progress = {};
    if (surface) sample_surface(ball(), 0.02f, desc);
    else sample_volume(k_unit_box, 0.05f, everywhere, desc);
    EXPECT_GT(progress.calls, 1);
    EXPECT_TRUE(progress.ordered);
  }
}

}  // namespace
}  // namespace sandglass::test

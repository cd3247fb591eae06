// The cases of `verify granular` that take moments, each with its negative control. Also tested is the apparatus that
// they use.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

#include "models/simulation/metrics.h"
#include "tests/laboratory/sand/apparatus.h"
#include "tests/laboratory/sand/flow_cases.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {
namespace {

// The table is asserted as `verify granular` prints it: every claim holds, and every control fails as it must. Left out
// is what takes long (`far` and the flows).
struct QuickGroup {
  const char* name;
  size_t rows_min;
};
void PrintTo(const QuickGroup& group, std::ostream* out) { *out << group.name; }

class QuickVerdicts : public testing::TestWithParam<QuickGroup> {};

TEST_P(QuickVerdicts, EveryRowHolds) {
  VerdictChoice choice;
  choice.groups = {GetParam().name};
  const std::vector<Verdict> rows = granular_verdicts(choice, [](uint64_t, uint64_t) { return true; });
  EXPECT_GE(rows.size(), GetParam().rows_min);
  for (const Verdict& row : rows)
    EXPECT_TRUE(row.pass) << row.name << ": " << row.result << ", truth " << row.truth << " within " << row.limit;
}

INSTANTIATE_TEST_SUITE_P(Granular, QuickVerdicts,
                         testing::Values(QuickGroup{"particle", 7}, QuickGroup{"rest", 7}, QuickGroup{"hard", 7},
                                         QuickGroup{"momentum", 4}, QuickGroup{"refinement", 5}),
                         [](const auto& group) { return std::string(group.param.name); });

TEST(Scattered, NoneOverlapAndAllAreInside) {
  constexpr double k_radius = 0.01, k_shaft = 0.1;
  const std::vector<float> points = scattered(500, k_shaft, 0.2, k_radius, 3);
  ASSERT_EQ(points.size(), 1500u);
  for (size_t i = 0; i < points.size(); i += 3) {
    const double x = points[i], y = points[i + 1], z = points[i + 2];
    EXPECT_GE(y, 0.2 + k_radius);
    EXPECT_LE(std::sqrt(x * x + z * z), k_shaft - k_radius);
    for (size_t j = 0; j < i; j += 3)
      ASSERT_GE(std::hypot(x - static_cast<double>(points[j]), y - static_cast<double>(points[j + 1]),
                           z - static_cast<double>(points[j + 2])),
                2.0 * k_radius);
  }
  EXPECT_EQ(points, scattered(500, k_shaft, 0.2, k_radius, 3));
  EXPECT_NE(points, scattered(500, k_shaft, 0.2, k_radius, 4));
}

TEST(Laws, AreThoseThatWerePublished) {
  EXPECT_NEAR(lube_runout(1.0), 1.24, 1e-12);
  EXPECT_NEAR(lube_runout(4.0), 3.2, 1e-12);
  const std::vector<double> x = {5.0, 6.0, 7.0, 10.0};
  std::vector<double> y;
  for (const double v : x) y.push_back(3.0 * std::pow(v, 2.5));
  EXPECT_NEAR(fitted_exponent(x, y), 2.5, 1e-12);
}

}  // namespace
}  // namespace sandglass::host

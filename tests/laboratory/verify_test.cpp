// The cases of `verify granular` that take moments, each with its negative control. Also tested are the apparatus that
// they use and the curves that show them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <string>

#include "models/drawing/plot.h"
#include "models/simulation/metrics.h"
#include "tests/laboratory/sand/apparatus.h"
#include "tests/laboratory/sand/flow_cases.h"
#include "tests/laboratory/sand/granular_plots.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {
namespace {

// The table is asserted as `verify granular` prints it: every claim holds, and every control fails as it must. Left out
// is what takes long (`far` and the flows).
struct QuickGroup {
  const char* name;
  size_t least_rows;
};
void PrintTo(const QuickGroup& group, std::ostream* out) { *out << group.name; }

class QuickVerdicts : public testing::TestWithParam<QuickGroup> {};

TEST_P(QuickVerdicts, EveryRowHolds) {
  VerdictChoice choice;
  choice.groups = {GetParam().name};
  const VerdictTable table = granular_verdicts(choice, [](uint64_t, uint64_t) { return true; });
  EXPECT_GE(table.rows.size(), GetParam().least_rows);
  for (const Verdict& row : table.rows)
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

TEST(Plot, TicksAreRoundAndInside) {
  EXPECT_EQ(plot_ticks({"", 0.0, 70.0, false}), (std::vector<double>{0, 10, 20, 30, 40, 50, 60, 70}));
  EXPECT_FALSE(std::signbit(plot_ticks({"", 0.0, 9.0, false})[0])) << "labelled 0, not -0";
  EXPECT_EQ(plot_ticks({"", 0.4, 5.0, true}), (std::vector<double>{0.5, 1, 2, 3, 5}));
  EXPECT_EQ(plot_ticks({"", 1.0, 1000.0, true}), (std::vector<double>{1, 10, 100, 1000}));
}

// The mean place of the pixels of exactly this colour.
struct Spot {
  double x = 0.0, y = 0.0;
  int count = 0;
};
Spot spot(const Picture& picture, Colour colour) {
  Spot s;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const uint8_t* p = picture.at(x, y);
      if (p[0] != colour.r || p[1] != colour.g || p[2] != colour.b) continue;
      s.x += x;
      s.y += y;
      ++s.count;
    }
  if (s.count > 0) s.x /= s.count, s.y /= s.count;
  return s;
}

TEST(Plot, MarksLieWhereTheirNumbersAre) {
  const auto one = [](double x, double y, bool logarithmic) {
    Plot plot;
    plot.x = {"x", 1.0, 100.0, logarithmic};
    plot.y = {"y", 1.0, 100.0, logarithmic};
    PlotSeries series;
    series.x = {x};
    series.y = {y};
    series.colour = {255, 0, 0};
    plot.series = {series};
    return spot(draw_plot(plot), {255, 0, 0});
  };
  const Spot low = one(1.0, 1.0, false), high = one(100.0, 100.0, false), middle = one(50.5, 50.5, false);
  EXPECT_NEAR(middle.x, (low.x + high.x) / 2.0, 3.0) << "half of the end marks is clipped";
  EXPECT_NEAR(middle.y, (low.y + high.y) / 2.0, 3.0);
  EXPECT_LT(high.y, low.y) << "up is up";
  const Spot decade = one(10.0, 10.0, true);
  EXPECT_NEAR(decade.x, middle.x, 1.0) << "the middle of two decades";
  EXPECT_EQ(one(1000.0, 10.0, true).count, 0) << "beyond the frame nothing is drawn";
  EXPECT_EQ(one(std::numeric_limits<double>::quiet_NaN(), 10.0, false).count, 0);
}

TEST(Plot, OnlyCurvesWithPointsAreDrawn) {
  EXPECT_TRUE(granular_plots({}).empty());
  GranularCurves curves;
  curves.aspects = {1.0, 2.0};
  curves.runouts = {1.4, 2.3};
  const std::vector<GranularPlot> plots = granular_plots(curves);
  ASSERT_EQ(plots.size(), 1u);
  EXPECT_EQ(plots[0].name, "runout");
}

}  // namespace
}  // namespace sandglass::host

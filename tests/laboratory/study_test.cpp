// A study of shots: what it concludes from its rows (made up here), and what it remembers of an earlier run. It must
// read its files before it begins.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "models/rooms/panorama_file.h"
#include "tests/laboratory/shot/shot_study.h"
#include "tests/laboratory/shot/verify_shot.h"
#include "tests/refusal.h"
#include "tests/temporary_folder.h"

namespace {

using namespace sandglass::host;

namespace fs = std::filesystem;

// The two-sided values for 95 %, as published tables print them.
TEST(Student, IsThePublishedTable) {
  const std::pair<int, double> table[] = {{1, 12.706}, {2, 4.303},  {3, 3.182},  {4, 2.776},  {9, 2.262},
                                          {10, 2.228}, {19, 2.093}, {26, 2.056}, {30, 2.042}, {120, 1.980}};
  for (const auto& [freedom, quantile] : table) EXPECT_NEAR(student_95(freedom), quantile, 5e-4) << freedom;
  EXPECT_NEAR(student_95(100000), 1.95996, 1e-4) << "the normal distribution";
  EXPECT_TRUE(std::isinf(student_95(0)));
}

using V = ShotVariant;

double& error_of(ShotView* view, V variant, int metric) { return view->errors[static_cast<int>(variant)][metric]; }

// A study with known paired differences: the full turn's RMSE is 0, and that without shadows is given. Each view is a
// place of its own.
ShotStudy study_of(const std::vector<double>& differences) {
  ShotStudy study;
  for (const double d : differences) {
    ShotView view;
    view.done = true, view.place = "place " + std::to_string(study.views.size());
    error_of(&view, V::no_shadow, 0) = d;
    study.views.push_back(view);
  }
  take_means(&study);
  return study;
}

// The standard error of the mean of 1, 2, 3 is 1/sqrt(3). That of 20 values which alternate 0 and 2 is sqrt(20/19/20).
TEST(ShotStudy, AnIntervalKnowsHowManyPlacesThereAre) {
  const auto paired = [](const std::vector<double>& d) { return study_of(d).against(V::no_shadow, V::turn, 0); };
  EXPECT_NEAR(paired({1, 2, 3}).mean, 2.0, 1e-12);
  EXPECT_NEAR(paired({1, 2, 3}).half, 4.303 / std::sqrt(3.0), 1e-3);
  std::vector<double> twenty;
  for (int i = 0; i < 20; ++i) twenty.push_back(i % 2 == 0 ? 0 : 2);
  EXPECT_NEAR(paired(twenty).half, 2.093 / std::sqrt(19.0), 1e-3);
  EXPECT_TRUE(std::isinf(paired({1}).half)) << "one place gives no interval";
}

TEST(ShotStudy, MeansAndIntervalsAreOfThePlacesThatAreDone) {
  ShotStudy study = study_of({1, 2, 3});
  ShotView never;
  error_of(&never, V::no_shadow, 0) = 1000;
  study.views.push_back(never);
  take_means(&study);
  EXPECT_NEAR(study.mean[static_cast<int>(V::no_shadow)][0], 2.0, 1e-12);
  EXPECT_NEAR(study.against(V::no_shadow, V::turn, 0).half, 4.303 / std::sqrt(3.0), 1e-3);
}

// Two views of one place are one place.
TEST(ShotStudy, TwoViewsOfAPlaceCountOnce) {
  ShotStudy study = study_of({1, 2, 3, 5});
  study.views[3].place = study.views[2].place;
  take_means(&study);
  EXPECT_EQ(study.by_place(V::no_shadow, 0).size(), 3u);
  EXPECT_NEAR(study.mean[static_cast<int>(V::no_shadow)][0], (1 + 2 + 4) / 3.0, 1e-12);
}

size_t failed_rows(const std::vector<Verdict>& rows) {
  size_t failed = 0;
  for (const Verdict& row : rows) failed += row.pass ? 0 : 1;
  return failed;
}

// A study in which all holds. Each fault makes one row fail.
TEST(ShotStudy, AVerdictNeedsWhatItClaims) {
  ShotStudy good = study_of({0, 0, 0, 0});
  for (ShotView& view : good.views)
    for (int m = 0; m < k_shot_metrics; ++m) {
      const double x = 0.01 * static_cast<double>(&view - good.views.data());
      for (int v = 0; v < k_shot_variants; ++v) view.errors[v][m] = 0.5 + x;
      for (const V v : {V::turn, V::truth}) error_of(&view, v, m) = 0.2 + 0.5 * x;
      error_of(&view, V::ambient_level, m) = 0.4 + x;
    }
  take_means(&good);
  EXPECT_EQ(failed_rows(shot_verdicts(good)), 0u);
  const auto failed = [&](const char* what, auto change) {
    ShotStudy bad = good;
    for (ShotView& view : bad.views) change(&view, static_cast<double>(&view - bad.views.data()));
    take_means(&bad);
    EXPECT_EQ(failed_rows(shot_verdicts(bad)), 1u) << what;
  };
  failed("FLIP better on the mean, but not surely", [](ShotView* v, double i) {
    error_of(v, V::turn, 6) = 0.1 + 0.3 * i;
    for (const V control : {V::mirrored, V::other_room}) error_of(v, control, 6) = 2.0;
  });
  failed("1 - SSIM the same", [](ShotView* v, double) { error_of(v, V::turn, 5) = error_of(v, V::no_shadow, 5); });
  failed("RMSE the same", [](ShotView* v, double) { error_of(v, V::turn, 0) = error_of(v, V::no_shadow, 0); });
  failed("the ambient shadow worth nothing",
         [](ShotView* v, double) { error_of(v, V::ambient_level, 5) = error_of(v, V::no_shadow_level, 5); });
  failed("a mirrored room as good", [](ShotView* v, double) { error_of(v, V::mirrored, 6) = error_of(v, V::turn, 6); });
  failed("another room as good", [](ShotView* v, double) { error_of(v, V::other_room, 6) = error_of(v, V::turn, 6); });
}

TEST(ShotStudy, TheTableHasARowForEachVariantThatWasDrawn) {
  ShotStudy study = study_of({0.2, 0.3});
  std::string text = shot_study_text(study);
  EXPECT_NE(text.find("| mean of 2 places |"), std::string::npos) << text;
  EXPECT_NE(text.find("| no shadow, mean light | 0.2500 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| a full turn - no shadow, mean light | -0.2500 ± 0.6353 |"), std::string::npos)
      << "12.706 * 0.05";
  EXPECT_EQ(text.find(name_of(V::one_light)), std::string::npos) << "there was no network";
  for (ShotView& view : study.views) view.has_network = true;
  take_means(&study);
  EXPECT_NE(shot_study_text(study).find(name_of(V::one_light)), std::string::npos);
}

ShotView row(const std::string& name, uint64_t hash, double azimuth) {
  ShotView view;
  view.panorama = name, view.panorama_hash = hash, view.azimuth_deg = azimuth, view.done = true;
  view.has_network = true, view.angle_deg = 1.0 / 3.0, view.log_level = -2.0 / 3.0;
  for (int v = 0; v < k_shot_variants; ++v)
    for (int m = 0; m < k_shot_metrics; ++m) view.errors[v][m] = 1.0 / (1 + v * k_shot_metrics + m);
  return view;
}

TEST(ShotStudyMemory, ALineComesBackAsItWas) {
  const ShotView view = row("a hall with spaces", 0xFEDCBA9876543210u, 360.0 / 7.0);
  ShotView back;
  ASSERT_TRUE(read_line(line_of(view).substr(0, line_of(view).size() - 1), &back));
  EXPECT_EQ(back.panorama, view.panorama);
  EXPECT_EQ(line_of(back), line_of(view));
  EXPECT_TRUE(std::equal(&view.errors[0][0], &view.errors[0][0] + k_shot_variants * k_shot_metrics, &back.errors[0][0]))
      << "the numbers must be equal to the last bit";
  const std::string line = line_of(view);
  for (const size_t length : {size_t{0}, size_t{5}, line.find(view.panorama) - 2})
    EXPECT_FALSE(read_line(line.substr(0, length), &back)) << length;
}

TEST(ShotStudyMemory, OnlyTheSameBytesSeenTheSameWayAreRemembered) {
  const std::string text = "key\n" + line_of(row("hall", 7, 30));
  const auto remembered = [&](const std::string& key, uint64_t hash, double azimuth) {
    std::vector<ShotView> views(1);
    views[0].panorama = "hall", views[0].panorama_hash = hash, views[0].azimuth_deg = azimuth;
    remember(text, key, &views);
    return views[0].done;
  };
  EXPECT_TRUE(remembered("key", 7, 30));
  EXPECT_FALSE(remembered("key", 8, 30)) << "another panorama of that name must be measured anew";
  EXPECT_FALSE(remembered("key", 7, 40)) << "with a longer list this panorama is seen from another place";
  EXPECT_FALSE(remembered("another network", 7, 30));
  std::vector<ShotView> views(1);
  remember("", "key", &views);
  remember("key\nnonsense\n", "key", &views);
  EXPECT_FALSE(views[0].done);
}

// A shadow that is good enough holds. Each fault makes it fail.
TEST(PileShadowStudy, HoldsOnlyIfEveryPartDoes) {
  PileShadowError good = {45, 0, {}, {}, {}};
  good.clear = good.among_grains = {0.1, 0.31, 0.04, 0.12, 0.3, 100};
  good.on_sand = {0.3, 0.41, 0.2, 0.31, 0.32, 100};
  EXPECT_TRUE(holds(good));
  const auto fails = [&](const char* what, auto change) {
    PileShadowError bad = good;
    change(bad);
    EXPECT_FALSE(holds(bad)) << what;
  };
  fails("more than a third of what leaving it out costs", [](auto& e) { e.clear.without = 0.29; });
  fails("the same among grains", [](auto& e) { e.among_grains.without = 0.29; });
  fails("less than a quarter gained on the sand", [](auto& e) { e.on_sand.without = 0.39; });
  fails("no better than the particles'", [](auto& e) { e.clear.particles = 0.1; });
  fails("the same among grains", [](auto& e) { e.among_grains.particles = 0.1; });
  fails("no better than of the light from the other side", [](auto& e) { e.on_sand.mirrored = 0.3; });
  fails("too light", [](auto& e) { e.clear.bias = 0.051; });
  fails("too dark", [](auto& e) { e.among_grains.bias = -0.051; });
  fails("nothing was measured", [](auto& e) { e.on_sand.texels = 0; });
  fails("not a number", [](auto& e) { e.clear.rmse = std::numeric_limits<double>::quiet_NaN(); });
}

// The shadow of the shot's pile against rays at the grains that are drawn: the numbers that the documentation gives.
TEST(PileShadowStudy, HoldsAndItsControlsDoNot) {
#ifndef SANDGLASS_HAVE_EMBREE
  GTEST_SKIP() << "needs Embree";
#endif
  const std::vector<PileShadowError> lights = study_pile_shadow();
  ASSERT_EQ(lights.size(), 9u);
  const PileShadowError whole = whole_of(lights);
  EXPECT_TRUE(holds(whole)) << pile_shadow_text(lights);
  // With the light from the other side, the error falls by far less than two thirds.
  PileShadowError mirrored = whole;
  for (PileShadowError::Part* part : {&mirrored.clear, &mirrored.among_grains, &mirrored.on_sand})
    part->rmse = part->mirrored, part->mirrored = 1.0, part->particles = 1.0;
  EXPECT_FALSE(holds(mirrored));
  EXPECT_GT(mirrored.clear.rmse, 0.5 * mirrored.clear.without);
}

// 100 texels with an error of 0.3 and 300 with 0.1 give the root of (9 + 3) / 400.
TEST(PileShadowStudy, TheWholeIsTheRootMeanSquareOverTexels) {
  PileShadowError few = {20, 0, {}, {}, {}}, many = {65, 0, {}, {}, {}};
  few.clear = {0.3, 0.3, 0.04, 0.3, 0.3, 100}, many.clear = {0.1, 0.1, 0.0, 0.1, 0.1, 300};
  const PileShadowError whole = whole_of({few, many});
  for (const double rms : {whole.clear.rmse, whole.clear.without, whole.clear.particles, whole.clear.mirrored})
    EXPECT_NEAR(rms, std::sqrt(0.03), 1e-12);
  EXPECT_NEAR(whole.clear.bias, 0.01, 1e-12);
  EXPECT_EQ(whole.clear.texels, 400);
  EXPECT_EQ(whole.on_sand.texels, 0);
}

std::string refusal(const ShotStudyOptions& options) {
  return sandglass::tests::refusal_of([&] { study_shots(options, [](size_t) { return true; }); });
}

TEST(ShotStudy, FilesAreReadBeforeAnythingIsMeasured) {
  const sandglass::tests::TemporaryFolder folder;
  RadianceMap map(64, 32);
  std::fill(map.rgb.begin(), map.rgb.end(), 0.5f);
  write_hdr(folder / "whole.hdr", map), write_hdr(folder / "half.hdr", map);
  fs::resize_file(folder / "half.hdr", fs::file_size(folder / "half.hdr") / 2);
  ShotStudyOptions options;
  options.folder = folder / "out", options.picture = {16, 12, 1, 1, 1};
  fs::create_directories(options.folder);
  options.panoramas = {folder / "whole.hdr", folder / "half.hdr"};
  EXPECT_NE(refusal(options).find("half.hdr"), std::string::npos) << refusal(options);
  EXPECT_TRUE(fs::is_empty(options.folder)) << "the second panorama must be read before the first is measured";
  options.network = folder / "nope.light";
  EXPECT_NE(refusal(options).find("nope.light"), std::string::npos) << "the network must be read before both";
  options.panoramas.clear();
  EXPECT_NE(refusal(options).find("nope.light"), std::string::npos) << "the network must be read without panoramas too";
  options.network.clear();
  EXPECT_EQ(refusal(options), "");
}

}  // namespace

// Reports can be read back and say what the frames did.
#include "models/report/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "models/files/failure.h"
#include "models/files/measurement_json.h"
#include "models/report/report_page.h"

namespace sandglass::host {
namespace {

// 100 frames within a budget of 4 ms, each 0.04 ms longer than the one before, then one of 6 ms.
RunReport example() {
  RunReport run;
  run.scene = "example";
  run.isa = "scalar";
  run.clock = "real";
  for (uint64_t i = 1; i <= 101; ++i) {
    FrameRow row = {};
    row.report.frame = i;
    row.report.time.budget_ns = 4'000'000;
    row.report.time.elapsed_ns = i == 101 ? 6'000'000 : i * 40'000;
    row.report.time.last_unit_ns = 50'000;
    row.report.level = i > 50 ? 1 : 0;
    row.report.stages[SANDGLASS_STAGE_GRANULAR] = {10, 0, row.report.time.elapsed_ns / 2};
    row.report.time.debt = 0.001 * static_cast<double>(i);
    row.report.sand.particles = 7;
    row.begin_ns = i * 20'000'000;
    row.wall_ms = 5.0;
    row.cpu_ms = 4.0;
    run.frames.push_back(row);
    run.units.push_back({"granular.solve", row.begin_ns, row.begin_ns + 1000});
    run.units.push_back({"shadow.tile", row.begin_ns + 2000, row.begin_ns + 2500});
  }
  return run;
}

TEST(Report, SummaryCountsMissesAndPercentiles) {
  const Summary s = summarise(example().frames);
  EXPECT_EQ(s.misses, 1u);
  EXPECT_DOUBLE_EQ(s.worst_overrun_ms, 2.0);
  EXPECT_EQ(s.beyond_guarantee, 1u);  // 6 ms is more than 4 ms plus one work unit of 0.05 ms
  EXPECT_DOUBLE_EQ(s.elapsed.p50, 51 * 0.04);
  EXPECT_DOUBLE_EQ(s.elapsed.max, 6.0);
  EXPECT_DOUBLE_EQ(s.stages[SANDGLASS_STAGE_GRANULAR].max, 3.0);
  EXPECT_DOUBLE_EQ(s.time_debt, 0.101);
  EXPECT_EQ(s.level_frames, (std::vector<uint32_t>{50, 51}));
}

// A frame of 6 ms, in which the thread did not run for 1.5 or 2.5 ms.
TEST(Report, TellsALateFrameOfTheLibraryFromOneThatTheSystemTook) {
  std::vector<FrameRow> frames(2);
  for (size_t i = 0; i < 2; ++i) {
    frames[i].report.time.budget_ns = 4'000'000;
    frames[i].report.time.elapsed_ns = 6'000'000;
    frames[i].wall_ms = 6.1;
    frames[i].cpu_ms = i == 0 ? 4.6 : 3.6;
  }
  const Summary s = summarise(frames);
  EXPECT_EQ(s.misses, 2u);
  EXPECT_EQ(s.misses_of_system, 1u);
}

// Frame i of a run takes i ms. What too few frames tell has no column in the text, and is null in JSON.
TEST(Report, APercentileNeedsTenFramesBeyondIt) {
  const struct {
    uint64_t frames;
    std::vector<std::string> given;
  } cases[] = {{11, {}},
               {199, {}},
               {200, {"p95"}},
               {999, {"p95"}},
               {1000, {"p95", "p99"}},
               {9999, {"p95", "p99"}},
               {10000, {"p95", "p99", "p99.9"}}};
  const std::map<std::string, double> shares = {{"p95", 0.95}, {"p99", 0.99}, {"p99.9", 0.999}};
  for (const auto& [frames, given] : cases) {
    SCOPED_TRACE(frames);
    RunReport run;
    for (uint64_t i = 1; i <= frames; ++i) {
      run.frames.emplace_back();
      run.frames.back().report.time.elapsed_ns = i * 1'000'000;
    }
    const nlohmann::json times = nlohmann::json::parse(report_summary_json(run)).at("elapsed_ms");
    const std::string text = report_summary_text(run);
    const size_t at = text.find("  milliseconds a frame");
    const std::string head = text.substr(at, text.find('\n', at) - at) + " ";
    for (const auto& [name, share] : shares) {
      SCOPED_TRACE(name);
      const bool known = std::count(given.begin(), given.end(), name) == 1;
      if (known) EXPECT_DOUBLE_EQ(times.at(name), std::ceil(share * static_cast<double>(frames) - 1e-6));
      else EXPECT_TRUE(times.at(name).is_null()) << times;
      EXPECT_EQ(head.find(" " + name + " ") != std::string::npos, known) << head;
    }
    EXPECT_DOUBLE_EQ(times.at("max"), static_cast<double>(frames));
  }
}

TEST(Report, CsvHasOneRowAFrameAndAsManyFieldsAsItsHeader) {
  std::istringstream csv(report_csv(example()));
  std::string header, line;
  std::getline(csv, header);
  size_t rows = 0;
  for (; std::getline(csv, line); ++rows) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(header.begin(), header.end(), ','));
    EXPECT_EQ(std::strtoull(line.c_str(), nullptr, 10), rows + 1);
  }
  EXPECT_EQ(rows, 101u);
  EXPECT_EQ(header.substr(0, 40), "frame,level,budget_ms,elapsed_ms,mandato");
  EXPECT_NE(line, header);
}

TEST(Report, TraceIsChromeTraceJsonWithOneTrackAStage) {
  const nlohmann::json trace = nlohmann::json::parse(report_trace(example()));
  std::map<std::string, int> tracks;
  size_t complete = 0, counters = 0;
  for (const nlohmann::json& event : trace.at("traceEvents")) {
    const std::string phase = event.at("ph");
    if (phase == "M" && event.at("name") == "thread_name") tracks[event.at("args").at("name")] = event.at("tid");
    complete += phase == "X";
    counters += phase == "C";
    if (phase != "X") continue;
    EXPECT_GT(event.at("dur").get<double>(), 0.0);
    EXPECT_EQ(event.at("tid") == 2 + SANDGLASS_STAGE_SHADOW, event.at("name") == "shadow.tile");
  }
  std::map<std::string, int> expected = {{"frame", 1}};
  for (int stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    expected[sandglass_stage_name(static_cast<uint32_t>(stage))] = 2 + stage;
  EXPECT_EQ(tracks, expected);
  EXPECT_EQ(complete, 3u * 101u);
  EXPECT_EQ(counters, 3u * 101u);
}

TEST(Report, TheRecorderPairsNestedUnits) {
  TraceRecorder recorder;
  const sandglass_trace hook = recorder.hook();
  hook.end(hook.user, "stray");
  hook.begin(hook.user, "outer");
  hook.begin(hook.user, "inner");
  hook.end(hook.user, "inner");
  hook.end(hook.user, "outer");
  ASSERT_EQ(recorder.events.size(), 2u);
  EXPECT_STREQ(recorder.events[0].name, "inner");
  EXPECT_LE(recorder.events[1].begin_ns, recorder.events[0].begin_ns);
  EXPECT_GE(recorder.events[1].end_ns, recorder.events[0].end_ns);
}

TEST(ReportPage, TextStaysTextAndWhatIsNoPictureIsRefused) {
  RunReport run = example();
  run.scene = "</script><b>&@CSV@";
  const std::string page = report_page(run, {}, {{"@CSV@", "1 < 2"}});
  EXPECT_NE(page.find("<title>&lt;/script&gt;&lt;b&gt;&amp;@CSV@"), std::string::npos);
  EXPECT_EQ(page.find("</script><b>"), std::string::npos);
  EXPECT_NE(page.find("<td>@CSV@</td><td>1 &lt; 2</td>"), std::string::npos);
  EXPECT_NE(page.find("id=\"data\">" + report_csv(run) + "</script>"), std::string::npos);
  EXPECT_THROW(report_page(run, {{"a text", "", {'t', 'e', 'x', 't'}, {}, "", ""}}, {}), Failure);
}

TEST(Measurements, AreFlatObjectsAsScriptsExpectThem) {
  Measurement time, claim, unknown;
  time.suite = "granular";
  time.scene = "column14k/default";
  time.metric = "ms_per_frame";
  time.unit = "ms";
  time.isa = "avx2";
  time.value = 24.5;
  time.threads = 2;
  claim = time;
  claim.judgement = Measurement::Judgement{1.0, 0.5, true, true};
  unknown.value = std::nan("");
  const nlohmann::json list = nlohmann::json::parse(measurements_json({time, claim, unknown}));
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0], (nlohmann::json{{"suite", "granular"},
                                     {"case", "column14k/default"},
                                     {"metric", "ms_per_frame"},
                                     {"value", 24.5},
                                     {"unit", "ms"},
                                     {"isa", "avx2"},
                                     {"threads", 2}}));
  EXPECT_EQ(list[1]["control"], true);
  EXPECT_EQ(list[1]["limit"], 0.5);
  EXPECT_TRUE(list[2]["value"].is_null());
}

}  // namespace
}  // namespace sandglass::host

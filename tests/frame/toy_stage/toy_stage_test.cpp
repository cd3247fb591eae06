// The toy stage's own test: what an app and its developer see of a new stage. toy_stage.py puts it into the copy.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

#include "models/report/report.h"
#include "models/simulation/recording.h"
#include "sandglass/sandglass.hpp"

namespace {

// Frames of a scene with a toy, as a report.
sandglass::host::RunReport run(sandglass::Toy* toy, sandglass::host::Recording* recording) {
  sandglass::host::TraceRecorder recorder;
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.trace = recorder.hook();
  sandglass::Scene scene;
  EXPECT_TRUE(scene.create(desc));
  EXPECT_TRUE(toy->create());
  sandglass_frame_input input = sandglass::frame_input(0.016f, 4'000'000);
  input.toy = toy->get();
  sandglass::host::RunReport run;
  for (int i = 0; i < 3; ++i) {
    sandglass::host::FrameRow row = {sandglass::frame_report()};
    EXPECT_TRUE(scene.frame(input, &row.report));
    run.frames.push_back(row);
    recording->frames.push_back({input.time_step, input.budget_ns, {}, row.report.plan});
  }
  run.units = recorder.events;
  return run;
}

bool names_toy(const std::string& text) { return text.find("toy") != std::string::npos; }

TEST(ToyStage, IsRunReportedTracedAndRecorded) {
  sandglass::Toy toy;
  sandglass::host::Recording recording, read;
  const sandglass::host::RunReport report = run(&toy, &recording);
  EXPECT_EQ(toy.count(), 12u);
  EXPECT_EQ(report.frames[0].report.stages[SANDGLASS_STAGE_TOY].units, 4u);
  EXPECT_TRUE(names_toy(report_csv(report))) << report_csv(report);
  EXPECT_TRUE(names_toy(report_summary_json(report))) << report_summary_json(report);
  EXPECT_TRUE(names_toy(report_summary_text(report))) << report_summary_text(report);
  EXPECT_TRUE(names_toy(report_trace(report))) << report_trace(report);
  const std::vector<uint8_t> bytes = encode_recording(recording);
  EXPECT_TRUE(names_toy({bytes.begin(), bytes.end()}));
  std::string error;
  ASSERT_TRUE(sandglass::host::decode_recording(bytes.data(), bytes.size(), &read, &error)) << error;
  ASSERT_EQ(read.frames.size(), 3u);
  EXPECT_EQ(std::memcmp(&read.frames[0].plan, &recording.frames[0].plan, sizeof(sandglass_plan)), 0);
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    std::printf("stage %s\n", sandglass_stage_name(stage));
}

}  // namespace

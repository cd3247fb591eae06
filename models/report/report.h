// The report of a run: budget against actual, frame by frame and in percentiles; CSV for spreadsheets, Chrome trace
// events for Perfetto, a summary as JSON and as text.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sandglass/sandglass.h"

namespace sandglass::host {

// What a frame was lit by, in the world's frame. What is not known leaves its cells of the CSV empty.
struct FrameLight {
  bool known = false;                        // the direction
  double towards[3] = {};                    // unit vector towards the light
  bool coloured = false;                     // and the rest:
  double light[3] = {}, ambient[3] = {};     // linear; `light` with its strength (light.h)
  double contrast = 0.0, confidence = -1.0;  // confidence below 0: nobody said
};

struct FrameRow {
  sandglass_frame_report report;
  uint64_t begin_ns = 0;  // wall time since the run began
  double wall_ms = 0.0;
  double cpu_ms = 0.0;  // of the thread that called the frame
  FrameLight light;
};

struct UnitEvent {
  const char* name;
  uint64_t begin_ns, end_ns;
};

// Collects the library's trace hook; the names are static strings. Times are wall time since the recorder was made.
class TraceRecorder {
 public:
  TraceRecorder();
  sandglass_trace hook();
  uint64_t now_ns() const;
  std::vector<UnitEvent> events;

 private:
  static void begin(void* user, const char* name);
  static void end(void* user, const char* name);
  uint64_t origin_ns_;
  std::vector<uint64_t> open_;
};

struct RunReport {
  std::string scene, isa, clock;  // clock: "real", "virtual", "replay"
  std::string light;              // whose light the frames have: "estimate"; empty: nobody's
  uint32_t threads = 1;
  uint64_t memory_bytes = 0;
  bool interrupted = false;
  std::vector<FrameRow> frames;
  std::vector<UnitEvent> units;
};

// Over the frames of a run, in milliseconds. A miss is a frame whose time by the scene's clock exceeds its budget.
struct Distribution {
  double mean = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};
Distribution distribution(std::vector<double> values);

struct Summary {
  Distribution elapsed, wall, cpu, stages[SANDGLASS_STAGE_COUNT];
  double budget_ms = 0.0;
  uint32_t misses = 0;
  double worst_overrun_ms = 0.0;  // elapsed - budget, 0 without a miss
  uint32_t beyond_guarantee = 0;  // frames with elapsed > max(budget, mandatory) + last unit
  double time_debt = 0.0;         // seconds, at the end
  double simulated_time = 0.0;    // seconds
  uint32_t level_worst = 0;
  std::vector<uint32_t> level_frames;  // frames at each level
  uint64_t dropped_contacts = 0, quarantined = 0, ignored_colliders = 0;
  uint32_t clock_faults = 0;
};
Summary summarise(const std::vector<FrameRow>& frames);

const char* stage_name(sandglass_stage stage);  // "granular", "lighting", "shadow", "refine", "output"

// One row a frame. Times in milliseconds end with _ms, in simulated seconds with _s; counts have no unit. light_x, _y
// and _z point towards the light in the world; light_r, _g, _b, ambient_r, _g, _b, contrast and confidence are as in
// light.h, the light's colour with its strength. A light that nothing is known of leaves its cells empty.
std::string report_csv(const RunReport& report);
std::string report_trace(const RunReport& report);
std::string report_summary_json(const RunReport& report);
std::string report_summary_text(const RunReport& report);

}  // namespace sandglass::host

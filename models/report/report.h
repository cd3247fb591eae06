// The report of a run: the budget and the time used, frame by frame and in percentiles. It is written as CSV for
// spreadsheets, as Chrome trace events for Perfetto, and as a summary in JSON and in text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sandglass/estimator.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct FrameRow {
  sandglass_frame_report report;
  uint64_t begin_ns = 0;  // wall time since the run began
  double wall_ms = 0.0;
  double cpu_ms = 0.0;  // of the thread that ran the frame
};

struct UnitEvent {
  const char* name;
  uint64_t begin_ns, end_ns;
};

// Collects the events of the library's trace hook. The names are static strings. Times are wall time since the recorder
// was made.
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

// Of a run on the clock of a phone's core: its times are estimates at the middle of the core's range of instructions a
// cycle. `low` and `high` lead from there to the ends of the range.
struct PhoneEstimate {
  std::string core;  // empty: none
  double ghz = 0.0, ipc_low = 0.0, ipc_high = 0.0;
  double low = 1.0, high = 1.0;
  std::string why;
};

struct RunReport {
  std::string scene, isa, clock;  // clock: "real", "virtual", "replay", "estimated"
  std::string light;              // where the frames' light comes from: "estimate"; empty: no light
  uint32_t threads = 1;
  uint64_t memory_bytes = 0;
  bool interrupted = false;
  PhoneEstimate estimate;
  std::vector<FrameRow> frames;
  std::vector<UnitEvent> units;
};

// Times over the frames of a run, in milliseconds. There is no upper quantile that too few frames tell
// (tells_quantile).
struct Distribution {
  double mean = 0.0, p50 = 0.0;
  std::optional<double> p95, p99, p999;
  double max = 0.0;
};
Distribution distribution(std::vector<double> values);

struct Summary {
  Distribution elapsed, wall, cpu, stages[SANDGLASS_STAGE_COUNT];
  double budget_ms = 0.0;
  uint32_t misses = 0;  // frames whose time by the scene's clock is above their budget
  // Of these, which are in time but for what the system took: wall less CPU time. With a pool, waiting for it counts too.
  uint32_t misses_of_system = 0;
  double worst_overrun_ms = 0.0;       // elapsed - budget; 0 without a miss
  uint32_t beyond_guarantee = 0;       // frames with elapsed > max(budget, mandatory) + last work unit
  double time_debt = 0.0;              // seconds, at the end
  double simulated_time = 0.0;         // seconds
  std::vector<uint32_t> level_frames;  // frames at each quality level
  uint64_t dropped_contacts = 0, quarantined = 0, ignored = 0;  // the last: colliders, emitters, sinks
  uint32_t clock_faults = 0;
};
Summary summarise(const std::vector<FrameRow>& frames);

std::string level_text(uint32_t level);  // its number and name

// One row per frame. Names of times in milliseconds end with _ms, of times in simulated seconds with _s. speed_max is
// in m/s. Counts have no unit.
std::string report_csv(const RunReport& report);
std::string report_trace(const RunReport& report);
// Upper quantiles that too few frames tell are null in JSON, and have no column in the text.
std::string report_summary_json(const RunReport& report);
std::string report_summary_text(const RunReport& report);
std::string estimate_text(const PhoneEstimate& estimate);  // what it is and is not, in one sentence

// The light of a photograph. Both directions point towards the light. In the camera's axes x is right, y down and z
// forward. In the world's axes, for a level camera that looks along -z, x is right and y is up.
std::string light_estimate_json(const std::string& image, double fov_deg, const sandglass_estimator_light& in_camera,
                                const sandglass_estimator_light& in_world);

}  // namespace sandglass::host

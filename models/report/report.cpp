// Numbers are written by snprintf, not by streams, so that a stream's locale does not change the text.
#include "models/report/report.h"

#include <algorithm>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <map>

#include "models/simulation/metrics.h"

namespace sandglass::host {

namespace {

constexpr size_t k_event_limit = 4'000'000;  // work units kept; no viewer opens a longer trace

uint64_t steady_ns() {
  return static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
          .count());
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void add(std::string* text, const char* format, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text->append(line, static_cast<size_t>(std::clamp(length, 0, static_cast<int>(sizeof line) - 1)));
}

double ms(uint64_t ns) { return static_cast<double>(ns) * 1e-6; }

}  // namespace

TraceRecorder::TraceRecorder() : origin_ns_(steady_ns()) {}
uint64_t TraceRecorder::now_ns() const { return steady_ns() - origin_ns_; }
sandglass_trace TraceRecorder::hook() { return {begin, end, this}; }

void TraceRecorder::begin(void* user, const char*) {
  TraceRecorder* recorder = static_cast<TraceRecorder*>(user);
  recorder->open_.push_back(recorder->now_ns());
}

void TraceRecorder::end(void* user, const char* name) {
  TraceRecorder* recorder = static_cast<TraceRecorder*>(user);
  if (recorder->open_.empty()) return;
  if (recorder->events.size() < k_event_limit)
    recorder->events.push_back({name, recorder->open_.back(), recorder->now_ns()});
  recorder->open_.pop_back();
}

std::string level_text(uint32_t level) {
  const char* name = sandglass_level_name(level);
  return std::to_string(level) + " (" + (name != nullptr ? name : "unnamed") + ")";
}

Distribution distribution(std::vector<double> values) {
  Distribution d;
  if (values.empty()) return d;
  for (const double value : values) d.mean += value;
  d.mean /= static_cast<double>(values.size());
  d.p50 = quantile(values, 0.50);
  const auto upper = [&](double q) {
    return tells_quantile(values.size(), q) ? std::optional(quantile(values, q)) : std::nullopt;
  };
  d.p95 = upper(0.95);
  d.p99 = upper(0.99);
  d.p999 = upper(0.999);
  d.max = quantile(values, 1.0);
  return d;
}

Summary summarise(const std::vector<FrameRow>& frames) {
  Summary summary;
  std::vector<double> elapsed, wall, cpu, stages[SANDGLASS_STAGE_COUNT];
  for (const FrameRow& row : frames) {
    const sandglass_frame_report& r = row.report;
    elapsed.push_back(ms(r.time.elapsed_ns));
    wall.push_back(row.wall_ms);
    cpu.push_back(row.cpu_ms);
    for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
      stages[stage].push_back(ms(r.stages[stage].elapsed_ns));
    if (r.time.elapsed_ns > r.time.budget_ns) {
      ++summary.misses;
      const double taken_ms = std::max(row.wall_ms - row.cpu_ms, 0.0);
      summary.misses_of_system += ms(r.time.elapsed_ns) - taken_ms <= ms(r.time.budget_ns);
      summary.worst_overrun_ms = std::max(summary.worst_overrun_ms, ms(r.time.elapsed_ns - r.time.budget_ns));
    }
    const uint64_t promised = std::max(r.time.budget_ns, r.time.mandatory_ns);
    if (r.time.elapsed_ns > promised && r.time.elapsed_ns - promised > r.time.last_unit_ns) ++summary.beyond_guarantee;
    if (r.level >= summary.level_frames.size()) summary.level_frames.resize(r.level + 1, 0);
    ++summary.level_frames[r.level];
    summary.dropped_contacts += r.sand.dropped_contacts;
    summary.quarantined += r.sand.quarantined;
    summary.ignored += r.sand.ignored_colliders + r.sand.ignored_emitters + r.sand.ignored_sinks;
    summary.clock_faults += r.time.clock_fault;
  }
  if (!frames.empty()) {
    summary.budget_ms = ms(frames.back().report.time.budget_ns);
    summary.time_debt = frames.back().report.time.debt;
    summary.simulated_time = frames.back().report.time.simulated;
  }
  summary.elapsed = distribution(std::move(elapsed));
  summary.wall = distribution(std::move(wall));
  summary.cpu = distribution(std::move(cpu));
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    summary.stages[stage] = distribution(std::move(stages[stage]));
  return summary;
}

std::string report_csv(const RunReport& report) {
  std::string text = "frame,level,budget_ms,elapsed_ms,mandatory_ms,last_unit_ms,longest_unit_ms,wall_ms,cpu_ms,";
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    for (const char* column : {"_ms,", "_units,", "_denied,"})
      text += std::string(sandglass_stage_name(stage)) + column;
  text +=
      "simulated_s,debt_s,grain_lag_s,substep_s,substeps,list_builds,particles,grains,dropped_contacts,quarantined,"
      "ignored_colliders,ignored_emitters,ignored_sinks,speed_max,clock_fault,shadows_pending,shadows_calls_behind,"
      "estimate_changed,estimate_units_left\n";
  for (const FrameRow& row : report.frames) {
    const sandglass_frame_report& r = row.report;
    add(&text, "%llu,%u,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f", static_cast<unsigned long long>(r.frame), r.level,
        ms(r.time.budget_ns), ms(r.time.elapsed_ns), ms(r.time.mandatory_ns), ms(r.time.last_unit_ns),
        ms(r.time.longest_unit_ns), row.wall_ms, row.cpu_ms);
    for (const sandglass_stage_report& stage : r.stages)
      add(&text, ",%.6f,%u,%u", ms(stage.elapsed_ns), stage.units, stage.denied);
    add(&text, ",%.6f,%.6f,%.6f,%.9f,%u,%u,%u,%u,%u,%u,%u,%u,%u,%.6g,%u,%u,%u,%u,%u\n", r.time.simulated, r.time.debt,
        static_cast<double>(r.sand.grain_lag), static_cast<double>(r.sand.substep), r.sand.substeps, r.sand.list_builds,
        r.sand.particles, r.sand.grains, r.sand.dropped_contacts, r.sand.quarantined, r.sand.ignored_colliders,
        r.sand.ignored_emitters, r.sand.ignored_sinks, static_cast<double>(r.sand.speed_max), r.time.clock_fault,
        r.shadows.pending, r.shadows.calls_behind, r.estimator.changed, r.estimator.units_left);
  }
  return text;
}

std::string report_trace(const RunReport& report) {
  // Track 1 holds the frames. Every stage has its own track: the part of a work unit's name before the dot is the
  // stage.
  std::map<std::string, int> tracks;
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    tracks.emplace(sandglass_stage_name(stage), stage + 2);
  const auto track_of = [&](const std::string& name) {
    const std::string stage = name.substr(0, name.find('.'));
    return tracks.emplace(stage, static_cast<int>(tracks.size()) + 2).first->second;
  };
  std::string text = "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n";
  std::string events;
  for (const UnitEvent& unit : report.units)
    add(&events, ",\n{\"ph\":\"X\",\"pid\":1,\"tid\":%d,\"name\":\"%s\",\"ts\":%.3f,\"dur\":%.3f}", track_of(unit.name),
        unit.name, static_cast<double>(unit.begin_ns) * 1e-3, static_cast<double>(unit.end_ns - unit.begin_ns) * 1e-3);
  for (const FrameRow& row : report.frames) {
    const sandglass_frame_report& r = row.report;
    const double at = static_cast<double>(row.begin_ns) * 1e-3;
    add(&events,
        ",\n{\"ph\":\"X\",\"pid\":1,\"tid\":1,\"name\":\"frame "
        "%llu\",\"ts\":%.3f,\"dur\":%.3f,\"args\":{\"level\":%u,\"substeps\":%u}}",
        static_cast<unsigned long long>(r.frame), at, row.wall_ms * 1e3, r.level, r.sand.substeps);
    add(&events,
        ",\n{\"ph\":\"C\",\"pid\":1,\"name\":\"time (ms)\",\"ts\":%.3f,\"args\":{\"budget\":%.6f,\"elapsed\":%.6f}}",
        at, ms(r.time.budget_ns), ms(r.time.elapsed_ns));
    add(&events, ",\n{\"ph\":\"C\",\"pid\":1,\"name\":\"debt (ms)\",\"ts\":%.3f,\"args\":{\"debt\":%.6f}}", at,
        r.time.debt * 1e3);
    add(&events, ",\n{\"ph\":\"C\",\"pid\":1,\"name\":\"level\",\"ts\":%.3f,\"args\":{\"level\":%u}}", at, r.level);
  }
  add(&text, "{\"ph\":\"M\",\"pid\":1,\"name\":\"process_name\",\"args\":{\"name\":\"sandglass\"}}");
  add(&text, ",\n{\"ph\":\"M\",\"pid\":1,\"tid\":1,\"name\":\"thread_name\",\"args\":{\"name\":\"frame\"}}");
  for (const auto& [name, track] : tracks)
    add(&text, ",\n{\"ph\":\"M\",\"pid\":1,\"tid\":%d,\"name\":\"thread_name\",\"args\":{\"name\":\"%s\"}}", track,
        name.c_str());
  return text + events + "\n]}\n";
}

namespace {

void add_head(std::string* text, const Distribution& d) {
  add(text, "  %-22s %9s %9s", "milliseconds a frame", "mean", "p50");
  for (const auto& [name, value] : {std::pair{"p95", d.p95}, std::pair{"p99", d.p99}, std::pair{"p99.9", d.p999}})
    if (value) add(text, " %9s", name);
  add(text, " %9s\n", "max");
}

void add_row(std::string* text, const char* name, const Distribution& d, double factor = 1.0) {
  add(text, "  %-22s %9.3f %9.3f", name, d.mean * factor, d.p50 * factor);
  for (const std::optional<double>& value : {d.p95, d.p99, d.p999})
    if (value) add(text, " %9.3f", *value * factor);
  add(text, " %9.3f\n", d.max * factor);
}

// Frames, sand, kernels, threads, clock and memory, in one line.
std::string headline(const RunReport& report) {
  const size_t count = report.frames.size();
  std::string text;
  add(&text, "%zu frames%s, %u particles, %u grains; %s kernels, %u thread%s, %s clock, %.1f MiB", count,
      report.interrupted ? " (interrupted)" : "", count == 0 ? 0 : report.frames.back().report.sand.particles,
      count == 0 ? 0 : report.frames.back().report.sand.grains, report.isa.c_str(), report.threads,
      report.threads == 1 ? "" : "s", report.clock.c_str(), static_cast<double>(report.memory_bytes) / 1048576.0);
  return text;
}

}  // namespace

std::string estimate_text(const PhoneEstimate& e) {
  std::string text;
  add(&text,
      "Estimated, not measured: counted NEON instructions on a %s at %.1f GHz (%s). The band is a stated range of %.1f "
      "to %.1f instructions a cycle; the frames are planned at its middle.",
      e.core.c_str(), e.ghz, e.why.c_str(), e.ipc_low, e.ipc_high);
  return text;
}

std::string report_summary_text(const RunReport& report) {
  const Summary s = summarise(report.frames);
  const size_t count = report.frames.size();
  std::string text;
  text += report.scene + ": " + headline(report) + "\n";
  add_head(&text, s.elapsed);
  const PhoneEstimate& e = report.estimate;
  add_row(&text, e.core.empty() ? "budget used" : "budget used, estimate", s.elapsed);
  if (!e.core.empty())
    for (const auto& [name, factor] : {std::pair{"  at its fastest", e.low}, std::pair{"  at its slowest", e.high}})
      add_row(&text, name, s.elapsed, factor);
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    add_row(&text, (std::string("  ") + sandglass_stage_name(stage)).c_str(), s.stages[stage]);
  add_row(&text, e.core.empty() ? "wall time" : "wall time, this machine", s.wall);
  add_row(&text, "CPU time, one thread", s.cpu);
  if (!e.core.empty()) text += "  " + estimate_text(e) + "\n";
  add(&text,
      "  budget %.3f ms: %u of %zu frames over it, %u by what the system took, worst by %.3f ms; %u beyond the "
      "guarantee\n",
      s.budget_ms, s.misses, count, s.misses_of_system, s.worst_overrun_ms, s.beyond_guarantee);
  add(&text, "  simulated %.3f s, debt %.4f s; quality", s.simulated_time, s.time_debt);
  for (uint32_t level = 0; level < s.level_frames.size(); ++level)
    if (s.level_frames[level] > 0) add(&text, " %s x %u", level_text(level).c_str(), s.level_frames[level]);
  add(&text, "\n");
  if (s.dropped_contacts + s.quarantined + s.ignored + s.clock_faults > 0)
    add(&text, "  dropped contacts %llu, quarantined %llu, left out %llu, clock faults %u\n",
        static_cast<unsigned long long>(s.dropped_contacts), static_cast<unsigned long long>(s.quarantined),
        static_cast<unsigned long long>(s.ignored), s.clock_faults);
  return text;
}

}  // namespace sandglass::host

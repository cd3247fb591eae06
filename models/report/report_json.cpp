// What a report writes as JSON.
#include "models/files/json.h"
#include "models/report/report.h"

namespace sandglass::host {

namespace {

Json json_of(const Distribution& d) {
  const auto upper = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"mean", d.mean},      {"p50", d.p50},           {"p95", upper(d.p95)},
          {"p99", upper(d.p99)}, {"p99.9", upper(d.p999)}, {"max", d.max}};
}

}  // namespace

std::string report_summary_json(const RunReport& report) {
  const Summary s = summarise(report.frames);
  Json file = {{"scene", report.scene}, {"isa", report.isa}, {"clock", report.clock}};
  if (const PhoneEstimate& e = report.estimate; !e.core.empty())
    file["estimate"] = {{"core", e.core},          {"ghz", e.ghz},
                        {"ipc_low", e.ipc_low},    {"ipc_high", e.ipc_high},
                        {"fastest_factor", e.low}, {"slowest_factor", e.high},
                        {"text", estimate_text(e)}};
  Json stages = Json::object(), levels = Json::object();
  for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    stages[sandglass_stage_name(stage)] = json_of(s.stages[stage]);
  for (uint32_t level = 0; level < s.level_frames.size(); ++level)
    if (s.level_frames[level] > 0) levels[level_text(level)] = s.level_frames[level];
  const Json more = {{"threads", report.threads},
                     {"light", report.light},
                     {"interrupted", report.interrupted},
                     {"frames", report.frames.size()},
                     {"particles", report.frames.empty() ? 0 : report.frames.back().report.sand.particles},
                     {"grains", report.frames.empty() ? 0 : report.frames.back().report.sand.grains},
                     {"memory_bytes", report.memory_bytes},
                     {"budget_ms", s.budget_ms},
                     {"elapsed_ms", json_of(s.elapsed)},
                     {"wall_ms", json_of(s.wall)},
                     {"cpu_ms", json_of(s.cpu)},
                     {"stages_ms", stages},
                     {"misses", s.misses},
                     {"misses_of_system", s.misses_of_system},
                     {"worst_overrun_ms", s.worst_overrun_ms},
                     {"beyond_guarantee", s.beyond_guarantee},
                     {"clock_faults", s.clock_faults},
                     {"simulated_time_s", s.simulated_time},
                     {"time_debt_s", s.time_debt},
                     {"frames_at_level", levels},
                     {"dropped_contacts", s.dropped_contacts},
                     {"quarantined", s.quarantined},
                     {"ignored", s.ignored}};
  file.update(more);
  return text_of(file);
}

std::string light_estimate_json(const std::string& image, double fov_deg, const sandglass_estimator_light& in_camera,
                                const sandglass_estimator_light& in_world) {
  return text_of({{"image", image},
                  {"field_of_view_deg", fov_deg},
                  {"direction_camera", in_camera.direction},
                  {"direction_world", in_world.direction},
                  {"light", in_camera.light},
                  {"ambient", in_camera.ambient},
                  {"contrast", in_camera.contrast},
                  {"strength", in_camera.strength},
                  {"sh", in_world.sh}});
}

}  // namespace sandglass::host

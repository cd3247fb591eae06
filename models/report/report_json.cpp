// What a report writes as JSON. Only this source of the report includes nlohmann's library, which is slow to compile.
#include <nlohmann/json.hpp>

#include "models/report/report.h"

namespace sandglass::host {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Distribution& d) {
  const auto upper = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"mean", d.mean},      {"p50", d.p50},           {"p95", upper(d.p95)},
          {"p99", upper(d.p99)}, {"p99.9", upper(d.p999)}, {"max", d.max}};
}

}  // namespace

std::string report_summary_json(const RunReport& report) {
  const Summary s = summarise(report.frames);
  Json file;
  file["scene"] = report.scene;
  file["isa"] = report.isa;
  file["clock"] = report.clock;
  if (const PhoneEstimate& e = report.estimate; !e.core.empty())
    file["estimate"] = {{"core", e.core},          {"ghz", e.ghz},
                        {"ipc_low", e.ipc_low},    {"ipc_high", e.ipc_high},
                        {"fastest_factor", e.low}, {"slowest_factor", e.high},
                        {"text", estimate_text(e)}};
  file["threads"] = report.threads;
  file["light"] = report.light;
  file["interrupted"] = report.interrupted;
  file["frames"] = report.frames.size();
  file["particles"] = report.frames.empty() ? 0 : report.frames.back().report.particles;
  file["grains"] = report.frames.empty() ? 0 : report.frames.back().report.grains;
  file["memory_bytes"] = report.memory_bytes;
  file["budget_ms"] = s.budget_ms;
  file["elapsed_ms"] = json_of(s.elapsed);
  file["wall_ms"] = json_of(s.wall);
  file["cpu_ms"] = json_of(s.cpu);
  for (int stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    file["stages_ms"][stage_name(stage)] = json_of(s.stages[stage]);
  file["misses"] = s.misses;
  file["worst_overrun_ms"] = s.worst_overrun_ms;
  file["beyond_guarantee"] = s.beyond_guarantee;
  file["clock_faults"] = s.clock_faults;
  file["simulated_time_s"] = s.simulated_time;
  file["time_debt_s"] = s.time_debt;
  for (uint32_t level = 0; level < s.level_frames.size(); ++level)
    if (s.level_frames[level] > 0) file["frames_at_level"][level_text(level)] = s.level_frames[level];
  file["dropped_contacts"] = s.dropped_contacts;
  file["quarantined"] = s.quarantined;
  file["ignored_colliders"] = s.ignored_colliders;
  return file.dump(2) + "\n";
}

std::string light_estimate_json(const std::string& image, double fov_deg, uint32_t turn_deg,
                                const sandglass_light_estimate& in_camera, const sandglass_light_estimate& in_world) {
  nlohmann::json json;  // sorts its keys
  json["image"] = image;
  json["field_of_view_deg"] = fov_deg, json["turn_deg"] = turn_deg;
  json["direction_camera"] = in_camera.direction, json["direction_world"] = in_world.direction;
  json["light"] = in_camera.light, json["ambient"] = in_camera.ambient;
  json["contrast"] = in_camera.contrast, json["strength"] = in_camera.strength;
  json["sh"] = in_world.sh;
  return json.dump(2) + "\n";
}

}  // namespace sandglass::host

// Everything that a report writes as JSON. Only this source of the report includes nlohmann's library, because it is
// slow to compile.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "models/report/report_page.h"

namespace sandglass::host {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Distribution& d) {
  const auto upper = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"mean", d.mean},      {"p50", d.p50},           {"p95", upper(d.p95)},
          {"p99", upper(d.p99)}, {"p99.9", upper(d.p999)}, {"max", d.max}};
}

Json summary_json(const RunReport& report) {
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
  return file;
}

// The numbers as they are in the CSV. Empty cells and what JSON cannot express (nan, inf) become null.
std::string rows_json(const std::string& csv) {
  std::string json = "[";
  for (size_t line = csv.find('\n') + 1; line < csv.size(); line = csv.find('\n', line) + 1) {
    json += json.size() == 1 ? "[" : ",\n[";
    const size_t end = csv.find('\n', line);
    for (size_t from = line, to; from <= end; from = to + 1) {
      to = std::min(csv.find(',', from), end);
      const std::string_view cell = std::string_view(csv).substr(from, to - from);
      const bool number = !cell.empty() && cell.find_first_not_of("0123456789+-.e") == std::string_view::npos;
      json += from == line ? "" : ",";
      json += number ? cell : "null";
    }
    json += "]";
  }
  return json + "]";
}

Json columns_json(const std::string& csv) {
  std::istringstream cells(csv.substr(0, csv.find('\n')));
  Json names = Json::array();
  for (std::string cell; std::getline(cells, cell, ',');) names.push_back(cell);
  return names;
}

Json ladder_json() {
  Json ladder = Json::array();
  for (uint32_t level = 0; const sandglass_level* described = sandglass_level_describe(level); ++level)
    ladder.push_back({{"name", described->name},
                      {"cost_solver", described->cost_solver},
                      {"cost_refine", described->cost_refine},
                      {"overlap_p99", described->overlap_p99},
                      {"overlap_mean", described->overlap_mean},
                      {"angle_degrees", described->angle_degrees}});
  return ladder;
}

Json light_json(const std::vector<LightSeries>& light) {
  Json all = Json::array();
  for (const LightSeries& series : light) {
    Json samples = Json::array();
    for (const LightSample& s : series.samples) {
      const auto& d = s.direction;
      const double norm = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      if (!(norm > 0.0)) continue;
      Json sample = {{"time_s", s.time}, {"direction", {d[0] / norm, d[1] / norm, d[2] / norm}}};
      if (s.colour[0] >= 0.0) sample["colour"] = s.colour;
      if (s.ambient[0] >= 0.0) sample["ambient"] = s.ambient;
      samples.push_back(std::move(sample));
    }
    if (!samples.empty()) all.push_back({{"name", series.name}, {"samples", std::move(samples)}});
  }
  return all;
}

// Escapes every "<": inside a script element, "</script" and "<!--" would end or change it.
std::string for_script(std::string json) {
  for (size_t at = 0; (at = json.find('<', at)) != std::string::npos; at += 6) json.replace(at, 1, "\\u003c");
  return json;
}

}  // namespace

std::string report_summary_json(const RunReport& report) { return summary_json(report).dump(2) + "\n"; }

std::string report_page_data(const RunReport& report, const PageContent& content) {
  const std::string csv = report_csv(report);
  Json data;
  data["summary"] = summary_json(report);
  data["ladder"] = ladder_json();
  data["light"] = light_json(content.light);
  data["light_name"] = report.light;
  data["columns"] = columns_json(csv);
  std::string text = data.dump();
  text.pop_back();
  return for_script(text + ",\"rows\":" + rows_json(csv) + "}");
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

// `sandglass verify SUITE`: measures claims against their truth, and wrong settings that must fail them.
#include "models/program/verify.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "models/files/atomic_file.h"
#include "models/program/commands.h"

namespace sandglass::host {

namespace {

const char* outcome_of(const Verdict& v) {
  if (v.control) return v.pass ? "fails, as it must" : "PASSES, but must fail";
  if (!v.pass) return "FAIL";
  return std::isinf(v.limit) ? "reported" : "pass";
}

std::string number(double value) {
  char text[32];
  if (std::isinf(value)) return "";
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

std::string table_csv(const std::vector<Verdict>& rows) {
  std::string text = "case,claim,unit,truth,result,limit,control,pass\n";
  for (const Verdict& v : rows)
    text += v.group + ",\"" + v.name + "\"," + v.unit + "," + number(v.truth) + "," + number(v.result) + "," +
            number(v.limit) + "," + (v.control ? "1" : "0") + "," + (v.pass ? "1" : "0") + "\n";
  return text;
}

std::string table_markdown(const std::vector<Verdict>& rows) {
  std::string text = "| case | claim | truth | result | limit | unit | |\n|---|---|---|---|---|---|---|\n";
  for (const Verdict& v : rows)
    text += "| " + v.group + " | " + v.name + " | " + number(v.truth) + " | " + number(v.result) + " | " +
            number(v.limit) + " | " + v.unit + " | " + outcome_of(v) + " |\n";
  return text;
}

}  // namespace

void print_verdicts(const std::vector<Verdict>& rows) {
  std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", "case", "claim", "truth", "result", "limit", "unit", "");
  for (const Verdict& v : rows)
    std::printf("%-11s %-32s %11s %11s %11s  %-11s %s\n", v.group.c_str(), v.name.c_str(), number(v.truth).c_str(),
                number(v.result).c_str(), number(v.limit).c_str(), v.unit.c_str(), outcome_of(v));
}

void write_verdicts(const std::string& folder, const std::vector<Verdict>& rows) {
  write_file(folder + "/verify.csv", table_csv(rows));
  write_file(folder + "/verify.md", table_markdown(rows));
}

uint32_t count_failed(const std::vector<Verdict>& rows) {
  uint32_t failed = 0;
  for (const Verdict& v : rows) failed += v.pass ? 0 : 1;
  return failed;
}

std::vector<Measurement> measurements_of(const std::string& suite, const std::string& isa, uint32_t threads,
                                         const std::vector<Verdict>& rows) {
  std::vector<Measurement> measurements;
  for (const Verdict& v : rows) {
    Measurement m;
    m.suite = suite, m.scene = v.name, m.metric = "result", m.unit = v.unit, m.isa = isa, m.value = v.result;
    m.threads = threads, m.judgement = Measurement::Judgement{v.truth, v.limit, v.pass, v.control};
    measurements.push_back(m);
  }
  return measurements;
}

std::string data_folder() {
  const char* data = std::getenv("SANDGLASS_DATA_DIR");
  return data == nullptr ? "" : data;
}

Failure no_panoramas(const std::string& what) {
  return Failure("cannot check " + what +
                 ": no panoramas are named. Name .hdr or .exr files, or folders of them, with " +
                 "--panoramas, or the data folder in SANDGLASS_DATA_DIR.");
}

}  // namespace sandglass::host

// What the suites of `sandglass_lab bench` share: the rows that they keep for --json, and how progress is shown.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "sandglass/sandglass.h"
#include "tests/laboratory/sand/granular_bench.h"
#include "tests/laboratory/suite.h"

namespace sandglass::host {

// Of all suites of bench.
struct BenchOptions {
  std::string json, out, isa = "automatic", mesh = "chair", asset;
  uint32_t frames = 100;
  std::vector<uint32_t> threads = {1};
};

struct Bench {
  std::string suite;
  sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC;
  std::string isa_name;  // of the kernels that this picks
  std::vector<Measurement> measurements;

  // For sand the kernels are those of a scene; shadows and light have tables of their own.
  enum class Kernels { sand, bytes };
  Bench(const std::string& suite, const std::string& isa, Kernels kernels);

  // From the first number on, Ctrl-C keeps what was measured. `kernels`: what computed it; empty: isa_name.
  void keep(const std::string& scene, const char* metric, const char* unit, double value, uint32_t threads = 1,
            const std::string& kernels = "");

 private:
  std::optional<KeepingResults> keeping_;
};

// A suite: what `suite` keeps is written for --json.
using BenchSuite = void (*)(const BenchOptions& options, Bench* bench);
Command bench_command(const char* name, const char* help, Options (*options)(BenchOptions&), BenchSuite suite,
                      Bench::Kernels kernels = Bench::Kernels::sand);

// A table of scenes: one row a run, with its times and the errors of the same run.
class SceneTable {
 public:
  explicit SceneTable(Bench* bench);  // prints the head

  // Runs a case behind a progress bar, prints its row and keeps its numbers.
  BenchRow row(const std::string& name, const SceneFile& scene, uint32_t threads, uint32_t frames, uint32_t level = 0,
               bool with_grains = true) const;

 private:
  Bench* bench_;
};

}  // namespace sandglass::host

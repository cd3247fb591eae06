// What the suites of `sandglass_lab bench` share: the rows that they keep for --json, and how progress is shown.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "models/files/measurement_json.h"
#include "models/program/command_line.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.h"
#include "tests/laboratory/sand/granular_bench.h"

namespace sandglass::host {

// Of all suites; bench.cpp says which takes what.
struct BenchOptions {
  std::string json, out, isa = "automatic", mesh = "chair", asset;
  uint32_t frames = 100;
  bool peers = false;
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

// One function a suite (bench_sand.cpp ...).
using BenchSuite = void (*)(const BenchOptions& options, Bench* bench);
void bench_granular(const BenchOptions& options, Bench* bench);
void bench_ladder(const BenchOptions& options, Bench* bench);
void bench_growth(const BenchOptions& options, Bench* bench);
void bench_shadow(const BenchOptions& options, Bench* bench);
void bench_lighting(const BenchOptions& options, Bench* bench);
void bench_machine(const BenchOptions& options, Bench* bench);

std::vector<Command> bench_suites();

// Runs a suite, writes what it kept, and returns the exit code.
int run_bench(const char* name, Bench::Kernels kernels, BenchSuite suite, const BenchOptions& options);

// A table of scenes: one row a run, with its times and the errors of the same run.
class SceneTable {
 public:
  explicit SceneTable(Bench* bench);  // prints the head

  // Runs a case behind a progress bar, prints its row and keeps its numbers. `kernels`: what computed it.
  BenchRow row(const std::string& name, uint32_t threads, uint32_t frames, const std::string& kernels,
               const std::function<BenchRow(const BenchStep&)>& run) const;
  BenchRow row(const std::string& name, const SceneFile& scene, uint32_t threads, uint32_t frames,
               uint32_t level = 0) const;

 private:
  Bench* bench_;
};

// Shows a progress bar while `measure` runs; what is passed on to it returns false after Ctrl-C.
using Progressed = std::function<bool(uint32_t done, uint32_t total)>;
void with_progress(const char* what, const std::function<void(const Progressed& go_on)>& measure);

}  // namespace sandglass::host

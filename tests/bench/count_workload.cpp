// The workload on which sand is counted: a scene of the size for phones (counted_sand.h). Prints how many items the kernels
// processed between the two marks.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/bench/counted_sand.h"

namespace {

constexpr int k_settling_frames = 6;  // after them the lattice is a moving pile, with contacts as in use
constexpr int k_counted_frames = 4;

}  // namespace

// count_workload [ISA [SETTLING_FRAMES [COUNTED_FRAMES [MICROSECONDS_A_FRAME [GRAINS]]]]]: the number of grains is about
// what is asked for.
int main(int argument_count, char** arguments) {
  const auto argument = [&](int at, int otherwise) {
    return at < argument_count ? std::atoi(arguments[at]) : otherwise;
  };
  const int settling_frames = argument(2, k_settling_frames), counted_frames = argument(3, k_counted_frames);
  const float edge = argument_count > 5 ? 0.2f / (std::cbrt(static_cast<float>(argument(5, 0))) - 0.5f) : 0.0068f;
  CountedSand sand(argument(1, SANDGLASS_ISA_AUTOMATIC), {}, edge);
  sand.input.time_step = 1e-6f * static_cast<float>(argument(4, 16667));
  sandglass::Status status = sand.status;
  const sandglass_frame_report& report = sand.report;
  for (int frame = 0; status && frame < settling_frames; ++frame) status = sand.scene.frame(sand.input, &sand.report);
  uint64_t iterations = 0, builds = 0, sweeps = 0, particle_sweeps = 0;
  counting_begins();
  for (int frame = 0; status && frame < counted_frames; ++frame) {
    status = sand.scene.frame(sand.input, &sand.report);
    iterations += static_cast<uint64_t>(report.sand.substeps) * report.sand.awake;
    builds += static_cast<uint64_t>(report.sand.list_builds) * report.sand.awake;
    sweeps += report.sand.awake_grains;
    particle_sweeps += report.sand.particles;
  }
  counting_ends();
  if (!status) {
    std::fprintf(stderr, "%s: %s\n", status.name(), status.reason);
    return 1;
  }
  std::printf(
      "isa %s\nparticles %u\ngrains %u\nframes %d\nparticle_iterations %llu\nparticle_builds %llu\ngrain_sweeps %llu\n"
      "particle_sweeps %llu\n",
      sandglass_isa_name(sand.scene.isa()), report.sand.particles, report.sand.grains, counted_frames,
      static_cast<unsigned long long>(iterations), static_cast<unsigned long long>(builds),
      static_cast<unsigned long long>(sweeps), static_cast<unsigned long long>(particle_sweeps));
  std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(sand.scene.hash()));
  return report.sand.quarantined == 0 ? 0 : 1;
}

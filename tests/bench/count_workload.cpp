// The workload on which sand is counted: a scene of the size for phones, 1,560 particles that carry 27,000 grains. It
// collapses on a floor beside a box; every frame does all of its work. Prints how many items the kernels processed
// between the two marks.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

namespace {

constexpr int k_settling_frames = 6;  // after them the lattice is a moving pile, with contacts as in use
constexpr int k_counted_frames = 4;

int fail(const sandglass::Status& status) { return std::fprintf(stderr, "%s: %s\n", status.name(), status.reason), 1; }

}  // namespace

// count_workload [ISA [SETTLING_FRAMES [COUNTED_FRAMES [MICROSECONDS_A_FRAME [GRAINS]]]]]: the number of grains is about
// what is asked for.
int main(int argument_count, char** arguments) {
  const auto argument = [&](int at, int otherwise) {
    return at < argument_count ? std::atoi(arguments[at]) : otherwise;
  };
  const int settling_frames = argument(2, k_settling_frames), counted_frames = argument(3, k_counted_frames);
  const float r = 0.01f;
  std::vector<float> particles, grains;
  const sandglass::Box box{{-0.10f, r, -0.10f}, {0.10f, 0.21f, 0.10f}};
  const auto everywhere = [](const float*) { return true; };
  sandglass::Status status = sandglass::sample_lattice(box, 2.02f * r, everywhere, &particles);
  if (!status) return fail(status);
  // Grains on a lattice of their own, each shifted by a fraction of its cell.
  const float edge = argument_count > 5 ? 0.2f / (std::cbrt(static_cast<float>(argument(5, 0))) - 0.5f) : 0.0068f;
  CountingRandom random;
  for (float y = r; y < 0.21f; y += edge) {
    for (float z = -0.1f; z < 0.1f; z += edge) {
      for (float x = -0.1f; x < 0.1f; x += edge) {
        for (const float at : {x, y, z}) grains.push_back(at + 0.5f * edge * random());
      }
    }
  }

  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.isa = argument(1, SANDGLASS_ISA_AUTOMATIC);
  desc.granular.particle_radius = r;
  desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
  desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
  desc.granular.collider_capacity = 2;
  sandglass::Scene scene;
  status = scene.create(desc);
  if (status) status = scene.add(particles, grains);
  if (!status) return fail(status);

  sandglass_collider colliders[2] = {sandglass::floor_at(0.0f), sandglass::floor_at(0.0f)};
  colliders[1].shape = SANDGLASS_SHAPE_BOX;
  colliders[1].position[0] = 0.2f;
  colliders[1].size[0] = colliders[1].size[1] = colliders[1].size[2] = 0.08f;
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1e-6f * static_cast<float>(argument(4, 16667));
  input.budget_ns = ~0ull;
  input.colliders = colliders;
  input.collider_count = 2;
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;

  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; status && frame < settling_frames; ++frame) status = scene.frame(input, &report);
  uint64_t iterations = 0, builds = 0, sweeps = 0, particle_sweeps = 0;
  counting_begins();
  for (int frame = 0; status && frame < counted_frames; ++frame) {
    status = scene.frame(input, &report);
    iterations += static_cast<uint64_t>(report.sand.substeps) * report.sand.awake;
    builds += static_cast<uint64_t>(report.sand.list_builds) * report.sand.awake;
    sweeps += report.sand.awake_grains;
    particle_sweeps += report.sand.particles;
  }
  counting_ends();
  if (!status) return fail(status);
  std::printf(
      "isa %s\nparticles %u\ngrains %u\nframes %d\nparticle_iterations %llu\nparticle_builds %llu\ngrain_sweeps %llu\n"
      "particle_sweeps %llu\n",
      sandglass_isa_name(scene.isa()), report.sand.particles, report.sand.grains, counted_frames,
      static_cast<unsigned long long>(iterations), static_cast<unsigned long long>(builds),
      static_cast<unsigned long long>(sweeps), static_cast<unsigned long long>(particle_sweeps));
  std::printf("hash 0x%016llx\n", static_cast<unsigned long long>(scene.hash()));
  return report.sand.quarantined == 0 ? 0 : 1;
}

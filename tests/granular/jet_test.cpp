// A steady jet of sand stretches as it falls, without gaps. Every grain falls as if it had left the nozzle at its own
// moment, so the jet is as thin at each height as its speed there says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/granular/granular_scene.h"

namespace {

constexpr float k_radius = 0.006f, k_grain_radius = 0.002f, k_nozzle = 0.022f, k_speed = 1.0f, k_frame = 1.0f / 60.0f;
constexpr double k_gravity = 9.81;
constexpr uint32_t k_grains_per_particle = 16;

struct Jet {
  double largest_gap;  // along the axis, grain radii
  double thinnest;     // grains in a slice of two grain radii, over what a steady jet has there
};

Jet measure(const std::vector<sandglass_grain>& grains, double per_second) {
  // Metres below the nozzle: from where the layers are apart to where the first grains are still to come.
  constexpr double k_from = 0.05, k_to = 0.42, k_slice = 2.0 * static_cast<double>(k_grain_radius);
  std::vector<double> below;
  std::vector<double> slices(static_cast<size_t>((k_to - k_from) / k_slice));
  for (const sandglass_grain& grain : grains) {
    const double y = -static_cast<double>(grain.position[1]);
    if (grain.speed < 0.0f || y < k_from || y > k_to) continue;
    below.push_back(y);
    const size_t slice = static_cast<size_t>((y - k_from) / k_slice);
    if (slice < slices.size()) slices[slice] += 1.0;
  }
  std::sort(below.begin(), below.end());
  Jet jet = {0.0, 1e9};
  for (size_t i = 1; i < below.size(); ++i)
    jet.largest_gap = std::max(jet.largest_gap, (below[i] - below[i - 1]) / static_cast<double>(k_grain_radius));
  for (size_t s = 0; s < slices.size(); ++s) {
    const double y = k_from + (static_cast<double>(s) + 0.5) * k_slice;
    const double speed = std::sqrt(static_cast<double>(k_speed * k_speed) + 2.0 * k_gravity * y);
    jet.thinnest = std::min(jet.thinnest, slices[s] * speed / (per_second * k_slice));
  }
  return jet;
}

TEST(Jet, StretchesWithoutGaps) {
  sandglass_scene_desc desc = description(2000, 2000 * k_grains_per_particle);
  desc.granular.particle_radius = k_radius, desc.granular.grain_radius = k_grain_radius;
  desc.granular.emitter_capacity = 1;
  GranularScene scene(desc);
  const sandglass_emitter emitter =
      sandglass::emitter(0.0f, 0.0f, 0.0f, k_nozzle, k_speed, k_grains_per_particle);
  scene.grains.resize(2000 * k_grains_per_particle);
  sandglass_frame_report report = {};
  for (int frame = 1; frame <= 30; ++frame) {
    sandglass_frame_input input = scene.input(k_frame);
    input.emitters = &emitter, input.emitter_count = 1;
    report = scene.run(input);
    if (frame < 21) continue;
    std::vector<sandglass_grain> grains(scene.grains.begin(), scene.grains.begin() + report.grain_numbers);
    const Jet jet = measure(grains, report.grains / (frame * static_cast<double>(k_frame)));
    double wide = 0, n = 0;
    for (auto& g : grains) if (g.position[1] < -0.35f && g.position[1] > -0.42f) wide += g.position[0]*g.position[0] + g.position[2]*g.position[2], n += 1;
    std::printf("frame %d: largest gap %.2f grain radii, thinnest slice %.2f of a steady jet's, %u grains, rms %.4f of %.4f\n", frame,
                jet.largest_gap, jet.thinnest, report.grains, std::sqrt(wide/n), k_nozzle / std::sqrt(2.0));
  }
}

}  // namespace

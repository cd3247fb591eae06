// Frames in which little moves: all asleep, with the sand's shadow; one particle, without grains, that falls beside the
// pile; a hand that stirs the pile's edge, by which 15 particles are awake. 225 particles, 4,000 grains: a
// settled pile of the size for phones takes the emulator minutes. What rests costs the same at any size.
//
//   count_rest         the names
//   count_rest NAME    counts 8 frames; prints the instruction set and the number of frames as items
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "tests/bench/counted_sand.h"

namespace {

constexpr const char* k_names[] = {"asleep", "one_falls", "edge"};
constexpr int k_frames = 8;

int run(const char* name) {
  CountedSand sand(SANDGLASS_ISA_AUTOMATIC, {}, 0.0068f, 1, 0.105f);
  sandglass_pile_shadow_desc desc = sandglass::pile_shadow_desc();
  desc.sky_texels = 64;
  desc.on_sand = 0;
  std::fill_n(desc.low, 2, -0.9f);
  std::fill_n(desc.high, 2, 0.9f);
  sandglass::PileShadow shadow;
  sandglass::Status status = sand.status;
  if (status) status = shadow.create(desc);
  if (status) status = shadow.set_light({0.5f, 0.7f, 0.2f});
  sand.input.collider_count = 1;
  sand.input.grains_age = 1;
  sand.input.pile_shadow = shadow.get();
  const sandglass_sand_report& report = sand.report.sand;
  for (int i = 0, rested = 0; status && rested < 3 && i < 600; ++i) {
    status = sand.scene.frame(sand.input, &sand.report);
    rested = report.awake == 0 && report.awake_grains == 0 ? rested + 1 : 0;
  }
  const bool falls = std::strcmp(name, "one_falls") == 0, edge = std::strcmp(name, "edge") == 0;
  if (status && falls) status = sand.scene.add(std::vector<float>{1.2f, 2.0f, 1.2f});
  sandglass_collider& hand = sand.colliders[1];
  int frame = 0;
  const auto next = [&] {
    const float turn = 0.1f * static_cast<float>(frame++), wide = 0.01f;
    if (edge) {
      hand = sandglass::sphere(0.12f + wide * std::cos(turn), 0.015f, wide * std::sin(turn), 0.015f);
      hand.linear_velocity[0] = -6 * wide * std::sin(turn);
      hand.linear_velocity[2] = 6 * wide * std::cos(turn);
      sand.input.collider_count = 2;
    }
    if (status) status = sand.scene.frame(sand.input, &sand.report);
  };
  for (int i = 0; i < (edge ? 60 : 6); ++i) next();
  uint32_t awake = 0;
  counting_begins();
  for (int i = 0; i < k_frames; ++i) {
    next();
    awake += report.awake;
  }
  counting_ends();
  if (!status) {
    std::fprintf(stderr, "%s: %s\n", status.name(), status.reason);
    return 1;
  }
  std::fprintf(stderr, "%s: %.1f particles awake, %u grains followed in the last frame\n", name,
               awake / static_cast<double>(k_frames), report.awake_grains);
  std::printf("isa %s\nitems %d\n", sandglass_isa_name(sand.scene.isa()), k_frames);
  return 0;
}

}  // namespace

int main(int argument_count, char** arguments) {
  for (const char* name : k_names) {
    if (argument_count < 2) std::printf("%s\n", name);
    else if (std::strcmp(name, arguments[1]) == 0) return run(name);
  }
  return argument_count < 2 ? 0 : 1;
}

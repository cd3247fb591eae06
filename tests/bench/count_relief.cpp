// A frame while sand pours over books: on a plane, and on a relief beside it. 1,560 particles that carry 27,000 grains collapse,
// and a nozzle pours more.
//
//   count_relief         the names
//   count_relief NAME    counts 8 frames; prints the instruction set and the number of frames as items
#include <cmath>
#include <cstring>

#include "runtime/relief/relief.h"
#include "tests/bench/counted_sand.h"

namespace {

constexpr const char* k_names[] = {"pour_on_plane", "pour_on_relief"};
constexpr int k_settling_frames = 16, k_frames = 8;

// A book of 3 cm beside the sand, and one of 2 cm on it.
int16_t height_of(float x, float z) {
  const bool lower = std::fabs(x - 0.22f) < 0.11f && std::fabs(z) < 0.085f,
             upper = std::fabs(x - 0.24f) < 0.08f && std::fabs(z - 0.01f) < 0.065f;
  return lower ? (upper ? 200 : 120) : 0;
}

int run(const char* name) {
  CountedSand sand(SANDGLASS_ISA_AUTOMATIC, {}, 0.0068f, 200);
  sandglass::Status status = sand.status;
  sandglass::Relief relief;
  if (status) status = relief.create();
  if (!status) return wrong(status.reason);
  sandglass::ReliefState* r = &relief.get()->relief;
  for (uint32_t i = 0; i < relief_cells(*r); ++i)
    relief_set_cell(
        r, i, height_of(0.01f * static_cast<float>(i % 128) - 0.635f, 0.01f * static_cast<float>(i / 128) - 0.635f));
  relief_end_change(r);
  const bool on_relief = std::strcmp(name, k_names[1]) == 0;
  sand.colliders[1] = sandglass::relief_collider(relief);
  sand.colliders[1].id = 1;
  sand.input.collider_count = on_relief ? 2 : 1;
  const sandglass_emitter emitter = sandglass::emitter(0.2f, 0.5f, 0.0f, 0.03f, 0.6f);
  sand.input.emitters = &emitter;
  sand.input.emitter_count = 1;
  const auto next = [&] {
    if (status) status = sand.scene.frame(sand.input, &sand.report);
  };
  for (int i = 0; i < k_settling_frames; ++i) next();
  counting_begins();
  for (int i = 0; i < k_frames; ++i) next();
  counting_ends();
  if (!status) return wrong(status.reason);
  if (sand.report.sand.emitted_particles == 0) return wrong("nothing pours");
  std::printf("isa %s\nitems %d\n", sandglass_isa_name(sand.scene.isa()), k_frames);
  return 0;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count > 1) return run(arguments[1]);
  for (const char* name : k_names) std::printf("%s\n", name);
  return 0;
}

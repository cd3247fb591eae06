// What an app gets when it asks for one instruction set by name, through the API. Prints a line for every instruction
// set of ARM: which kernels sand, a shadow and the light get, or that the set is refused. All that run must end in the
// same bits.
//   choice SHADOW_FILE
#include <cstdio>
#include <exception>
#include <vector>

#include "models/files/aligned_bytes.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "sandglass/sandglass.hpp"

namespace {

using sandglass::Status;
using sandglass::host::AlignedBytes;

struct Answer {
  Status status;
  sandglass_isa isa = 0;
  uint64_t hash = 0;
};

// Three frames of a column of sand.
Answer sand(sandglass_isa isa) {
  Answer answer;
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.isa = isa;
  desc.granular.particle_capacity = 1024;
  sandglass::Scene scene;
  std::vector<float> particles;
  const sandglass::Box box{{0, 0, 0}, {0.1f, 0.15f, 0.1f}};
  answer.status = sandglass::sample_lattice(
      box, 0.0202f, [](const float*) { return true; }, &particles);
  if (answer.status) answer.status = scene.create(desc);
  if (answer.status) answer.status = scene.add(particles);
  const sandglass_collider floor = sandglass::floor_at(0.0f);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 0.016f, input.budget_ns = ~0ull, input.colliders = &floor, input.collider_count = 1;
  for (int frame = 0; answer.status && frame < 3; ++frame) answer.status = scene.frame(input);
  if (answer.status) answer.isa = scene.isa(), answer.hash = scene.hash();
  return answer;
}

// A coarse texture of a baked file.
Answer shadow(const AlignedBytes& file, sandglass_isa isa) {
  sandglass_shadow_desc desc = sandglass::shadow_desc();
  desc.isa = isa, desc.asset = file.data(), desc.asset_bytes = file.size(), desc.threshold = 255;
  Answer answer;
  sandglass::Shadow made;
  answer.status = made.create(desc);
  if (answer.status) answer.status = made.set_light({0.3f, 1.0f, 0.2f});
  if (!answer.status) return answer;
  made.run();
  answer.isa = sandglass_shadow_isa(made.get()), answer.hash = made.hash();
  return answer;
}

// The light as the API makes it, with its network on the smallest image.
Answer light(const std::vector<uint8_t>& file, sandglass_isa isa) {
  const AlignedBytes aligned(file);
  sandglass_estimator_desc desc = sandglass::estimator_desc();
  desc.isa = isa, desc.asset = aligned.data(), desc.asset_bytes = aligned.size();
  Answer answer;
  sandglass::Estimator made;
  answer.status = made.create(desc);
  if (!answer.status) return answer;
  answer.isa = sandglass_estimator_isa(made.get());
  sandglass::host::LightRunner runner(file, "random", isa, 32, 32);
  std::vector<uint8_t> rgb(size_t{3} * 32 * 32);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(37 * i);
  runner.run(rgb);
  for (const float feature : runner.features())
    answer.hash = answer.hash * 31 + static_cast<uint64_t>(static_cast<int64_t>(65536 * feature));
  return answer;
}

}  // namespace

int main(int argument_count, char** arguments) try {
  if (argument_count < 2) return std::fprintf(stderr, "choice FILE: FILE must be a baked shadow\n"), 2;
  const AlignedBytes shadow_file = sandglass::host::read_aligned(arguments[1], "baked shadow");
  const std::vector<uint8_t> light_file = sandglass::host::light_file_bytes(sandglass::host::random_light_file(1));
  std::vector<uint64_t> first;
  for (const sandglass_isa isa :
       {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_NEON_DOTPROD, SANDGLASS_ISA_NEON_I8MM}) {
    const char* name = sandglass_isa_name(isa);
    sandglass_pile_shadow_desc pile = sandglass::pile_shadow_desc();
    pile.isa = isa;
    const Answer answers[] = {
        sand(isa), shadow(shadow_file, isa), light(light_file, isa), {sandglass::PileShadow().create(pile)}};
    const bool available = sandglass_isa_available(isa) != 0;
    for (const Answer& answer : answers)
      if (answer.status.code != (available ? SANDGLASS_OK : SANDGLASS_ERROR_UNSUPPORTED))
        return std::printf("%s: not the answer of sandglass_isa_available: %s\n", name,
                           answer.status ? "accepted" : answer.status.reason),
               1;
    if (!available) {
      std::printf("%s refused\n", name);
      continue;
    }
    std::printf("%s sand %s shadow %s light %s\n", name, sandglass_isa_name(answers[0].isa),
                sandglass_isa_name(answers[1].isa), sandglass_isa_name(answers[2].isa));
    const std::vector<uint64_t> hashes = {answers[0].hash, answers[1].hash, answers[2].hash};
    if (first.empty()) first = hashes;
    if (hashes != first) return std::printf("%s: other bits\n", name), 1;
  }
  return 0;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "choice: %s\n", e.what()), 2;
}

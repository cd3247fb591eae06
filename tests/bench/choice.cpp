// What an app gets when it asks for one instruction set by name, through the API. Prints a line for every instruction
// set of ARM: which kernels sand, a shadow and the light get, or that the set is refused. All that run must end in the
// same bits.
//   choice SHADOW_FILE
#include <algorithm>
#include <cstdio>
#include <exception>
#include <vector>

#include "models/files/aligned_bytes.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "sandglass/light.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/sandglass.hpp"
#include "sandglass/shadow.h"

namespace {

using sandglass::cpp::allocate_block;
using sandglass::cpp::Block;
using sandglass::host::AlignedBytes;

struct Answer {
  sandglass_status status = SANDGLASS_OK;
  sandglass_isa isa = 0;
  uint64_t hash = 0;
  const char* reason = nullptr;
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
  sandglass::Status status = sandglass::sample_lattice(
      box, 0.0202f, [](const float*) { return true; }, &particles);
  if (status) status = scene.create(desc);
  if (status) status = scene.add(particles, {});
  const sandglass_collider floor = sandglass::floor_at(0.0f);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 0.016f, input.budget_ns = ~0ull, input.colliders = &floor, input.collider_count = 1;
  sandglass_frame_report report = sandglass::frame_report();
  for (int frame = 0; status && frame < 3; ++frame) status = scene.frame(input, &report);
  answer.status = status.code, answer.reason = status.reason;
  if (status) answer.isa = scene.isa(), answer.hash = scene.hash();
  return answer;
}

// A coarse texture of a baked file.
Answer shadow(const AlignedBytes& file, sandglass_isa isa) {
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.isa = isa, desc.asset = file.data(), desc.asset_bytes = file.size(), desc.threshold = 255;
  Answer answer;
  uint64_t bytes = 0;
  answer.status = sandglass_shadow_bytes(&desc, &bytes, &answer.reason);
  if (answer.status != SANDGLASS_OK) return answer;
  const Block block = allocate_block(bytes);
  sandglass_shadow* made = nullptr;
  const float light[3] = {0.3f, 1.0f, 0.2f};
  answer.status = sandglass_shadow_create(&desc, block.get(), bytes, &made, &answer.reason);
  if (answer.status == SANDGLASS_OK) answer.status = sandglass_shadow_set_light(made, 0, light, 1.0f, &answer.reason);
  if (answer.status != SANDGLASS_OK) return answer;
  while (sandglass_shadow_units_left(made) != 0) sandglass_shadow_run(&made, 1, 64);
  answer.isa = sandglass_shadow_isa(made), answer.hash = sandglass_shadow_hash(made);
  return answer;
}

// The light as the API makes it, with its network on the smallest image.
Answer light(const std::vector<uint8_t>& file, sandglass_isa isa) {
  const AlignedBytes aligned(file);
  sandglass_light_desc desc;
  sandglass_light_desc_default(&desc);
  desc.isa = isa, desc.asset = aligned.data(), desc.asset_bytes = aligned.size();
  Answer answer;
  uint64_t bytes = 0;
  answer.status = sandglass_light_bytes(&desc, &bytes, &answer.reason);
  if (answer.status != SANDGLASS_OK) return answer;
  const Block block = allocate_block(bytes);
  sandglass_light* made = nullptr;
  answer.status = sandglass_light_create(&desc, block.get(), bytes, &made, &answer.reason);
  if (answer.status != SANDGLASS_OK) return answer;
  answer.isa = sandglass_light_isa(made);
  sandglass_light_release(made);
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
    const Answer answers[3] = {sand(isa), shadow(shadow_file, isa), light(light_file, isa)};
    const char* name = sandglass_isa_name(isa);
    sandglass_pile_shadow_desc pile;
    sandglass_pile_shadow_desc_default(&pile);
    pile.isa = isa;
    uint64_t bytes = 0;
    const sandglass_status of_pile = sandglass_pile_shadow_bytes(&pile, &bytes, nullptr);
    const bool available = sandglass_isa_available(isa) != 0;
    const sandglass_status expected = available ? SANDGLASS_OK : SANDGLASS_ERROR_UNSUPPORTED;
    std::vector<uint64_t> hashes;
    for (const Answer& answer : answers) {
      if (answer.status != expected || of_pile != expected)
        return std::printf("%s: not the answer of sandglass_isa_available: %s\n", name,
                           answer.reason != nullptr ? answer.reason : "accepted"),
               1;
      hashes.push_back(answer.hash);
    }
    if (!available) {
      std::printf("%s refused\n", name);
      continue;
    }
    std::printf("%s sand %s shadow %s light %s\n", name, sandglass_isa_name(answers[0].isa),
                sandglass_isa_name(answers[1].isa), sandglass_isa_name(answers[2].isa));
    if (first.empty()) first = hashes;
    if (hashes != first) return std::printf("%s: other bits\n", name), 1;
  }
  return 0;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "choice: %s\n", e.what()), 2;
}

// What is counted: one shadow texture of 256 x 256 of the shipped chair, with one table of int8 kernels.
//   count_shadow FILE ISA full|adaptive
// Exit code 77: this CPU lacks the instruction set.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#include "sandglass/shadow.h"

extern "C" {
__attribute__((noinline)) void counting_begins() { __asm__ volatile(""); }
__attribute__((noinline)) void counting_ends() { __asm__ volatile(""); }
}

int main(int argument_count, char** arguments) {
  if (argument_count != 4) return std::fprintf(stderr, "count_shadow FILE ISA full|adaptive\n"), 2;
  std::FILE* file = std::fopen(arguments[1], "rb");
  if (file == nullptr) return std::fprintf(stderr, "cannot read %s\n", arguments[1]), 2;
  std::vector<uint64_t> words(1 << 18);
  const size_t bytes = std::fread(words.data(), 1, 8 * words.size(), file);
  std::fclose(file);

  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.asset = words.data(), desc.asset_bytes = bytes, desc.isa = std::atoi(arguments[2]);
  desc.mode = std::strcmp(arguments[3], "full") == 0 ? SANDGLASS_SHADOW_FULL : SANDGLASS_SHADOW_ADAPTIVE;
  uint64_t need = 0;
  const char* reason = nullptr;
  sandglass_status status = sandglass_shadow_bytes(&desc, &need, &reason);
  if (status == SANDGLASS_ERROR_UNSUPPORTED) return 77;
  sandglass_shadow* shadow = nullptr;
  void* block = ::operator new (need + 1, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT});
  if (status == SANDGLASS_OK) status = sandglass_shadow_create(&desc, block, need, &shadow, &reason);
  const float light[3] = {0.6f, 0.75f, 0.28f};  // 41 degrees from the zenith
  if (status == SANDGLASS_OK) status = sandglass_shadow_set_light(shadow, 0, light, 1, &reason);
  if (status != SANDGLASS_OK) return std::fprintf(stderr, "%s\n", reason), 1;
  counting_begins();
  while (sandglass_shadow_run(&shadow, 1, 1000) > 0) {
  }
  counting_ends();
  sandglass_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow, 0, &texture);
  std::printf("evaluated %u\n", texture.evaluated);
  ::operator delete (block, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT});
}

// A baked shadow with a right checksum and wrong content: it is refused, or every set of kernels makes the same texture.
#include "sandglass/sandglass.hpp"
#include "tests/asset_file.h"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/shadow/shadow_fixture.h"

namespace {

using namespace sandglass;

uint64_t hash_of_texture(const tests::AssetFile& file, sandglass_isa isa, bool* taken) {
  sandglass_shadow_desc desc = tests::describe(file, isa);
  Shadow shadow;
  *taken = static_cast<bool>(shadow.create(desc));
  if (!*taken) return 0;
  const float towards[3] = {0.3f, 0.9f, 0.1f};
  fuzz::expect(sandglass_shadow_set_light(shadow.get(), 0, towards, 1.0f, nullptr) == SANDGLASS_OK);
  float cells[SANDGLASS_LIGHT_CELLS];
  for (float& cell : cells) cell = 1.0f / SANDGLASS_LIGHT_CELLS;
  fuzz::expect(sandglass_shadow_set_cells(shadow.get(), cells, 0.0f, nullptr) == SANDGLASS_OK);
  sandglass_shadow* handle = shadow.get();
  sandglass_shadow_run(&handle, 1, 6);  // a whole texture takes a second under sanitizers
  return sandglass_shadow_hash(shadow.get());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const tests::AssetFile base = [] {
    tests::RandomShadow what;
    what.width = 8;
    what.layers = 1;
    what.texel_frequencies = 1;
    what.light_frequencies = 1;
    what.version = 2;
    what.ambient_side = 16;
    what.components = 2;
    what.surface_vertices = 9;
    return tests::make_shadow_file(what);
  }();
  std::vector<uint8_t> bytes(base.data(), base.data() + base.bytes);
  fuzz::apply_edits(data, size, &bytes);
  if (bytes.size() < 16) return 0;
  tests::AssetFile file(bytes);
  file.repair_checksum();
  bool by_scalar = false, by_other = false;
  const uint64_t scalar = hash_of_texture(file, SANDGLASS_ISA_SCALAR, &by_scalar);
  const uint64_t other = hash_of_texture(file, fuzz::other_kernels(data, size), &by_other);
  fuzz::expect(by_scalar == by_other && scalar == other && (by_scalar || size >= fuzz::k_edit_bytes));
  return 0;
}

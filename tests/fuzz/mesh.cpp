// A mesh file of any bytes: it is refused by a sentence, or all of its indices are within it and it can be sampled.
#include "models/mesh/mesh.h"
#include "tests/fuzz/read_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  constexpr const char* k_extensions[] = {".obj", ".ply", ".stl"};
  fuzz::read_as_file(data, size, k_extensions, [](const std::string& path) {
    const host::MeshResult result = host::load_mesh(path);
    fuzz::expect(static_cast<bool>(result) == result.error.empty());
    if (!result) return;
    for (const uint32_t index : result.mesh.indices) fuzz::expect(index < result.mesh.vertex_count());
    for (const float x : result.mesh.vertices) fuzz::expect(std::isfinite(x));
    (void)host::signed_volume(result.mesh);
  });
  return 0;
}

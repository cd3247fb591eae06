// A mesh of any bytes, as a file or as arrays: it is refused by a sentence, or all of its indices are within it and it is
// finite. The readers of FBX and Collada run in a process of their own and are left out.
#include "models/mesh/readers.h"
#include "tests/fuzz/edits.h"

namespace {

using namespace sandglass;

void check(const host::MeshResult& result) {
  fuzz::expect(static_cast<bool>(result) == result.error.empty());
  if (!result) return;
  for (const uint32_t index : result.mesh.indices) fuzz::expect(index < result.mesh.vertex_count());
  for (const float x : result.mesh.vertices) fuzz::expect(std::isfinite(x));
  fuzz::expect(std::isfinite(host::signed_volume(result.mesh)));
}

// A corner of a lattice a byte, so that corners coincide and edges meet; then some of the numbers change.
void clean_arrays(const uint8_t* data, size_t size) {
  const size_t edits = size / 2 / 8 * 8, corners = size - edits;
  host::Mesh mesh;
  for (uint32_t corner = 0; corner < 64; ++corner)
    for (const uint32_t k : {0u, 2u, 4u}) mesh.vertices.push_back(static_cast<float>(corner >> k & 3));
  for (size_t i = 0; i < corners; ++i) mesh.indices.push_back(data[i] % 66u);
  std::vector<uint8_t> bytes(mesh.vertices.size() * sizeof(float));
  std::memcpy(bytes.data(), mesh.vertices.data(), bytes.size());
  fuzz::apply_edits(data + corners, edits, &bytes);
  mesh.vertices.resize(bytes.size() / sizeof(float));
  std::memcpy(mesh.vertices.data(), bytes.data(), mesh.vertices.size() * sizeof(float));
  check(host::clean_mesh(mesh.vertices, mesh.indices, "arrays"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr uint8_t k_as_arrays = 16;  // of 256
  if (size > 0 && data[0] < k_as_arrays && data[0] != '\n') {
    clean_arrays(data + 1, size - 1);
    return 0;
  }
  host::FileMesh mesh;
  const std::string error = host::read_mesh({{reinterpret_cast<const char*>(data), size}}, &mesh);
  fuzz::expect(error.empty() || error.ends_with("."));
  if (error.empty()) check(host::finished_mesh(std::move(mesh), {}, "file"));
  return 0;
}

// What packers make of a glTF's buffers, by their own libraries: meshoptimizer (EXT_meshopt_compression) and Draco
// (KHR_draco_mesh_compression). A build without one of them refuses what it packed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sandglass::host {

// The fields of the extension; `count` items of `stride` bytes.
struct MeshoptView {
  size_t count = 0, stride = 0;
  std::string mode, filter = "NONE";
};
// Whether so many bytes can be those items.
inline bool could_be_unpacked(size_t bytes, const MeshoptView& view) {
  constexpr size_t k_growth_max = 256;  // more than any of the codecs makes of one
  return view.count * view.stride / k_growth_max <= bytes;
}
// False for data that are damaged.
bool unpack_meshopt(std::string_view packed, const MeshoptView& view, std::string* bytes);

struct DracoState;
struct DracoMesh {
  std::shared_ptr<DracoState> state;
};
bool reads_draco();
// Each is false for data that are damaged.
bool unpack_draco(std::string_view packed, DracoMesh* mesh);
// *is_share: whole numbers have become shares of their most already.
bool draco_attribute(const DracoMesh& mesh, uint32_t id, size_t parts, std::vector<double>* values, bool* is_share);
void draco_triangles(const DracoMesh& mesh, std::vector<uint32_t>* corners);

}  // namespace sandglass::host

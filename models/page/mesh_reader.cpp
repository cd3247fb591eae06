// The program's mesh readers as a module of the page: the bytes of a file in, triangles or a sentence out. What
// meshoptimizer packed is unpacked by its own JavaScript; what Draco packed is refused.
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/packed.h"
#include "models/mesh/readers.h"

#define EXPORTED(name) extern "C" __attribute__((export_name(name)))

extern "C" __attribute__((import_module("env"), import_name("unpack_meshopt"))) int unpack_by_javascript(
    char* to, size_t count, size_t stride, const char* from, size_t bytes, const char* mode, const char* filter);

namespace sandglass::host {

namespace {
MeshResult result;
}

bool unpack_meshopt(std::string_view packed, const MeshoptView& view, std::string* bytes) {
  if (!could_be_unpacked(packed.size(), view)) return false;
  bytes->assign(view.count * view.stride, '\0');
  return unpack_by_javascript(bytes->data(), view.count, view.stride, packed.data(), packed.size(), view.mode.c_str(),
                              view.filter.c_str()) != 0;
}
bool reads_draco() { return false; }
bool unpack_draco(std::string_view, DracoMesh*) { return false; }
bool draco_attribute(const DracoMesh&, uint32_t, size_t, std::vector<double>*, bool*) { return false; }
void draco_triangles(const DracoMesh&, std::vector<uint32_t>*) {}

// Returns the sentence that refuses the file, or an empty one; the triangles are then those below, until the next call.
EXPORTED("mesh_read") const char* mesh_read(const char* bytes, size_t size, const char* name) {
  const std::string_view file(bytes, size);
  FileMesh mesh;
  const std::string error = file.starts_with(k_lfs_pointer)
                                ? "is a Git LFS pointer, not the file itself. Fetch that with git lfs pull."
                                : read_mesh({file}, &mesh);
  result = {};
  if (error.empty()) result = finished_mesh(std::move(mesh), {}, name);
  else result.error = message("read", name, "it " + error);
  return result.error.c_str();
}
// What a user should know of it, in one line.
EXPORTED("mesh_remarks") const char* mesh_remarks() {
  static std::string all;
  all.clear();
  for (const std::string& remark : result.remarks) all += (all.empty() ? "" : "; ") + remark;
  return all.c_str();
}
EXPORTED("mesh_vertices") const float* mesh_vertices() { return result.mesh.vertices.data(); }
EXPORTED("mesh_vertex_count") uint32_t mesh_vertex_count() { return result.mesh.vertex_count(); }
EXPORTED("mesh_indices") const uint32_t* mesh_indices() { return result.mesh.indices.data(); }
EXPORTED("mesh_triangle_count") uint32_t mesh_triangle_count() { return result.mesh.triangle_count(); }

}  // namespace sandglass::host

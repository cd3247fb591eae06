// See packed.h.
#include "models/mesh/packed.h"

#ifdef SANDGLASS_HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#ifdef SANDGLASS_HAVE_DRACO
#include <draco/compression/decode.h>
#endif

namespace sandglass::host {

#ifdef SANDGLASS_HAVE_MESHOPTIMIZER
bool unpack_meshopt(std::string_view packed, const MeshoptView& view, std::string* bytes) {
  const auto* data = reinterpret_cast<const unsigned char*>(packed.data());
  const auto [count, stride] = std::pair(view.count, view.stride);
  if (!could_be_unpacked(packed.size(), view)) return false;
  bytes->assign(count * stride, '\0');
  // The library asserts what a file may break.
  if (view.mode == "ATTRIBUTES") {
    if (stride == 0 || stride % 4 != 0 ||
        meshopt_decodeVertexBuffer(bytes->data(), count, stride, data, packed.size()) != 0)
      return false;
  } else if (view.mode == "TRIANGLES") {
    if ((stride != 2 && stride != 4) || count % 3 != 0 ||
        meshopt_decodeIndexBuffer(bytes->data(), count, stride, data, packed.size()) != 0)
      return false;
  } else if (view.mode == "INDICES") {
    if ((stride != 2 && stride != 4) ||
        meshopt_decodeIndexSequence(bytes->data(), count, stride, data, packed.size()) != 0)
      return false;
  } else {
    return false;
  }
  if (view.filter == "NONE") return true;
  if (view.mode != "ATTRIBUTES") return false;
  if (view.filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
    meshopt_decodeFilterOct(bytes->data(), count, stride);
  else if (view.filter == "QUATERNION" && stride == 8) meshopt_decodeFilterQuat(bytes->data(), count, stride);
  else if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes->data(), count, stride);
  else return false;
  return true;
}
#else
bool unpack_meshopt(std::string_view, const MeshoptView&, std::string*) { return false; }
#endif

#ifdef SANDGLASS_HAVE_DRACO

struct DracoState {
  std::unique_ptr<draco::Mesh> mesh;
};

bool reads_draco() { return true; }

bool unpack_draco(std::string_view packed, DracoMesh* mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data(), packed.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return false;
  mesh->state = std::make_shared<DracoState>();
  mesh->state->mesh = std::move(decoded).value();
  return mesh->state->mesh != nullptr;
}

bool draco_attribute(const DracoMesh& mesh, uint32_t id, size_t parts, std::vector<double>* values, bool* is_share) {
  const draco::Mesh& from = *mesh.state->mesh;
  const draco::PointAttribute* attribute = from.GetAttributeByUniqueId(id);
  if (attribute == nullptr || parts > 4) return false;
  values->clear();
  *is_share = attribute->normalized();
  float item[4];
  for (draco::PointIndex p(0); p < from.num_points(); ++p) {
    if (!attribute->ConvertValue(attribute->mapped_index(p), static_cast<int8_t>(parts), item)) return false;
    for (size_t k = 0; k < parts; ++k) values->push_back(static_cast<double>(item[k]));
  }
  return true;
}

void draco_triangles(const DracoMesh& mesh, std::vector<uint32_t>* corners) {
  for (draco::FaceIndex f(0); f < mesh.state->mesh->num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh.state->mesh->face(f)) corners->push_back(corner.value());
}

#else
bool reads_draco() { return false; }
bool unpack_draco(std::string_view, DracoMesh*) { return false; }
bool draco_attribute(const DracoMesh&, uint32_t, size_t, std::vector<double>*, bool*) { return false; }
void draco_triangles(const DracoMesh&, std::vector<uint32_t>*) {}
#endif

}  // namespace sandglass::host

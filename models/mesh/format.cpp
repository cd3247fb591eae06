// What a file is, by its content; and what its triangles become: in metres, y up, near the origin, cleaned.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "models/files/failure.h"
#include "models/mesh/readers.h"
#include "models/mesh/words.h"

namespace sandglass::host {

// The list of the formats. Sentences name them in this order.
#define SANDGLASS_MESH_FORMATS(a) a(gltf) a(obj) a(ply) a(stl) a(off) a(fbx) a(collada)
#define SANDGLASS_DECLARED(name) extern const MeshFormat k_##name;
#define SANDGLASS_LISTED(name) &k_##name,
SANDGLASS_MESH_FORMATS(SANDGLASS_DECLARED)

const std::vector<const MeshFormat*>& mesh_formats() {
  static const std::vector<const MeshFormat*> all = {SANDGLASS_MESH_FORMATS(SANDGLASS_LISTED)};
  return all;
}

std::string offered_formats() {
  std::vector<std::string> names;
  for (const MeshFormat* format : mesh_formats())
    if (format->is_offered) names.emplace_back(format->name);
  return list_of(names, "or");
}

std::string ends_after(size_t there, size_t given, const char* what) {
  return "ends after " + std::to_string(there) + " of " + std::to_string(given) + " " + what +
         ". Copy or export it again.";
}

MeshKind mesh_kind(std::string_view file) {
  constexpr std::pair<std::string_view, const char*> k_others[] = {{"PK\x03\x04", "a 3MF file or another archive"},
                                                                   {"BLENDER", "a Blender file"},
                                                                   {"#usda", "a USD file"},
                                                                   {"PXR-USDC", "a USD file"},
                                                                   {"xof ", "a DirectX file"},
                                                                   {"ISO-10303-21", "a STEP file"}};
  const std::string_view text = file.substr(std::min(file.find_first_not_of("\xEF\xBB\xBF \t\r\n"), file.size()));
  const std::string_view head = text.substr(0, 4096);
  for (const auto& [magic, name] : k_others)
    if (head.starts_with(magic)) return {nullptr, std::string("is ") + name};
  const MeshFormat* likely = nullptr;
  for (const MeshFormat* format : mesh_formats()) {
    const Likeness likeness = format->likeness(file, head);
    if (likeness == Likeness::sure) return {format, ""};
    if (likeness == Likeness::some && likely == nullptr) likely = format;
  }
  if (head.starts_with("{")) return {nullptr, "is JSON, but no glTF"};
  if (head.starts_with("<"))
    return {nullptr, head.find("<amf") != std::string_view::npos ? "is an AMF file" : "is XML, but no Collada"};
  return {likely, "is no kind of mesh that is known here"};
}

std::string read_mesh(const MeshSource& source, FileMesh* mesh) {
  const MeshKind kind = mesh_kind(source.file);
  if (kind.format != nullptr) return kind.format->read(source, mesh);
  return kind.is_instead + ". Export it as " + offered_formats() + ".";
}

MeshResult finished_mesh(FileMesh file, const MeshUnits& units, const std::string& name) {
  constexpr double k_steps = 1e4;  // that floats must have across the mesh
  std::vector<double>& v = file.vertices;
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (size_t i = 0; i + 2 < v.size(); i += 3) {
    if (units.z_up) v[i + 1] = std::exchange(v[i + 2], -v[i + 1]);
    for (size_t k = 0; k < 3; ++k) v[i + k] *= units.metres;
  }
  for (const uint32_t corner : file.indices)
    for (size_t k = 0; k < 3 && 3 * size_t{corner} + 2 < v.size(); ++k) {
      low[k] = std::min(low[k], v[3 * size_t{corner} + k]);
      high[k] = std::max(high[k], v[3 * size_t{corner} + k]);
    }
  double size = 0, farthest = 0;
  for (size_t k = 0; k < 3; ++k) {
    size = std::max(size, high[k] - low[k]);
    farthest = std::max({farthest, std::fabs(low[k]), std::fabs(high[k])});
  }
  std::vector<std::string> remarks;
  if (farthest * static_cast<double>(std::numeric_limits<float>::epsilon()) * k_steps > size &&
      std::isfinite(farthest)) {
    std::array<double, 3> middle;
    for (size_t k = 0; k < 3; ++k) middle[k] = 0.5 * (low[k] + high[k]);
    for (size_t i = 0; i < v.size(); ++i) v[i] -= middle[i % 3];
    const auto text = [](double x) {
      char buffer[32];
      std::snprintf(buffer, sizeof buffer, "%.9g", x);
      return std::string(buffer);
    };
    remarks.push_back("it stands " + text(farthest) + " m from its origin, too far for its size. It is moved by [" +
                      text(-middle[0]) + ", " + text(-middle[1]) + ", " + text(-middle[2]) + "]");
  }
  MeshResult result = clean_mesh(std::vector<float>(v.begin(), v.end()), file.indices, name);
  if (!result) return result;
  std::string left_out;
  for (const auto& [what, count] : file.left_out)
    left_out += (left_out.empty() ? "" : ", ") + what + " (" + std::to_string(count) + ")";
  if (!left_out.empty()) remarks.push_back("not read of it: " + left_out);
  if (result.report.turned_parts > 0)
    remarks.push_back(std::to_string(result.report.turned_parts) + " of its " + std::to_string(result.report.parts) +
                      " parts were inside out and are turned");
  result.remarks = std::move(remarks);
  return result;
}

}  // namespace sandglass::host

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

namespace {

bool is_off(std::string_view word) {
  const size_t kind = word.find("OFF");
  return kind != std::string_view::npos && word.substr(0, kind).find_first_not_of("STCN4n") == std::string_view::npos;
}

// JSON with an object "asset", which every glTF has.
bool is_gltf(std::string_view text) {
  constexpr std::string_view k_space = " \t\r\n", k_name = "\"asset\"";
  for (size_t at = text.find(k_name); at != std::string_view::npos; at = text.find(k_name, at + 1)) {
    const size_t colon = text.find_first_not_of(k_space, at + k_name.size());
    if (colon == std::string_view::npos || text[colon] != ':') continue;
    const size_t value = text.find_first_not_of(k_space, colon + 1);
    if (value != std::string_view::npos && text[value] == '{') return true;
  }
  return false;
}

// Words that an OBJ may begin with; one of its first lines is a place.
bool is_obj(std::string_view file) {
  constexpr size_t k_lines = 10000;
  Words lines = {file};
  std::string line;
  for (size_t i = 0; i < k_lines && lines.line(&line); ++i) {
    Words words = {line};
    const std::string_view keyword = words.next();
    double number = 0;
    if ((keyword == "v" || keyword == "vn" || keyword == "vt") && number_of(words.next(), &number)) return true;
    if (line.find('\0') != std::string::npos) return false;
  }
  return false;
}

}  // namespace

std::string ends_after(size_t there, size_t told, const char* what) {
  return "ends after " + std::to_string(there) + " of " + std::to_string(told) + " " + what +
         ". Copy or export it again.";
}

MeshFormat mesh_format(std::string_view file) {
  constexpr std::pair<std::string_view, const char*> k_others[] = {{"PK\x03\x04", "a 3MF file or another archive"},
                                                                   {"BLENDER", "a Blender file"},
                                                                   {"#usda", "a USD file"},
                                                                   {"PXR-USDC", "a USD file"},
                                                                   {"xof ", "a DirectX file"},
                                                                   {"ISO-10303-21", "a STEP file"}};
  const std::string_view text = file.substr(std::min(file.find_first_not_of("\xEF\xBB\xBF \t\r\n"), file.size()));
  const std::string_view head = text.substr(0, 4096);
  for (const auto& [magic, name] : k_others)
    if (head.starts_with(magic)) return {MeshFormat::none, std::string("is ") + name};
  if (head.starts_with("glTF")) return {MeshFormat::gltf, ""};
  if (head.starts_with("{")) {
    return is_gltf(text) ? MeshFormat{MeshFormat::gltf, ""} : MeshFormat{MeshFormat::none, "is JSON, but no glTF"};
  }
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return {MeshFormat::ply, ""};
  if (is_off(Words{head}.next())) return {MeshFormat::off, ""};
  if (head.starts_with("Kaydara FBX Binary") || (head.starts_with(";") && head.find("FBX") != std::string_view::npos))
    return {MeshFormat::fbx, ""};
  if (head.starts_with("<")) {
    if (head.find("<COLLADA") != std::string_view::npos) return {MeshFormat::collada, ""};
    return {MeshFormat::none,
            head.find("<amf") != std::string_view::npos ? "is an AMF file" : "is XML, but no Collada"};
  }
  if (is_stl(file)) return {MeshFormat::stl, ""};
  if (is_obj(file)) return {MeshFormat::obj, ""};
  return {MeshFormat::none, "is no kind of mesh that is known here"};
}

std::string read_mesh(MeshFormat::Kind kind, std::string_view file, const FileBeside& beside, FileMesh* mesh) {
  switch (kind) {
    case MeshFormat::gltf:
      return read_gltf(file, beside, mesh);
    case MeshFormat::obj:
      return read_obj(file, mesh);
    case MeshFormat::ply:
      return read_ply(file, mesh);
    case MeshFormat::stl:
      return read_stl(file, mesh);
    case MeshFormat::off:
      return read_off(file, mesh);
    default:
      return "is not read here. Export it as glTF, OBJ, PLY or STL.";
  }
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

// Small mesh files of every kind that people bring, each of one cube of edge 1 about the origin, or of several.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sandglass::tests {

using Json = nlohmann::json;
using Place = std::array<float, 3>;

// Corner number 4 x + 2 y + z, and the faces counter-clockwise seen from outside.
inline const std::vector<Place> k_corners = {{-.5f, -.5f, -.5f}, {-.5f, -.5f, .5f}, {-.5f, .5f, -.5f}, {-.5f, .5f, .5f},
                                             {.5f, -.5f, -.5f},  {.5f, -.5f, .5f},  {.5f, .5f, -.5f},  {.5f, .5f, .5f}};
inline const std::vector<std::array<uint16_t, 4>> k_faces = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                                             {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};

inline std::vector<uint16_t> cube_triangles(uint16_t first = 0, bool inward = false) {
  std::vector<uint16_t> out;
  for (const auto& f : k_faces)
    for (const uint16_t k : {f[0], f[1], f[2], f[0], f[2], f[3]}) out.push_back(static_cast<uint16_t>(first + k));
  for (size_t i = 0; inward && i < out.size(); i += 3) std::swap(out[i], out[i + 1]);
  return out;
}

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers, bool big = false) {
  std::string out;
  for (const Number number : numbers) {
    char bytes[sizeof number];
    std::memcpy(bytes, &number, sizeof number);
    if (big) std::reverse(bytes, bytes + sizeof number);
    out.append(bytes, sizeof number);
  }
  return out;
}
inline std::vector<float> flat(const std::vector<Place>& places) {
  std::vector<float> out;
  for (const Place& p : places) out.insert(out.end(), p.begin(), p.end());
  return out;
}

// A glTF file as it grows. Every method returns the number of what it added.
struct GltfMaker {
  Json file = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", Json::array()}}}},
               {"buffers", Json::array()}};
  std::string buffer;

  size_t add(const char* list, Json item) {
    file[list].push_back(std::move(item));
    return file[list].size() - 1;
  }
  size_t view(const std::string& data, Json more = Json::object()) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    more.update({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", data.size()}});
    buffer += data;
    return add("bufferViews", std::move(more));
  }
  size_t accessor(size_t view, int component, size_t count, const char* type, Json more = Json::object()) {
    more.update({{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return add("accessors", std::move(more));
  }
  size_t floats(const std::vector<float>& numbers, size_t parts, const char* type) {
    return accessor(view(bytes_of(numbers)), 5126, numbers.size() / parts, type);
  }
  size_t places(const std::vector<Place>& at) { return floats(flat(at), 3, "VEC3"); }
  size_t triangles(const std::vector<uint16_t>& corners) {
    return accessor(view(bytes_of(corners)), 5123, corners.size(), "SCALAR");
  }
  size_t mesh(size_t position, size_t indices, Json primitive = Json::object()) {
    primitive["attributes"]["POSITION"] = position;
    primitive["indices"] = indices;
    return add("meshes", {{"primitives", {primitive}}});
  }
  size_t cube() { return mesh(places(k_corners), triangles(cube_triangles())); }
  size_t node(Json what) {
    const size_t number = add("nodes", std::move(what));
    file["scenes"][0]["nodes"].push_back(number);
    return number;
  }
  void require(const char* extension) {
    file["extensionsUsed"].push_back(extension);
    file["extensionsRequired"].push_back(extension);
  }
  std::string gltf(const std::string& uri) {
    Json whole = file;
    const Json own = {{"byteLength", buffer.size()}, {"uri", uri}};
    whole["buffers"].insert(whole["buffers"].begin(), own);
    return whole.dump();
  }
  std::string glb() {
    Json whole = file;
    const Json own = {{"byteLength", buffer.size()}};
    whole["buffers"].insert(whole["buffers"].begin(), own);
    std::string json = whole.dump(), binary = buffer;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    const auto chunk = [](uint32_t kind, const std::string& data) {
      return bytes_of<uint32_t>({static_cast<uint32_t>(data.size()), kind}) + data;
    };
    const std::string chunks = chunk(0x4e4f534a, json) + chunk(0x004e4942, binary);
    return bytes_of<uint32_t>({0x46546c67, 2, static_cast<uint32_t>(12 + chunks.size())}) + chunks;
  }
};

inline std::string obj_places() {
  std::string out;
  for (const Place& p : k_corners)
    out += "v " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  return out;
}
// `behind` stands behind every corner's number.
inline std::string obj_faces(const std::string& behind = "", const std::string& end = "\n") {
  std::string out;
  for (const auto& f : k_faces) {
    out += "f";
    for (const uint16_t k : f) out += " " + std::to_string(k + 1) + behind;
    out += end;
  }
  return out;
}

inline std::string stl_text() {
  std::string out = "solid cube\n";
  const std::vector<uint16_t> corners = cube_triangles();
  for (size_t i = 0; i < corners.size(); ++i) {
    const Place& p = k_corners[corners[i]];
    if (i % 3 == 0) out += "facet normal nan nan nan\nouter loop\n";
    out += "vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    if (i % 3 == 2) out += "endloop\nendfacet\n";
  }
  return out + "endsolid cube\n";
}
inline std::string stl_binary() {
  const std::vector<uint16_t> corners = cube_triangles();
  std::string out = "solid, says its head" + std::string(60, ' ') + bytes_of<uint32_t>({12});
  for (size_t i = 0; i < corners.size(); i += 3)
    out += std::string(12, '\0') +
           bytes_of(flat({k_corners[corners[i]], k_corners[corners[i + 1]], k_corners[corners[i + 2]]})) +
           std::string(2, '\0');
  return out;
}

inline std::string ply_head(const char* format, const char* faces = "face 6\nproperty list uchar int vertex_indices") {
  return std::string("ply\nformat ") + format +
         " 1.0\ncomment made\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement " +
         faces + "\nend_header\n";
}
inline std::string ply_text() {
  std::string out = ply_head("ascii");
  for (const Place& p : k_corners)
    out += std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  for (const auto& f : k_faces)
    out += "4 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " " +
           std::to_string(f[3]) + "\n";
  return out;
}
inline std::string ply_binary(bool big) {
  std::string out = ply_head(big ? "binary_big_endian" : "binary_little_endian") + bytes_of(flat(k_corners), big);
  for (const auto& f : k_faces) out += "\x04" + bytes_of<int32_t>({f[0], f[1], f[2], f[3]}, big);
  return out;
}
inline std::string off_text(const std::string& kind = "OFF\n") {
  std::string out = kind + "8 6 12\n";
  for (const Place& p : k_corners)
    out += std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  for (const auto& f : k_faces)
    out += "4 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " " +
           std::to_string(f[3]) + " 255 0 0\n";
  return out;
}

}  // namespace sandglass::tests

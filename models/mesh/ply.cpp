// See ply.h.
#include "models/mesh/ply.h"

#include <cstdio>
#include <cstring>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

namespace sandglass::host {
namespace {

void append_u32(std::string* bytes, uint32_t x) {
  for (int shift = 0; shift < 32; shift += 8) bytes->push_back(static_cast<char>(x >> shift & 255));
}

void append_floats(std::string* bytes, const std::vector<float>& values) {
  for (float value : values) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    append_u32(bytes, bits);
  }
}

std::string ply_header(size_t vertices, size_t triangles) {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
  if (triangles > 0)
    header += "element face " + std::to_string(triangles) + "\nproperty list uchar uint vertex_indices\n";
  return header + "end_header\n";
}

std::string write_whole_file(const std::string& path, const std::string& bytes) {
  try {
    write_file(path, bytes);
    return "";
  } catch (const Failure& failure) {
    return failure.what();
  }
}

}  // namespace

std::string write_points_ply(const std::string& path, const std::vector<float>& points) {
  std::string bytes = ply_header(points.size() / 3, 0);
  append_floats(&bytes, points);
  return write_whole_file(path, bytes);
}

std::string write_mesh_ply(const std::string& path, const Mesh& mesh) {
  std::string bytes = ply_header(mesh.vertex_count(), mesh.triangle_count());
  append_floats(&bytes, mesh.vertices);
  for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    bytes.push_back(3);
    for (size_t k = 0; k < 3; ++k) append_u32(&bytes, mesh.indices[t + k]);
  }
  return write_whole_file(path, bytes);
}

std::string write_mesh_obj(const std::string& path, const Mesh& mesh) {
  std::string text;
  char line[128];
  for (size_t v = 0; v + 2 < mesh.vertices.size(); v += 3) {
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", static_cast<double>(mesh.vertices[v]),
                  static_cast<double>(mesh.vertices[v + 1]), static_cast<double>(mesh.vertices[v + 2]));
    text += line;
  }
  for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", mesh.indices[t] + 1, mesh.indices[t + 1] + 1,
                  mesh.indices[t + 2] + 1);
    text += line;
  }
  return write_whole_file(path, text);
}

}  // namespace sandglass::host

// Reads mesh files. Assimp parses them. This file also refuses what Assimp lets pass: files that are missing, empty or
// cut off within a line, indices out of range, and coordinates that are not finite. It leaves out points and lines.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/mesh.h"

#ifdef SANDGLASS_HAVE_ASSIMP
#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#endif

namespace sandglass::host {
namespace {

MeshResult fail(const std::string& path, const std::string& sentence) {
  MeshResult result;
  result.error = message("read", path, "it " + sentence);
  return result;
}

#ifdef SANDGLASS_HAVE_ASSIMP

// An OBJ that is cut off within a line still parses, but its last face or vertex is missing. It is known by a last line
// that has no newline and too few words.
bool ends_within_line(const std::string& path, const std::string& content) {
  if (std::filesystem::path(path).extension() != ".obj") return false;
  constexpr size_t k_longest_line = 4096;
  const std::string text = content.substr(content.size() - std::min(content.size(), k_longest_line));
  if (text.empty() || text.back() == '\n') return false;
  const size_t line_start = text.find_last_of('\n');
  std::istringstream line(line_start == std::string::npos ? text : text.substr(line_start + 1));
  std::string keyword, word;
  line >> keyword;
  int words = 0;
  while (line >> word) ++words;
  return (keyword == "f" || keyword == "v" || keyword == "vn") && words < 3;
}

// Gives Assimp the files that it asks for, such as the parts of a glTF. It reads none by itself, so all are ordinary
// files of a bounded size that no output replaces.
class CheckedFiles : public Assimp::IOSystem {
 public:
  bool Exists(const char* path) const override {
    std::error_code error;
    return std::filesystem::is_regular_file(path, error);
  }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* path, const char* mode) override {
    if (mode[0] != 'r' || !Exists(path)) return nullptr;
    const std::string content = read_file(path, "mesh");
    auto* bytes = new uint8_t[content.size()];
    std::memcpy(bytes, content.data(), content.size());
    return new Assimp::MemoryIOStream(bytes, content.size(), true);
  }
  void Close(Assimp::IOStream* file) override { delete file; }
};

std::string first_line(const char* text) {
  const std::string message = text;
  return message.substr(0, message.find('\n'));
}

// Runs before anything else touches the scene, because Assimp's own steps trust the result of its readers.
std::string first_fault(const aiScene& scene) {
  size_t faces = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f)
      for (unsigned k = 0; k < part.mFaces[f].mNumIndices; ++k)
        if (part.mFaces[f].mIndices[k] >= part.mNumVertices)
          return "has a face with an index beyond its vertices. Export it again.";
    for (unsigned v = 0; v < part.mNumVertices; ++v)
      if (!std::isfinite(part.mVertices[v].x) || !std::isfinite(part.mVertices[v].y) ||
          !std::isfinite(part.mVertices[v].z))
        return "has a vertex that is not finite. Repair it in a mesh editor and export it again.";
    faces += part.mNumFaces;
  }
  return faces > 0 ? "" : "has no triangles. Export it as a surface of polygons.";
}

struct Placed {
  const aiNode* node;
  aiMatrix4x4 to_world;
};

MeshResult parse(const std::string& path) {
  Assimp::Importer importer;
  importer.SetIOHandler(new CheckedFiles);  // the importer owns it
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene == nullptr)
    return fail(path, "is no complete mesh (" + first_line(importer.GetErrorString()) + "). Export it again.");
  if (const std::string fault = first_fault(*scene); !fault.empty()) return fail(path, fault);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr)
    return fail(path, "cannot be cut into triangles. Export it triangulated.");

  std::vector<float> vertices;
  std::vector<uint32_t> indices;
  std::vector<Placed> waiting = {{scene->mRootNode, scene->mRootNode->mTransformation}};
  while (!waiting.empty()) {
    const Placed placed = waiting.back();
    waiting.pop_back();
    for (unsigned m = 0; m < placed.node->mNumMeshes; ++m) {
      const aiMesh& part = *scene->mMeshes[placed.node->mMeshes[m]];
      const uint32_t base = static_cast<uint32_t>(vertices.size() / 3);
      for (unsigned v = 0; v < part.mNumVertices; ++v) {
        const aiVector3D p = placed.to_world * part.mVertices[v];
        vertices.insert(vertices.end(), {p.x, p.y, p.z});
      }
      for (unsigned f = 0; f < part.mNumFaces; ++f) {
        const aiFace& face = part.mFaces[f];
        if (face.mNumIndices != 3) continue;  // points and lines have no surface
        for (unsigned k = 0; k < 3; ++k) indices.push_back(base + face.mIndices[k]);
      }
    }
    for (unsigned c = 0; c < placed.node->mNumChildren; ++c)
      waiting.push_back({placed.node->mChildren[c], placed.to_world * placed.node->mChildren[c]->mTransformation});
  }
  return clean_mesh(vertices, indices, path);
}

#endif

}  // namespace

MeshResult load_mesh(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return fail(path, "does not exist. Check the path.");
  if (!std::filesystem::is_regular_file(path, ignored)) return fail(path, "is not a file. Name one mesh file.");
  if (std::filesystem::file_size(path, ignored) == 0) return fail(path, "is empty. Export it again.");
#ifdef SANDGLASS_HAVE_ASSIMP
  try {
    if (ends_within_line(path, read_file(path, "mesh")))
      return fail(path, "is cut off in its last line. Copy or export it again.");
    return parse(path);
  } catch (const Failure& failure) {
    return {{}, {}, failure.what()};
  } catch (const std::exception& e) {
    return fail(path, std::string("is no complete mesh (") + e.what() + "). Export it again.");
  }
#else
  return fail(
      path,
      "is a file, and this build has no mesh reader. Build with Assimp, or use a generated mesh such as trefoil.");
#endif
}

}  // namespace sandglass::host

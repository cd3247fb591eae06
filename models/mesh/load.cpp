// Reads mesh files. Assimp parses them. This file also refuses what Assimp lets pass: files that are missing, empty or
// cut off within a line, indices out of range, and coordinates that are not finite. It leaves out points and lines.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
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

// The triangles as they come, not cleaned.
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

  MeshResult result;
  std::vector<float>& vertices = result.mesh.vertices;
  std::vector<uint32_t>& indices = result.mesh.indices;
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
  return result;
}

// Assimp crashes on some damaged files, so it runs in a process of its own, which sends the triangles through a pipe.
class Sender {
 public:
  explicit Sender(int pipe) : pipe_(pipe) {}
  template <class Item>
  void send(const Item* items, size_t count) {
    put(&count, sizeof count);
    put(items, count * sizeof *items);
  }

 private:
  void put(const void* data, size_t bytes) {
    const char* from = static_cast<const char*>(data);
    while (bytes > 0) {
      const ssize_t written = write(pipe_, from, bytes);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) _exit(1);
      from += written;
      bytes -= static_cast<size_t>(written);
    }
  }
  int pipe_;
};

struct Receiver {
  const std::string& bytes;
  size_t at = 0;
  bool good = true;

  template <class Items>
  void receive(Items* items) {
    size_t count = 0;
    good = good && bytes.size() - at >= sizeof count;
    if (good) std::memcpy(&count, bytes.data() + at, sizeof count), at += sizeof count;
    good = good && count <= (bytes.size() - at) / sizeof(*items)[0];
    if (!good || count == 0) return;
    items->resize(count);
    std::memcpy(items->data(), bytes.data() + at, count * sizeof(*items)[0]);
    at += count * sizeof(*items)[0];
  }
};

[[noreturn]] void parse_and_send(const std::string& path, uint64_t file_bytes, int pipe) {
  const rlimit no_core = {0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // Assimp never returns from some damaged files. Good ones take a tenth of this.
  const rlim_t seconds = 5 + file_bytes / (uint64_t{1} << 20);
  const rlimit some_time = {seconds, seconds};
  setrlimit(RLIMIT_CPU, &some_time);
#if defined(__linux__)
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // elsewhere the limit of time ends it when the program is killed
#endif
  for (const int number : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) std::signal(number, SIG_DFL);
  MeshResult result;
  try {
    result = parse(path);
  } catch (const Failure& failure) {
    result.error = failure.what();
  } catch (const std::exception& e) {
    result = fail(path, std::string("is no complete mesh (") + e.what() + "). Export it again.");
  }
  Sender to(pipe);
  to.send(result.error.data(), result.error.size());
  to.send(result.mesh.vertices.data(), result.mesh.vertices.size());
  to.send(result.mesh.indices.data(), result.mesh.indices.size());
  _exit(0);
}

MeshResult parse_apart(const std::string& path, uint64_t file_bytes) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return fail(path, "cannot be read: there are too many open files. Close some.");
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    return fail(path, "cannot be read: this machine has no room for another process. End some.");
  }
  if (child == 0) parse_and_send(path, file_bytes, ends[1]);
  close(ends[1]);
  std::string bytes;
  char buffer[65536];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) != 0;) {
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) break;
    bytes.append(buffer, static_cast<size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  MeshResult result;
  Receiver from = {bytes};
  from.receive(&result.error);
  from.receive(&result.mesh.vertices);
  from.receive(&result.mesh.indices);
  if (status != 0 || !from.good)
    return fail(path, "is damaged so that the mesh reader did not end well. Export it again.");
  return result.error.empty() ? clean_mesh(result.mesh.vertices, result.mesh.indices, path) : result;
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
    const std::string content = read_file(path, "mesh");
    if (ends_within_line(path, content)) return fail(path, "is cut off in its last line. Copy or export it again.");
    return parse_apart(path, content.size());
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

// FBX and Collada, by Assimp: files with units, whose figures are animated and nested in ways that no page describes.
// They become metres and y up, as the file says. Assimp crashes on some damaged files and never returns from others, so
// it runs in a process of its own, for a bounded time.
#include "models/mesh/readers.h"

#ifdef SANDGLASS_HAVE_ASSIMP
#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/words.h"
#endif

namespace sandglass::host {

namespace {

std::string not_read() { return "is not read here. Export it as " + offered_formats() + "."; }

#ifdef SANDGLASS_HAVE_ASSIMP

// Gives Assimp the files that it asks for, such as the parts of an FBX. It reads none by itself, so all are ordinary
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

// What an FBX says of its units and axes; Assimp leaves both to its user. (It applies those of Collada itself.)
aiMatrix4x4 to_metres_y_up(const aiScene& scene) {
  const auto whole = [&](const char* name, int otherwise) {
    int32_t value = otherwise;
    if (scene.mMetaData != nullptr) scene.mMetaData->Get(name, value);
    return value;
  };
  float as_float = 0;
  double centimetres = 0;
  aiMatrix4x4 matrix;
  if (scene.mMetaData == nullptr || !scene.mMetaData->HasKey("UpAxis")) return matrix;
  if (!scene.mMetaData->Get("UnitScaleFactor", centimetres) && scene.mMetaData->Get("UnitScaleFactor", as_float))
    centimetres = static_cast<double>(as_float);
  const ai_real metres = static_cast<ai_real>(centimetres > 0 ? 0.01 * centimetres : 0.01);
  struct Axis {
    const char *axis, *sign;
    int otherwise;
  };
  constexpr Axis k_axes[] = {
      {"CoordAxis", "CoordAxisSign", 0}, {"UpAxis", "UpAxisSign", 1}, {"FrontAxis", "FrontAxisSign", 2}};
  for (unsigned row = 0; row < 3; ++row) {
    const int column = whole(k_axes[row].axis, k_axes[row].otherwise);
    for (unsigned k = 0; k < 3; ++k) matrix[row][k] = 0;
    if (column < 0 || column > 2) return aiMatrix4x4();
    matrix[row][static_cast<unsigned>(column)] = whole(k_axes[row].sign, 1) < 0 ? -metres : metres;
  }
  return matrix;
}

struct Placed {
  const aiNode* node;
  aiMatrix4x4 to_world;
};

std::vector<Placed> placed_nodes(const aiScene& scene) {
  std::vector<Placed> nodes = {{scene.mRootNode, to_metres_y_up(scene) * scene.mRootNode->mTransformation}};
  for (size_t i = 0; i < nodes.size(); ++i)
    for (unsigned c = 0; c < nodes[i].node->mNumChildren; ++c) {
      const aiNode* child = nodes[i].node->mChildren[c];
      nodes.push_back({child, nodes[i].to_world * child->mTransformation});
    }
  return nodes;
}

// Where the vertices of a mesh are: at its node, or where the bones of its skin stand in the file's own pose.
std::vector<aiVector3D> standing(const aiMesh& part, const Placed& placed, const std::vector<Placed>& nodes) {
  std::vector<aiVector3D> at(part.mNumVertices);
  std::vector<ai_real> weights(part.mNumVertices, 0);
  for (unsigned b = 0; b < part.mNumBones; ++b) {
    const aiBone& bone = *part.mBones[b];
    const auto joint =
        std::find_if(nodes.begin(), nodes.end(), [&](const Placed& p) { return p.node->mName == bone.mName; });
    if (joint == nodes.end()) continue;
    const aiMatrix4x4 to_world = joint->to_world * bone.mOffsetMatrix;
    for (unsigned w = 0; w < bone.mNumWeights; ++w) {
      const aiVertexWeight& weight = bone.mWeights[w];
      if (weight.mVertexId >= part.mNumVertices || !(weight.mWeight > 0)) continue;
      at[weight.mVertexId] += (to_world * part.mVertices[weight.mVertexId]) * weight.mWeight;
      weights[weight.mVertexId] += weight.mWeight;
    }
  }
  for (unsigned v = 0; v < part.mNumVertices; ++v)
    at[v] = weights[v] > 0 ? at[v] / weights[v] : placed.to_world * part.mVertices[v];
  return at;
}

std::string parse(const std::string& path, FileMesh* mesh) {
  Assimp::Importer importer;
  importer.SetIOHandler(new CheckedFiles);  // the importer owns it
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene == nullptr) return "is no complete mesh (" + first_line(importer.GetErrorString()) + "). Export it again.";
  if (const std::string fault = first_fault(*scene); !fault.empty()) return fault;
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) return "cannot be cut into triangles. Export it triangulated.";
  const std::vector<Placed> nodes = placed_nodes(*scene);
  unsigned shapes = 0;
  for (const Placed& placed : nodes) {
    const bool is_mirrored = placed.to_world.Determinant() < 0;
    for (unsigned m = 0; m < placed.node->mNumMeshes; ++m) {
      const aiMesh& part = *scene->mMeshes[placed.node->mMeshes[m]];
      const uint32_t base = static_cast<uint32_t>(mesh->vertices.size() / 3);
      shapes += part.mNumAnimMeshes;
      for (const aiVector3D& p : standing(part, placed, nodes))
        mesh->vertices.insert(mesh->vertices.end(),
                              {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
      for (unsigned f = 0; f < part.mNumFaces; ++f) {
        const aiFace& face = part.mFaces[f];
        if (face.mNumIndices != 3) continue;  // points and lines have no surface
        for (unsigned k = 0; k < 3; ++k) mesh->indices.push_back(base + face.mIndices[is_mirrored ? 2 - k : k]);
      }
    }
  }
  for (const auto& [what, count] : {std::pair("animations", scene->mNumAnimations),
                                    {"lights", scene->mNumLights},
                                    {"cameras", scene->mNumCameras},
                                    {"shapes that morph it", shapes}})
    if (count > 0) mesh->left_out[what] = count;
  return "";
}

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
    if (good) {
      std::memcpy(&count, bytes.data() + at, sizeof count);
      at += sizeof count;
    }
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
  // Good files take a tenth of this.
  const rlim_t seconds = 5 + file_bytes / (uint64_t{1} << 20);
  const rlimit some_time = {seconds, seconds};
  setrlimit(RLIMIT_CPU, &some_time);
#if defined(__linux__)
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // elsewhere the limit of time ends it when the program is killed
#endif
  for (const int number : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) std::signal(number, SIG_DFL);
  FileMesh mesh;
  std::string error;
  try {
    error = parse(path, &mesh);
  } catch (const std::exception& e) {
    error = std::string("is no complete mesh (") + e.what() + "). Export it again.";
  }
  std::string left_out;
  for (const auto& [what, count] : mesh.left_out) left_out += what + " " + std::to_string(count) + " ";
  Sender to(pipe);
  to.send(error.data(), error.size());
  to.send(left_out.data(), left_out.size());
  to.send(mesh.vertices.data(), mesh.vertices.size());
  to.send(mesh.indices.data(), mesh.indices.size());
  _exit(0);
}

std::string read_by_assimp(const MeshSource& source, FileMesh* mesh) {
  if (source.path.empty()) return not_read();
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return "cannot be read: there are too many open files. Close some.";
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    return "cannot be read: this machine has no room for another process. End some.";
  }
  if (child == 0) parse_and_send(source.path, source.file.size(), ends[1]);
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
  std::string error, left_out;
  Receiver from = {bytes};
  from.receive(&error);
  from.receive(&left_out);
  from.receive(&mesh->vertices);
  from.receive(&mesh->indices);
  if (status != 0 || !from.good) return "is damaged so that its reader did not end well. Export it again.";
  Words words = {left_out};
  for (std::string_view what = words.next(); !what.empty(); what = words.next())
    mesh->left_out[std::string(what)] = std::strtoul(std::string(words.next()).c_str(), nullptr, 10);
  return error;
}

#else

std::string read_by_assimp(const MeshSource&, FileMesh*) { return not_read(); }

#endif

Likeness likeness_to_fbx(std::string_view, std::string_view text) {
  const bool is_text = text.starts_with(";") && text.find("FBX") != std::string_view::npos;
  return is_text || text.starts_with("Kaydara FBX Binary") ? Likeness::sure : Likeness::none;
}

Likeness likeness_to_collada(std::string_view, std::string_view text) {
  return text.starts_with("<") && text.find("<COLLADA") != std::string_view::npos ? Likeness::sure : Likeness::none;
}

}  // namespace

extern const MeshFormat k_fbx = {"FBX", ".fbx", false, likeness_to_fbx, read_by_assimp};
extern const MeshFormat k_collada = {"Collada", ".dae", false, likeness_to_collada, read_by_assimp};

}  // namespace sandglass::host

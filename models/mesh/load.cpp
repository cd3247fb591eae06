// Mesh files of the program.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/readers.h"

namespace sandglass::host {

// A size that is rarely meant.
static void remark_size(MeshResult* result) {
  constexpr double k_small = 0.01, k_large = 20;  // metres
  const double size = box_of(result->mesh).longest_side();
  if (size >= k_small && size <= k_large) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "its longest side has %.3g m. If that is wrong, say its unit with --scale, such as 0.001 for millimetres", size);
  result->remarks.emplace_back(text);
}

MeshResult load_mesh(const MeshFile& file) {
  const std::string& path = file.path;
  const auto fail = [&](const std::string& sentence) {
    MeshResult result;
    result.error = message("read", path, "it " + sentence);
    return result;
  };
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return fail("does not exist. Check the path.");
  if (!std::filesystem::is_regular_file(path, ignored)) return fail("is not a file. Name one mesh file.");
  if (std::filesystem::file_size(path, ignored) == 0) return fail("is empty. Export it again.");
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const FileBeside beside = [&](const std::string& name, std::string* content) {
    const std::string other = (folder / name).string();
    if (name.empty() || !std::filesystem::is_regular_file(other, ignored)) return false;
    *content = read_file(other, "mesh");
    return true;
  };
  try {
    const std::string content = read_file(path, "mesh");
    FileMesh mesh;
    if (const std::string error = read_mesh({content, beside, path}, &mesh); !error.empty()) return fail(error);
    MeshResult result = finished_mesh(std::move(mesh), file.units, path);
    if (result) remark_size(&result);
    return result;
  } catch (const Failure& failure) {
    MeshResult result;
    result.error = failure.what();
    return result;
  } catch (const std::bad_alloc&) {
    return fail("has too many vertices for this machine's memory. Simplify it.");
  }
}

MeshResult load_mesh_for_command(const MeshFile& file) {
  MeshResult loaded = load_mesh(file);
  if (!loaded) throw Failure(loaded.error);
  for (const std::string& remark : loaded.remarks)
    std::fprintf(stderr, "sandglass: note: \"%s\": %s.\n", file.path.c_str(), remark.c_str());
  return loaded;
}

}  // namespace sandglass::host

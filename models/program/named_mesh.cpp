// The mesh that a command line names.
#include <filesystem>

#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/program/commands.h"
#include "models/program/nearest_name.h"

namespace sandglass::host {

MeshResult named_mesh(const std::string& name_or_file) {
  MeshResult result = make_named(name_or_file);
  if (result) return result;
  if (std::error_code error; !std::filesystem::exists(name_or_file, error))
    throw cannot("find", name_or_file, "no file and no generated mesh has this name",
                 "Name a mesh file, or " + list_of(mesh_names(), "or"));
  result = load_mesh(name_or_file);
  if (!result) throw Failure(result.error);
  return result;
}

}  // namespace sandglass::host

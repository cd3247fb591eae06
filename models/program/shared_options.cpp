// What several commands have in common on the command line.
#include <filesystem>

#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/program/command_line.h"
#include "models/program/command_mistakes.h"
#include "models/program/commands.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

constexpr uint32_t k_most_threads = 256;

Option& add_threads(Command& command, uint32_t& threads) {
  return command.add("--threads N", threads, "Threads; the result does not depend on them")
      .checked(whole_number(1, k_most_threads));
}

Option& add_thread_counts(Command& command, std::vector<uint32_t>& threads) {
  return command.add("--threads LIST", threads, "Thread counts, separated by commas")
      .separated_by(',')
      .checked(whole_number(1, k_most_threads));
}

Option& add_isa(Command& command, std::string& isa) {
  std::vector<std::string> names;
  for (sandglass_isa i = SANDGLASS_ISA_AUTOMATIC; i <= SANDGLASS_ISA_NEON_I8MM; ++i)
    if (const char* name = sandglass_isa_name(i); name != nullptr) names.emplace_back(name);
  return command.add("--isa NAME", isa, "Instruction set of the kernels").checked(one_of(names));
}

Option& add_json(Command& command, std::string& file) {
  return command.add("--json FILE", file, "Write the measurements to this file, as JSON");
}

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

// The commands of the program, each from its own file, and what several of them take in the same words.
#pragma once

#include <string>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/program/command_line.h"

namespace sandglass::host {

Command run_command();
Command budget_command();
Command light_command();
Command inspect_command();
Command bake_command();
Command sample_command();
Command room_command();
Command dataset_command();
Command light_features_command();

using Options = std::vector<CommandOption>;

constexpr const char* k_bake_help = "Train the soft shadow of a mesh";
constexpr const char* k_shipped = "the shipped one";
constexpr const char* k_scene = "the scene's";
constexpr const char* k_scene_argument = "Scene file, or the name of a shipped scene";
constexpr const char* k_body_mesh = "Mesh of the scene's bodies of shape \"mesh\"";

// What --scale and --up say of mesh files.
struct MeshOptions {
  double scale = 1.0;
  std::string up = "y";
  MeshUnits units() const { return {scale, up == "z"}; }
};

inline CommandOption output(std::string& file, const char* type, const char* help) {
  return required({"-o,--output", &file, type, help});
}
inline CommandOption output_file(std::string& file, const char* help) { return writes(output(file, "FILE", help)); }

inline CommandOption scale_option(MeshOptions& o) {
  return {"--scale", &o.scale, "METRES", "Metres of a mesh file's unit, such as 0.001 for millimetres",
          number(1e-9, 1e9)};
}
inline CommandOption up_option(MeshOptions& o) {
  return {"--up", &o.up, "AXIS", "Which axis of a mesh file points up", one_of({"y", "z"})};
}

}  // namespace sandglass::host

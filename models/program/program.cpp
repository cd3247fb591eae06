// The program `sandglass`: its commands, in the order of the help. What a command takes, and does, is in its own file.
#include "models/program/commands.h"

namespace sandglass::host {

#ifndef SANDGLASS_HAVE_BAKE
Command bake_command() { return {"bake", k_bake_help, {}, {}, {}, k_no_ray_tracer}; }
#endif

static std::vector<CommandGroup> commands() {
  return {{"Run and look", {run_command(), budget_command(), light_command(), inspect_command()}},
          {"Make what an app loads", {bake_command(), sample_command()}},
          {"Train the lighting network", {room_command(), dataset_command(), light_features_command()}}};
}

}  // namespace sandglass::host

int main(int argc, char** argv) {
  using namespace sandglass::host;
  return run_program({"sandglass", "Sandglass: sand, light and shadow inside a fixed slice of every frame",
                      "run demo --out out", commands()},
                     argc, argv);
}

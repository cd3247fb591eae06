// The command-line program. Bad input of any kind ends here as one sentence on stderr and exit code 2.
#include <cstdio>
#include <exception>
#include <new>

#include "models/program/command_line.h"
#include "models/program/commands.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

namespace {

std::string version() {
  return "sandglass " + std::to_string(SANDGLASS_VERSION_MAJOR) + "." + std::to_string(SANDGLASS_VERSION_MINOR) + "." +
         std::to_string(SANDGLASS_VERSION_PATCH);
}

void add_commands(Command& program) {
  const char* look = "Run and look";
  add_run_command(program, look);
  add_view_command(program, look);
  add_light_command(program, look);
  add_inspect_command(program, look);
  const char* make = "Make what an app loads";
#ifdef SANDGLASS_HAVE_BAKE
  add_bake_command(program, make);
#else
  program.add_command("bake", "Train the soft shadow of a mesh", make)
      .is_left_out("this build has no ray tracer", "Install Embree and Eigen, configure and build again.");
#endif
  add_sample_command(program, make);
  const char* train = "Train the lighting network";
  add_room_command(program, train);
  add_dataset_command(program, train);
  add_light_features_command(program, train);
  add_quantise_light_command(program, train);
  add_ceiling_command(program, train);
  const char* measure = "Measure and check";
  add_bench_command(program, measure);
  add_verify_command(program, measure);
}

}  // namespace

}  // namespace sandglass::host

int main(int argc, char** argv) {
  using namespace sandglass::host;
  Command program(nullptr, "", "Sandglass: sand, light and shadow inside a fixed slice of every frame");
  add_commands(program);
  try {
    return run_command_line(program, version(), argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("sandglass: cannot go on: this machine has too little memory for what was asked. Ask for less.\n",
               stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sandglass: %s\n", error.what());
  }
  return k_exit_bad_input;
}

// The command-line program. Bad input of any kind ends here as one sentence on stderr and exit code 2.
#include <cstdio>
#include <exception>
#include <new>

#include "models/cli/commands.h"
#include "models/cli/options.h"
#include "models/cli/sample.h"
#include "models/host/failure.h"
#include "sandglass/sandglass.h"

int main(int argc, char** argv) {
  using namespace sandglass::host;
  constexpr int k_exit_bad_input = 2;
  int exit_code = 0;
  Program program(
      "Sandglass: sand inside a fixed slice of every frame", "sandglass",
      std::to_string(SANDGLASS_VERSION_MAJOR) + "." + std::to_string(SANDGLASS_VERSION_MINOR) + "." +
          std::to_string(SANDGLASS_VERSION_PATCH),
      "Exit codes: 0 done, 1 a check failed, 2 bad input or usage, 130 interrupted.\nTry: sandglass run demo "
      "--out out");
  add_run_command(program, &exit_code);
  add_view_command(program, &exit_code);
  add_sample_command(program, &exit_code);
#ifdef SANDGLASS_HAVE_BAKE
  add_bake_command(program, &exit_code);
#endif
  add_bench_command(program, &exit_code);
  add_verify_command(program, &exit_code);
  add_inspect_command(program, &exit_code);
  add_room_command(program, &exit_code);
  add_dataset_command(program, &exit_code);
  add_ceiling_command(program, &exit_code);
  add_light_command(program, &exit_code);
  add_quantise_light_command(program, &exit_code);
  add_light_features_command(program, &exit_code);
  try {
    program.run(argc, argv);
    return exit_code;
  } catch (const std::bad_alloc&) {
    std::fputs("sandglass: this machine has too little memory for what was asked; make the scene smaller\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sandglass: %s\n", error.what());
  }
  return k_exit_bad_input;
}

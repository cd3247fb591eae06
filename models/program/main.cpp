// The command-line program. Bad input of any kind ends here as one sentence on stderr and exit code 2.
#include <cstdio>
#include <exception>
#include <new>

#include "models/program/command_help.h"
#include "models/program/command_mistakes.h"
#include "models/program/commands.h"
#include "models/program/option_values.h"
#include "sandglass/sandglass.h"

int main(int argc, char** argv) {
  using namespace sandglass::host;
  CLI::App program("Sandglass: sand, light and shadow inside a fixed slice of every frame", "sandglass");
  program.set_version_flag("--version", "sandglass " + std::to_string(SANDGLASS_VERSION_MAJOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_MINOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_PATCH));
  program.set_help_flag("-h,--help", "Print this help");
  program.option_defaults()->always_capture_default()->disable_flag_override();
  program.require_subcommand(0, 1);
  int exit_code = k_exit_done;
  add_commands(program, &exit_code);
  format_help(program);
  try {
    parse_command_line(program, argc, argv);
    if (program.get_subcommands().empty()) std::fputs(program.help().c_str(), stdout);
    return exit_code;
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const std::bad_alloc&) {
    std::fputs("sandglass: cannot go on: this machine has too little memory for what was asked. Ask for less.\n",
               stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sandglass: %s\n", error.what());
  }
  return k_exit_bad_input;
}

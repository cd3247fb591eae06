// The command-line program. Bad input of any kind ends here as one sentence on stderr and exit code 2.
#include <cstdio>
#include <exception>
#include <new>

#include "models/program/command_line.h"
#include "models/program/commands.h"

int main(int argc, char** argv) {
  using namespace sandglass::host;
  try {
    return run_command_line(commands(), argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("sandglass: cannot go on: this machine has too little memory for what was asked. Ask for less.\n",
               stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sandglass: %s\n", error.what());
  }
  return k_exit_bad_input;
}

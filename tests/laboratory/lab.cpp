// The program `sandglass_lab`: whether the library is as accurate as it claims, and how fast, on anybody's data and seeds.
#include "models/program/command_line.h"

namespace sandglass::host {
#define SUITE(command, name) Command command##_##name##_suite();
#include "tests/laboratory/suites.inc"
#undef SUITE
}  // namespace sandglass::host

int main(int argc, char** argv) {
  using namespace sandglass::host;
  Command verify = {"verify", "Check every claim of accuracy; exit code 1 if one fails", {}, {}};
  Command bench = {"bench", "Measure the speed of this machine, with the errors of the same run", {}, {}};
#define SUITE(command, name) command.suites.push_back(command##_##name##_suite());
#include "tests/laboratory/suites.inc"
#undef SUITE
  return run_program({"sandglass_lab",
                      "Sandglass's laboratory: accuracy, and speed beside it",
                      "verify granular --quick",
                      {{"Measure and check", {verify, bench}}}},
                     argc, argv);
}

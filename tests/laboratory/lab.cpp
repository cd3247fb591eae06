// The program `sandglass_lab`: whether the library is as accurate as it claims, and how fast, on anybody's data and seeds.
#include "tests/laboratory/bench.h"
#include "tests/laboratory/verify.h"

int main(int argc, char** argv) {
  using namespace sandglass::host;
  const Command verify = {"verify", "Check every claim of accuracy; exit code 1 if one fails", {}, {}, verify_suites()};
  const Command bench = {
      "bench", "Measure the speed of this machine, with the errors of the same run", {}, {}, bench_suites()};
  return run_program({"sandglass_lab",
                      "Sandglass's laboratory: accuracy, and speed beside it",
                      "verify granular --quick",
                      {{"Measure and check", {verify, bench}}}},
                     argc, argv);
}

// How CLI11 prints the help: of each option its unit, range and default; of the program and of `bench` and `verify`
// what stands below them.
#pragma once

namespace CLI {
class App;
}

namespace sandglass::host {

void format_help(CLI::App& program);

}  // namespace sandglass::host

// Reads the command line with CLI11, and adds what that lacks: the first wrong word in the order typed is named, with
// the nearest right one.
#pragma once

namespace CLI {
class App;
}

namespace sandglass::host {

// Runs the command that is asked for. A wrong command line is a Failure; before it nothing runs.
void parse_command_line(CLI::App& program, int argc, char** argv);

}  // namespace sandglass::host

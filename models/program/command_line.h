// The commands of a program as data: what each takes on the command line, and which function it runs.
// command_line.cpp gives them to CLI11. No other source includes CLI11, because it is slow to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace sandglass::host {

// Bad input, a Failure, is the program's exit code 2.
constexpr int k_exit_done = 0, k_exit_check_failed = 1, k_exit_bad_input = 2, k_exit_interrupted = 130;

// What the text of a value must be. `range` is for the help, "1 to 256"; `wanted` for messages, "a whole number from 1
// to 256".
struct ValueRule {
  std::function<bool(const std::string&)> holds;  // empty: any text
  std::string range, wanted;
};
ValueRule whole_number(uint64_t low, uint64_t high);
ValueRule number(double low, double high);
ValueRule one_of(const std::vector<std::string>& names);

// Where a value goes. What is there before is the default. A flag is a bool.
using OptionTarget = std::variant<bool*, int*, uint32_t*, uint64_t*, double*, std::string*, std::vector<uint32_t>*,
                                  std::vector<std::string>*>;

struct CommandOption {
  const char* names;  // "-o,--output"; an argument's name has no minus: "SCENE"
  OptionTarget target;
  const char* type;  // what stands for the value in the help: "FILE"; of flags and arguments ""
  std::string help;
  ValueRule rule = {};
  const char* standard = nullptr;                    // the default as the help says it; null: the target's
  const char *needs = nullptr, *excludes = nullptr;  // other options of the command
  bool required = false, by_commas = false;          // by_commas: the values of a list are separated by commas
  // Of a value that the command writes: a file; or a folder, which is new or empty, and of which the command gets
  // another name until its work is done (output_folder.h). `partly`: a folder that Ctrl-C leaves shorter, but whole.
  enum class Output { none, file, folder, partly } output = Output::none;
};
CommandOption required(CommandOption option);
CommandOption standard(const char* text, CommandOption option);
CommandOption by_commas(CommandOption option);
CommandOption writes(CommandOption option);
CommandOption fills(CommandOption option);
CommandOption fills_partly(CommandOption option);
CommandOption needs(const char* other, CommandOption option);
CommandOption excludes(const char* other, CommandOption option);

// Options that several commands have in the same words.
CommandOption threads_option(uint32_t& threads);
CommandOption isa_option(std::string& isa);
CommandOption json_option(std::string& file);
CommandOption seed_option(uint64_t& seed, const char* help);

struct Command {
  std::string name, help;
  std::vector<CommandOption> options;
  std::function<int()> run;  // gives the program's exit code
  std::vector<Command> suites = {};
  std::string left_out = {};  // why it is not in this build, and what to do; then it takes any words, and says that
};
struct CommandGroup {
  const char* name;
  std::vector<Command> commands;
};

// The Options live as long as the command.
template <class Options>
Command command(const char* name, const char* help, std::vector<CommandOption> (*options)(Options&),
                std::function<int(const Options&)> run) {
  const auto values = std::make_shared<Options>();
  return {name, help, options(*values), [=] { return run(*values); }};
}

struct Program {
  const char *name, *help, *begin_with;  // begin_with: what somebody who is new types first
  std::vector<CommandGroup> groups;
};

// All of main(): runs the command that is asked for and returns the exit code. Bad input of any kind ends as one
// sentence on stderr.
int run_program(const Program& program, int argc, char** argv);

// What a command that needs Embree says where that is missing.
constexpr const char* k_no_ray_tracer =
    "this build has no ray tracer. Install Embree and Eigen, configure and build again.";

}  // namespace sandglass::host

// The commands of the program and their options as data, and how a command line is read against them. A wrong command
// line is a Failure that names the first wrong word in the order typed, and the nearest right one. Nothing runs before
// the whole line is right.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sandglass::host {

// What a value must be.
struct Check {
  std::string range;                              // as the help shows it: "1 to 256"
  std::string wanted;                             // as a message says it: "a whole number from 1 to 256"
  std::function<bool(const std::string&)> holds;  // without one every text does
  std::vector<std::string> names;                 // of one_of
};
Check whole_number(uint64_t low, uint64_t high);
Check number(double low, double high);
Check number_above_zero();
Check one_of(std::vector<std::string> names);

// An option, or an argument: a word without a name, such as the scene of `run`.
struct Option {
  std::vector<std::string> names;  // "-o", "--output"; of an argument the word in capitals that stands for it
  std::string value_word;          // "FILE"; empty for a flag
  std::string help;
  std::string default_text;
  Check check;
  bool is_required = false;
  uint32_t least_values = 1, most_values = 1;  // both 0: a flag
  char separator = '\0';                       // between the values in one word
  std::vector<const Option*> excluded, needed;
  std::function<void(const std::string& text)> take;  // stores one value
  uint32_t taken = 0;                                 // values on the command line; of a flag how often it stands there

  bool is_argument() const { return names[0][0] != '-'; }
  const std::string& name() const { return names.back(); }

  Option& required();
  Option& checked(const Check& check);
  // What is taken without the option, where the variable's value does not say it.
  Option& by_default(const std::string& text);
  Option& separated_by(char separator);
  Option& values(uint32_t count);
  Option& excludes(Option& other);
  Option& needs(Option& other);
};

class Command {
 public:
  Command(const Command* parent, const std::string& name, const std::string& help);

  // A command below this one. `group` is the heading that it stands under in the help.
  Command& add_command(const std::string& name, const std::string& help, const std::string& group = "");

  // `words`: "--frames N", "-o,--output FILE", or "SCENE", an argument. Value: std::string, uint32_t, uint64_t, int,
  // double, or a vector of strings, uint32_t or double, which takes several values.
  template <class Value>
  Option& add(const std::string& words, Value& value, const std::string& help);
  Option& add_flag(const std::string& name, bool& value, const std::string& help);

  // What the command does; returns the exit code.
  void runs(std::function<int()> action) { action_ = std::move(action); }
  // The command is left out of this build: whatever its options, it says so. `remedy` says what to do.
  void is_left_out(const std::string& why, const std::string& remedy);

  const std::string& name() const { return name_; }
  const std::string& help() const { return help_; }
  const std::string& group() const { return group_; }
  std::string path() const;  // "bench granular"
  const Command* parent() const { return parent_; }
  std::span<const std::unique_ptr<Command>> commands() const { return commands_; }
  std::span<const std::unique_ptr<Option>> options() const { return options_; }
  Option* find_option(const std::string& name) const;

 private:
  friend class CommandLineReader;

  Option& add_option(const std::string& words, const std::string& help);

  const Command* parent_;
  std::string name_, help_, group_;
  std::vector<std::unique_ptr<Command>> commands_;
  std::vector<std::unique_ptr<Option>> options_;
  std::function<int()> action_;
  bool is_left_out_ = false;
};

// Runs what the command line asks for and returns the exit code. `--help` of any command prints its help, `--version`
// of the program `version`.
int run_command_line(Command& program, const std::string& version, int argc, char** argv);

}  // namespace sandglass::host

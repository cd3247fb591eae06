// The options of a sub-command: what the program uses of CLI11, by the same names. CLI11 is headers alone, and takes
// longer to compile than any sub-command; this way it is compiled once, in options.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace sandglass::host {

// What a value must be: between two numbers, or one of a list.
struct Check {
  std::shared_ptr<const CLI::Validator> validator;
};
Check range(uint32_t low, uint32_t high);
Check range(int low, int high);
Check range(double low, double high);
Check one_of(std::initializer_list<const char*> values);
Check one_of(const std::vector<std::string>& values);
Check one_of(std::initializer_list<uint32_t> values);

// Handles, used like the pointers that CLI11 gives; what they stand for lives as long as the Program.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* operator->() { return this; }

  Option required();
  Option check(const Check& check);
  Option capture_default_str();
  Option delimiter(char between);
  Option expected(int values);
  Option excludes(const Option& other);
  Option needs(const Option& other);
  bool given() const;  // on the command line, once that is read

 private:
  CLI::Option* option_;
};

// An option and the cases of its command that use it; without a case, all do.
struct OptionUse {
  const char* option;
  std::vector<const char*> cases;
};

class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}
  Command* operator->() { return this; }

  Command add_subcommand(const std::string& name, const std::string& help);
  Command add_option_group(const std::string& name);

  // Value: std::string, uint32_t, uint64_t, int, double, or a vector of strings, uint32_t or double.
  template <class Value>
  Option add_option(const std::string& name, Value& value, const std::string& help);
  Option add_option_function(const std::string& name, std::function<void(uint32_t)> function, const std::string& help);
  Option add_flag(const std::string& name, bool& value, const std::string& help);
  Option add_flag_callback(const std::string& name, std::function<void()> function, const std::string& help);

  void require_option(int count);
  void allow_extras();
  void callback(std::function<void()> run);
  // When the command runs its case `chosen`: a Failure for an option on the command line that this case does not use,
  // rather than an answer to something else than what was asked. Every option of the command is in the table.
  void refuse_unused(const std::string& chosen, const std::vector<OptionUse>& table) const;

 protected:
  CLI::App* app_;
};

class Program : public Command {
 public:
  Program(const std::string& help, const std::string& name, const std::string& version, const std::string& footer);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Runs what the command line asks for. A wrong command line is a Failure; otherwise throws what the sub-command
  // throws.
  void run(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> owned_;
};

}  // namespace sandglass::host

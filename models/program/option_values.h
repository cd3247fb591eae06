// What the values of options must be, and the options that several commands have in the same words.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sandglass::host {

// `range` is for the help, "1 to 256"; `wanted` for messages, "a whole number from 1 to 256".
CLI::Validator value_that(std::function<bool(const std::string&)> holds, const std::string& range,
                          const std::string& wanted);
CLI::Validator whole_number(uint64_t low, uint64_t high);
CLI::Validator number(double low, double high);
CLI::Validator one_of(const std::vector<std::string>& names);

// `type` is what stands for the value in the help.
template <class Value>
CLI::Option* add_option(CLI::App* command, const char* name, Value& value, const char* type, const char* help) {
  return command->add_option(name, value, help)->type_name(type);
}
CLI::Option* add_threads(CLI::App* command, uint32_t& threads);
CLI::Option* add_isa(CLI::App* command, std::string& isa);
CLI::Option* add_json(CLI::App* command, std::string& file);
CLI::Option* add_seed(CLI::App* command, uint64_t& seed, const char* help);

// `function` runs when the command does, and gives the program's exit code. The options that it returns live as long as
// the command.
template <class Options>
Options& options_of(CLI::App* command, int* exit_code, int (*function)(const Options&)) {
  const auto options = std::make_shared<Options>();
  command->callback([=] { *exit_code = function(*options); });
  return *options;
}

// The command is not in this build: whatever its options, it says so. `remedy` says what to do.
void leave_out(CLI::App* command, const std::string& why, const std::string& remedy);

void add_commands(CLI::App& program, int* exit_code);  // command_options.cpp
void add_bench(CLI::App* bench, int* exit_code);       // suite_options.cpp
void add_verify(CLI::App* verify, int* exit_code);

}  // namespace sandglass::host

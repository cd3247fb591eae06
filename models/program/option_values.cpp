#include "models/program/option_values.h"

#include <algorithm>
#include <cstdio>

#include "models/files/failure.h"
#include "models/program/nearest_name.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

CLI::Validator value_that(std::function<bool(const std::string&)> holds, const std::string& range,
                          const std::string& wanted) {
  return CLI::Validator(
      [=](std::string& text) { return holds(text) ? std::string() : in_quotes(text) + " is not " + wanted + "."; },
      range);
}

// CLI11 itself reads -1 as 2^64 - 1 and 010 as 8.
CLI::Validator whole_number(uint64_t low, uint64_t high) {
  const bool open = high == UINT64_MAX;
  const std::string range = std::to_string(low) + " to " + (open ? "2^64 - 1" : std::to_string(high));
  const auto holds = [=](const std::string& text) {
    uint64_t value = 0;
    return CLI::detail::lexical_cast(text, value) && std::to_string(value) == text && value >= low && value <= high;
  };
  return value_that(holds, open ? "" : range, "a whole number from " + range);
}

// CLI::Range compares so that NaN is in every range.
CLI::Validator number(double low, double high) {
  char range[64];
  std::snprintf(range, sizeof range, "%.9g to %.9g", low, high);
  const auto holds = [=](const std::string& text) {
    double value = 0.0;
    return CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
  };
  return value_that(holds, range, std::string("a number from ") + range);
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  const std::string all = list_of(names, "or");
  return CLI::Validator(
      [=](std::string& text) {
        if (std::find(names.begin(), names.end(), text) != names.end()) return std::string();
        return in_quotes(text) + " is not " + all + "." + suggestion(text, names);
      },
      all);
}

CLI::Option* add_threads(CLI::App* command, uint32_t& threads) {
  constexpr uint64_t k_most = 256;
  return add_option(command, "--threads", threads, "N", "Threads; the result does not depend on them")
      ->check(whole_number(1, k_most));
}

CLI::Option* add_isa(CLI::App* command, std::string& isa) {
  std::vector<std::string> names;
  for (sandglass_isa i = SANDGLASS_ISA_AUTOMATIC; i <= SANDGLASS_ISA_NEON_I8MM; ++i)
    if (const char* name = sandglass_isa_name(i); name != nullptr) names.emplace_back(name);
  return add_option(command, "--isa", isa, "NAME", "Instruction set of the kernels")->check(one_of(names));
}

CLI::Option* add_json(CLI::App* command, std::string& file) {
  return add_option(command, "--json", file, "FILE", "Write the measurements to this file, as JSON");
}

CLI::Option* add_seed(CLI::App* command, uint64_t& seed, const char* help) {
  return command->add_option("--seed", seed, help)->type_name("N")->check(whole_number(0, UINT64_MAX));
}

void leave_out(CLI::App* command, const std::string& why, const std::string& remedy) {
  command->description(command->get_description() + " (not in this build)")->allow_extras();
  const CLI::App* above = command->get_parent();
  const std::string name = (above->get_parent() == nullptr ? "" : above->get_name() + " ") + command->get_name();
  command->callback([=] { throw Failure("cannot run \"" + name + "\": " + why + ". " + remedy); });
}

}  // namespace sandglass::host

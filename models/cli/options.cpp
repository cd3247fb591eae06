#include "models/cli/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <type_traits>

#include "models/host/failure.h"

namespace sandglass::host {

namespace {

template <class Validator>
Check make(const Validator& validator) {
  return {std::make_shared<const CLI::Validator>(validator)};
}

// CLI11 reads -1 as the largest number of 64 bits, and one beyond that, too.
Check whole_number() {
  return make(CLI::Validator(
      [](std::string& value) {
        char* end = nullptr;
        errno = 0;
        std::strtoull(value.c_str(), &end, 0);
        const bool good = std::isdigit(static_cast<unsigned char>(value[0])) != 0 && *end == '\0' && errno == 0;
        return good ? std::string() : "'" + value + "' is not a whole number from 0 to 2^64 - 1";
      },
      "UINT"));
}

}  // namespace

Check range(uint32_t low, uint32_t high) { return make(CLI::Range(low, high)); }
Check range(int low, int high) { return make(CLI::Range(low, high)); }
// CLI11's own Range compares so that NaN is in every range.
Check range(double low, double high) {
  const std::string text = "FLOAT in [" + CLI::detail::to_string(low) + " - " + CLI::detail::to_string(high) + "]";
  return make(CLI::Validator(
      [low, high, text](std::string& value) {
        double number = 0.0;
        const bool inside = CLI::detail::lexical_cast(value, number) && number >= low && number <= high;
        return inside ? std::string() : "'" + value + "' is not a " + text;
      },
      text));
}
Check one_of(std::initializer_list<const char*> values) {
  return make(CLI::IsMember(std::vector<std::string>(values.begin(), values.end())));
}
Check one_of(const std::vector<std::string>& values) { return make(CLI::IsMember(values)); }
Check one_of(std::initializer_list<uint32_t> values) {
  std::vector<std::string> texts;
  for (const uint32_t value : values) texts.push_back(std::to_string(value));
  return one_of(texts);
}

Option Option::required() { return Option(option_->required()); }
Option Option::check(const Check& check) { return Option(option_->check(*check.validator)); }
Option Option::capture_default_str() { return Option(option_->capture_default_str()); }
Option Option::delimiter(char between) { return Option(option_->delimiter(between)); }
bool Option::given() const { return option_->count() > 0; }
Option Option::expected(int values) { return Option(option_->expected(values)); }
Option Option::excludes(const Option& other) { return Option(option_->excludes(other.option_)); }
Option Option::needs(const Option& other) { return Option(option_->needs(other.option_)); }

Command Command::add_subcommand(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}
Command Command::add_option_group(const std::string& name) { return Command(app_->add_option_group(name)); }

template <class Value>
Option Command::add_option(const std::string& name, Value& value, const std::string& help) {
  Option option(app_->add_option(name, value, help));
  return std::is_same_v<Value, uint64_t> ? option.check(whole_number()) : option;
}
template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, uint32_t&, const std::string&);
template Option Command::add_option(const std::string&, uint64_t&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<uint32_t>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&);

Option Command::add_option_function(const std::string& name, std::function<void(uint32_t)> function,
                                    const std::string& help) {
  return Option(app_->add_option_function<uint32_t>(name, function, help));
}
Option Command::add_flag(const std::string& name, bool& value, const std::string& help) {
  return Option(app_->add_flag(name, value, help));
}
Option Command::add_flag_callback(const std::string& name, std::function<void()> function, const std::string& help) {
  return Option(app_->add_flag_callback(name, function, help));
}

void Command::require_option(int count) { app_->require_option(count); }
void Command::allow_extras() { app_->allow_extras(); }
void Command::callback(std::function<void()> run) { app_->callback(run); }

void Command::refuse_unused(const std::string& chosen, const std::vector<OptionUse>& table) const {
  for (const CLI::Option* option : app_->get_options()) {
    if (option->get_positional() || option == app_->get_help_ptr()) continue;
    const auto use = std::find_if(table.begin(), table.end(),
                                  [&](const OptionUse& entry) { return option->check_name(entry.option); });
    if (use == table.end()) throw Failure("no case of " + app_->get_name() + " uses " + option->get_name());
    if (option->count() == 0 || use->cases.empty()) continue;
    std::string cases;
    bool used = false;
    for (const char* name : use->cases)
      used = used || name == chosen, cases += (cases.empty() ? "" : ", ") + std::string(name);
    if (!used)
      throw Failure(app_->get_name() + " " + chosen + " does not use " + use->option + ", which is for " + cases +
                    "; leave it out");
  }
}

Program::Program(const std::string& help, const std::string& name, const std::string& version,
                 const std::string& footer)
    : Command(nullptr), owned_(std::make_unique<CLI::App>(help, name)) {
  app_ = owned_.get();
  app_->set_version_flag("--version", version);
  app_->require_subcommand(0, 1);
  app_->get_formatter()->column_width(34);
  app_->footer(footer);
}
Program::~Program() = default;

void Program::run(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
    if (app_->get_subcommands().empty()) std::fputs(app_->help().c_str(), stdout);
  } catch (const CLI::Success& help) {
    app_->exit(help);
  } catch (const CLI::ParseError& error) {
    throw Failure(std::string(error.what()) + "; see sandglass --help");
  }
}

}  // namespace sandglass::host

#include "models/program/command_help.h"

#include <CLI/CLI.hpp>

namespace sandglass::host {

namespace {

constexpr size_t k_text_width = 82;  // the width of the right column

// Breaks the text into lines, between words.
std::string in_lines(const std::string& text) {
  std::string lines;
  size_t length = 0;
  for (const std::string& word : CLI::detail::split(text, ' ')) {
    if (length > 0 && length + 1 + word.size() > k_text_width) lines += '\n', length = 0;
    else if (length > 0) lines += ' ', ++length;
    lines += word, length += word.size();
  }
  return lines;
}

class Formatter : public CLI::Formatter {
 public:
  // `below` is the word for what stands below a command.
  Formatter(const std::string& below, size_t width) {
    label("SUBCOMMAND", below);
    label("Positionals", "Arguments");
    column_width(width);
  }

  // An option's type is its unit and what the value must be, such as "N:1 to 256".
  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string type = option->get_type_name();
    return option->get_positional() || option->get_type_size() == 0 ? "" : " " + type.substr(0, type.find(':'));
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    const std::string type = option->get_type_name();
    std::string standard = option->get_default_str();
    if (standard.starts_with('[')) standard = standard.substr(1, standard.size() - 2);  // a list of values
    std::string notes = type.find(':') == std::string::npos ? "" : type.substr(type.find(':') + 1);
    const auto note = [&](const std::string& text) { notes += (notes.empty() ? "" : "; ") + text; };
    if (option->get_required() && !option->get_positional()) note("required");
    if (!standard.empty() && !option->get_positional()) note("default: " + standard);
    return in_lines(option->get_description() + (notes.empty() ? "" : " (" + notes + ")"));
  }

  std::string make_subcommands(const CLI::App* app, CLI::AppFormatMode mode) const override {
    return CLI::detail::find_and_replace(CLI::Formatter::make_subcommands(app, mode), "\n\n", "\n");
  }
};

}  // namespace

void format_help(CLI::App& program) {
  program.formatter(std::make_shared<Formatter>("COMMAND", 18));
  program.get_help_ptr()->group("");
  program.get_option("--version")->group("");
  program.footer(
      "The options of each: sandglass COMMAND --help\n"
      "Version: sandglass --version. Exit codes: 0 done, 1 a check failed, 2 bad input or usage, 130 interrupted.\n"
      "Begin with: sandglass run demo --out out");
  for (CLI::App* command : program.get_subcommands({})) {
    const bool has_suites = !command->get_subcommands({}).empty();
    command->formatter(std::make_shared<Formatter>("SUITE", has_suites ? 12 : 28));
    command->footer("");
    for (CLI::App* suite : command->get_subcommands({})) suite->formatter(std::make_shared<Formatter>("", 28));
    if (!has_suites) continue;
    command->get_help_ptr()->group("");
    command->footer("The options of each: sandglass " + command->get_name() + " SUITE --help");
  }
}

}  // namespace sandglass::host

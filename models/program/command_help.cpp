#include "models/program/command_help.h"

#include <algorithm>

namespace sandglass::host {

namespace {

constexpr size_t k_line = 110, k_widest_word = 24;

struct Row {
  std::string word, text;
};

// The rows below each other, their texts in one column; what is too long is broken between words.
std::string table(const std::vector<Row>& rows) {
  size_t column = 0;
  for (const Row& row : rows) column = std::max(column, std::min(row.word.size(), k_widest_word) + 4);
  std::string all;
  for (const Row& row : rows) {
    std::string line = "  " + row.word;
    if (line.size() + 2 > column) all += line + "\n", line.clear();
    line.resize(column, ' ');
    for (size_t at = 0; at < row.text.size();) {
      const size_t end = std::min(row.text.find(' ', at), row.text.size());
      const bool first = line.size() == column;
      if (!first && line.size() + 1 + end - at > k_line) {
        all += line + "\n";
        line.assign(column, ' ');
      } else if (!first) {
        line += ' ';
      }
      line += row.text.substr(at, end - at);
      at = end + 1;
    }
    all += line + "\n";
  }
  return all;
}

Row row_of(const Option& option) {
  Row row = {"", option.help};
  for (const std::string& name : option.names) row.word += (row.word.empty() ? "" : ", ") + name;
  if (!option.value_word.empty()) row.word += " " + option.value_word;
  std::string notes = option.check.range;
  const auto note = [&](const std::string& text) { notes += (notes.empty() ? "" : "; ") + text; };
  if (option.is_required && !option.is_argument()) note("required");
  if (!option.default_text.empty()) note("default: " + option.default_text);
  if (!notes.empty()) row.text += " (" + notes + ")";
  return row;
}

std::string usage(const Command& command) {
  std::string line = "Usage: sandglass";
  if (command.parent() != nullptr) line += " " + command.path();
  if (!command.commands().empty()) return line + (command.parent() == nullptr ? " COMMAND" : " SUITE") + " [OPTIONS]\n";
  for (const auto& option : command.options()) {
    if (option->is_argument()) line += option->is_required ? " " + option->name() : " [" + option->name() + "]";
    else if (option->is_required) line += " " + option->name() + " " + option->value_word;
  }
  return line + " [OPTIONS]\n";
}

std::string commands_by_group(const Command& command) {
  std::vector<Row> rows;
  size_t widest = 0;
  for (const auto& below : command.commands()) widest = std::max(widest, below->name().size());
  std::string text, group;
  const auto flush = [&] {
    if (rows.empty()) return;
    text += (group.empty() ? "Suites" : group) + ":\n" + table(rows);
    rows.clear();
  };
  for (const auto& below : command.commands()) {
    if (below->group() != group) flush();
    group = below->group();
    std::string name = below->name();
    name.resize(widest, ' ');
    rows.push_back({name, below->help()});
  }
  flush();
  return text;
}

}  // namespace

std::string help_of(const Command& command) {
  std::string text = command.help() + "\n" + usage(command);
  if (!command.commands().empty()) {
    text += "\n" + commands_by_group(command);
    const std::string one = command.parent() == nullptr ? "COMMAND" : command.path() + " SUITE";
    text += "\nThe options of each: sandglass " + one + " --help\n";
  }
  std::vector<Row> arguments, options;
  for (const auto& option : command.options()) (option->is_argument() ? arguments : options).push_back(row_of(*option));
  if (!arguments.empty()) text += "\nArguments:\n" + table(arguments);
  if (command.commands().empty()) {
    options.push_back({"-h, --help", "Print this help"});
    text += "\nOptions:\n" + table(options);
  }
  if (command.parent() == nullptr)
    text +=
        "Version: sandglass --version. Exit codes: 0 done, 1 a check failed, 2 bad input or usage, 130 interrupted.\n"
        "Begin with: sandglass run demo --out out\n";
  return text;
}

}  // namespace sandglass::host

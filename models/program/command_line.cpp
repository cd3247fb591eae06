// Three things meet CLI11 here: the commands' options, its help, and what it lacks: the first wrong word in the order
// typed is named, with the nearest right one.
#include "models/program/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "models/files/command_files.h"
#include "models/files/failure.h"
#include "models/program/nearest_name.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

// ----------------------------------------------------------------------------------------------- values of options

// CLI11 itself reads -1 as 2^64 - 1 and 010 as 8.
ValueRule whole_number(uint64_t low, uint64_t high) {
  const bool open = high == UINT64_MAX;
  const std::string range = std::to_string(low) + " to " + (open ? "2^64 - 1" : std::to_string(high));
  const auto holds = [=](const std::string& text) {
    uint64_t value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return std::to_string(value) == text && value >= low && value <= high;
  };
  return {holds, open ? "" : range, "a whole number from " + range, {}};
}

// CLI::Range compares so that NaN is in every range.
ValueRule number(double low, double high) {
  char range[64];
  std::snprintf(range, sizeof range, "%.9g to %.9g", low, high);
  const auto holds = [=](const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0' && value >= low && value <= high;
  };
  return {holds, range, std::string("a number from ") + range, {}};
}

ValueRule one_of(const std::vector<std::string>& names) {
  const auto holds = [=](const std::string& text) {
    return std::find(names.begin(), names.end(), text) != names.end();
  };
  const std::string all = list_of(names, "or");
  return {holds, all, all, names};
}

CommandOption required(CommandOption option) { return option.required = true, option; }
CommandOption standard(const char* text, CommandOption option) { return option.standard = text, option; }
CommandOption by_commas(CommandOption option) { return option.by_commas = true, option; }
CommandOption writes(CommandOption option) { return option.writes = true, option; }
CommandOption needs(const char* other, CommandOption option) { return option.needs = other, option; }
CommandOption excludes(const char* other, CommandOption option) { return option.excludes = other, option; }

CommandOption threads_option(uint32_t& threads) {
  return {"--threads", &threads, "N", "Threads; the result does not depend on them", whole_number(1, 256)};
}

CommandOption isa_option(std::string& isa) {
  std::vector<std::string> names;
  for (sandglass_isa i = SANDGLASS_ISA_AUTOMATIC; i <= SANDGLASS_ISA_WASM; ++i)
    if (const char* name = sandglass_isa_name(i); name != nullptr) names.emplace_back(name);
  return {"--isa", &isa, "NAME", "Instruction set of the kernels", one_of(names)};
}

CommandOption json_option(std::string& file) {
  return writes({"--json", &file, "FILE", "Write the measurements to this file, as JSON"});
}

CommandOption seed_option(uint64_t& seed, const char* help) {
  return {"--seed", &seed, "N", help, whole_number(0, UINT64_MAX)};
}

namespace {

using Names = std::vector<std::string>;

// The words up to a command, each followed by a space, such as "bench granular ".
std::string path(const CLI::App& at) {
  return at.get_parent() == nullptr ? "" : path(*at.get_parent()) + at.get_name() + " ";
}
std::string named(const CLI::App& at) { return in_quotes(path(at).substr(0, path(at).size() - 1)); }
std::string of(const CLI::App& at) { return at.get_parent() == nullptr ? "" : " of " + named(at); }

// What CLI11 would do by templates, which are slow to compile: the text of a value goes to the target, or is refused.
bool take(const std::string& text, std::string* value) { return *value = text, true; }
bool take(const std::string& text, double* value) { return *value = std::strtod(text.c_str(), nullptr), true; }
template <class Whole>
bool take(const std::string& text, Whole* value) {
  return std::from_chars(text.data(), text.data() + text.size(), *value).ec == std::errc();
}
template <class Value>
bool take_all(const std::vector<std::string>& texts, Value* value) {
  return take(texts[0], value);
}
template <class Value>
bool take_all(const std::vector<std::string>& texts, std::vector<Value>* values) {
  values->resize(texts.size());
  for (size_t i = 0; i < texts.size(); ++i)
    if (!take(texts[i], &(*values)[i])) return false;
  return true;
}

// The value as the help shows it.
template <class Value>
std::string shown(const Value& value) {
  return CLI::detail::to_string(value);
}
template <class Value>
std::string shown(const std::vector<Value>& values) {
  return CLI::detail::join(values);
}

template <class Value>
CLI::Option* declare(const CommandOption& option, Value* value, CLI::App* command) {
  const auto taken = [value](const std::vector<std::string>& texts) { return take_all(texts, value); };
  return command->add_option(option.names, taken, option.help)->default_str(shown(*value));
}
template <class Value>
CLI::Option* declare(const CommandOption& option, std::vector<Value>* values, CLI::App* command) {
  return declare<std::vector<Value>>(option, values, command)->expected(CLI::detail::expected_max_vector_size);
}
CLI::Option* declare(const CommandOption& option, bool* value, CLI::App* command) {
  return command->add_flag(option.names, *value, option.help);
}

constexpr const char* k_empty = "its value is empty. Give it one, or leave it out.";

void declare(const CommandOption& option, CLI::App* command) {
  CLI::Option* declared = std::visit([&](auto* value) { return declare(option, value, command); }, option.target);
  if (*option.type != '\0') declared->type_name(option.type);
  if (option.by_commas) declared->delimiter(',');
  if (const ValueRule& rule = option.rule; rule.holds != nullptr)
    declared->check(CLI::Validator(
        [rule](const std::string& text) {
          if (rule.holds(text)) return std::string();
          return in_quotes(text) + " is not " + rule.wanted + "." + suggestion(text, rule.names);
        },
        rule.range));
  else if (std::holds_alternative<std::string*>(option.target) ||
           std::holds_alternative<std::vector<std::string>*>(option.target))
    declared->check(
        CLI::Validator([](const std::string& text) { return std::string(text.empty() ? k_empty : ""); }, ""));
  if (option.standard != nullptr) declared->default_str(option.standard);
  declared->required(option.required);
}

void declare(const Command& command, const char* group, CLI::App* above, int* exit_code) {
  const std::string& why = command.left_out;
  const std::string help = command.help + std::string(why.empty() ? "" : " (not in this build)");
  CLI::App* declared = above->add_subcommand(command.name, help)->group(group);
  for (const CommandOption& option : command.options) declare(option, declared);
  for (const CommandOption& option : command.options) {
    CLI::Option* one = declared->get_option(CLI::detail::split(option.names, ',')[0]);
    if (option.needs != nullptr) one->needs(declared->get_option(option.needs));
    if (option.excludes != nullptr) one->excludes(declared->get_option(option.excludes));
  }
  for (const Command& suite : command.suites) declare(suite, "Suites", declared, exit_code);
  if (!command.suites.empty()) declared->require_subcommand(1);
  declared->allow_extras(!why.empty())->callback([=] {
    if (!why.empty()) throw Failure("cannot run " + named(*declared) + ": " + why);
    if (!command.run) return;
    for (const CommandOption& option : command.options)
      if (const auto* file = std::get_if<std::string*>(&option.target); option.writes && !(*file)->empty())
        claim_output(**file);
    *exit_code = command.run();
  });
}

// ------------------------------------------------------------------------------------------------------------ help

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

// -------------------------------------------------------------------------------------------------------- mistakes

Names names_below(const CLI::App& at) {
  Names names;
  for (const CLI::App* below : at.get_subcommands({})) names.push_back(below->get_name());
  return names;
}

std::string unknown_option(const CLI::App& at, const std::string& name) {
  Names suites, names;
  const CLI::App* above = at.get_parent();
  if (above != nullptr && above->get_parent() == nullptr) above = &at;
  if (above != nullptr)
    for (const CLI::App* suite : above->get_subcommands({}))
      if (suite->get_option_no_throw(name) != nullptr) suites.push_back(named(*suite));
  const std::string what = "unknown option " + in_quotes(name) + of(at);
  if (!suites.empty()) return what + ": it belongs to " + list_of(suites, "and") + ". Leave it out.";
  for (const CLI::Option* option : at.get_options({}))
    for (const std::string& each : option->get_lnames()) names.push_back("--" + each);
  return what + "." + suggestion(name, names);
}

// A word that starts with a minus is an option, but a minus before a digit begins a number.
bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9');
}

// What is wrong with the option, which is the word before `next`. Moves `next` behind the option's values.
std::string mistake_of_option(const CLI::App& at, const Names& words, size_t* next,
                              std::set<const CLI::Option*>* given) {
  const std::string& word = words[*next - 1];
  const bool is_long = word.starts_with("--");
  const std::string name = is_long ? word.substr(0, word.find('=')) : word.substr(0, 2);
  const CLI::Option* option = at.get_option_no_throw(name);
  if (option == nullptr) return unknown_option(at, is_long ? name : word);
  const std::string which = in_quotes(option->get_name()) + of(at);
  const int least = option->get_items_expected_min(), most = option->get_items_expected_max();
  if (most == 0) return word.size() > name.size() ? which + " takes no value: write it alone." : "";
  if (!given->insert(option).second && most == 1) return which + " is given twice. Give it once.";
  if (word == name + "=") return "cannot use " + which + ": " + k_empty;
  int values = word.size() > name.size() ? 1 : 0;
  while (values < most && *next < words.size() && !is_option(words[*next])) ++values, ++*next;
  if (values >= least) return "";
  const std::string type = option->get_type_name();
  return which + " needs a value: write " + in_quotes(option->get_name() + " " + type.substr(0, type.find(':'))) + ".";
}

// The first mistake in the names of commands and options, or an empty string. Cuts off the words behind it, and those
// behind --help. CLI11 checks the values, and which options must or must not stand together.
std::string first_mistake(const CLI::App*& at, Names* words) {
  std::set<const CLI::Option*> given;
  std::string mistake;
  int arguments = 0;  // how many more may be given
  for (size_t next = 0; next < words->size();) {
    const std::string word = (*words)[next++];
    const std::vector<const CLI::App*> below = at->get_subcommands({});
    const auto found = std::find_if(below.begin(), below.end(), [&](auto* app) { return app->get_name() == word; });
    if (at->get_allow_extras() || word == "--") return "";
    if (is_option(word)) mistake = mistake_of_option(*at, *words, &next, &given);
    else if (found != below.end())
      for (const CLI::Option* option : (at = *found)->get_options({}))
        arguments += option->get_positional() ? option->get_items_expected_max() : 0;
    else if (!below.empty())
      mistake = (at->get_parent() == nullptr ? "unknown command " : "unknown suite ") + in_quotes(word) + of(*at) +
                "." + suggestion(word, names_below(*at));
    else if (--arguments < 0) mistake = "unknown argument " + in_quotes(word) + of(*at) + ". Leave it out.";
    if (mistake.empty() && word != "-h" && word != "--help") continue;
    words->resize(next);
    return mistake;
  }
  if (at->get_require_subcommand_min() == 0) return "";
  return named(*at) + " needs a suite: " + list_of(names_below(*at), "or") + ".";
}

void parse(CLI::App& program, int argc, char** argv) {
  Names words(argv + 1, argv + argc);
  const CLI::App* at = &program;
  const std::string mistake = first_mistake(at, &words);
  const std::string see = " See: sandglass " + path(*at) + "--help.";
  std::reverse(words.begin(), words.end());  // as CLI11 expects them
  try {
    program.parse(std::move(words));
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::ValidationError& error) {  // "--frames: why"
    const std::string text = error.what();
    const size_t colon = text.find(": ");
    throw Failure("cannot use " + in_quotes(text.substr(0, colon)) + of(*at) + text.substr(colon) + see);
  } catch (const CLI::ParseError& error) {
    throw Failure((mistake.empty() ? "cannot start " + named(*at) + ": " + error.what() + "." : mistake) + see);
  }
}

}  // namespace

int run_command_line(const std::vector<CommandGroup>& groups, int argc, char** argv) {
  CLI::App program("Sandglass: sand, light and shadow inside a fixed slice of every frame", "sandglass");
  program.set_version_flag("--version", "sandglass " + std::to_string(SANDGLASS_VERSION_MAJOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_MINOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_PATCH));
  program.set_help_flag("-h,--help", "Print this help");
  program.option_defaults()->always_capture_default()->disable_flag_override();
  program.require_subcommand(0, 1);
  int exit_code = 0;
  for (const CommandGroup& group : groups)
    for (const Command& command : group.commands) declare(command, group.name, &program, &exit_code);
  format_help(program);
  try {
    parse(program, argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  }
  if (program.get_subcommands().empty()) std::fputs(program.help().c_str(), stdout);
  return exit_code;
}

}  // namespace sandglass::host

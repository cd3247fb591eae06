// The commands' options and their help meet CLI11 here, and what every program does around a command: bad input of any
// kind ends as one sentence on stderr.
#include "models/program/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <optional>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/output_folder.h"
#include "models/work/progress.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

namespace fs = std::filesystem;

// ----------------------------------------------------------------------------------------------- values of options

// The number that the whole text is. CLI11 itself reads -1 as 2^64 - 1 and 010 as 8, and rounds by long double, which is
// not the same on every machine.
template <class Number>
std::optional<Number> number_of(const std::string& text) {
  Number value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end) return {};
  return value;
}

ValueRule whole_number(uint64_t low, uint64_t high) {
  const bool open = high == UINT64_MAX;
  const std::string range = std::to_string(low) + " to " + (open ? "2^64 - 1" : std::to_string(high));
  const auto holds = [=](const std::string& text) {
    const auto value = number_of<uint64_t>(text);
    return value && *value >= low && *value <= high;
  };
  return {holds, open ? "" : range, "a whole number from " + range};
}

// CLI::Range compares so that NaN is in every range.
ValueRule number(double low, double high) {
  char range[64];
  std::snprintf(range, sizeof range, "%.9g to %.9g", low, high);
  const auto holds = [=](const std::string& text) {
    const auto value = number_of<double>(text);
    return value && *value >= low && *value <= high;
  };
  return {holds, range, std::string("a number from ") + range};
}

ValueRule one_of(const std::vector<std::string>& names) {
  const auto holds = [=](const std::string& text) {
    return std::find(names.begin(), names.end(), text) != names.end();
  };
  const std::string all = list_of(names, "or");
  return {holds, all, all};
}

template <class Member, class Value>
CommandOption with(CommandOption option, Member CommandOption::*member, Value value) {
  option.*member = value;
  return option;
}
CommandOption required(CommandOption option) { return with(option, &CommandOption::required, true); }
CommandOption standard(const char* text, CommandOption option) { return with(option, &CommandOption::standard, text); }
CommandOption by_commas(CommandOption option) { return with(option, &CommandOption::by_commas, true); }
CommandOption writes(CommandOption option) { return with(option, &CommandOption::output, CommandOption::Output::file); }
CommandOption fills(CommandOption option) {
  return with(option, &CommandOption::output, CommandOption::Output::folder);
}
CommandOption fills_partly(CommandOption option) {
  return with(option, &CommandOption::output, CommandOption::Output::partly);
}
CommandOption needs(const char* other, CommandOption option) { return with(option, &CommandOption::needs, other); }
CommandOption excludes(const char* other, CommandOption option) {
  return with(option, &CommandOption::excludes, other);
}

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

// The words up to a command, each followed by a space, such as "bench granular ".
std::string path(const CLI::App& at) {
  return at.get_parent() == nullptr ? "" : path(*at.get_parent()) + at.get_name() + " ";
}
std::string named(const CLI::App& at) { return in_quotes(path(at).substr(0, path(at).size() - 1)); }
std::string of(const CLI::App& at) { return at.get_parent() == nullptr ? "" : " of " + named(at); }
std::string name_of(const CLI::App& at) {
  return at.get_parent() == nullptr ? at.get_name() : name_of(*at.get_parent());
}

// The text of a value goes to its target, or is refused.
bool take(const std::string& text, std::string* value) {
  *value = text;
  return true;
}
template <class Number>
bool take(const std::string& text, Number* value) {
  const auto number = number_of<Number>(text);
  if (number) *value = *number;
  return number.has_value();
}
template <class Value>
bool take(const std::vector<std::string>& texts, std::vector<Value>* values) {
  values->resize(texts.size());
  return std::equal(texts.begin(), texts.end(), values->begin(),
                    [](const std::string& text, Value& value) { return take(text, &value); });
}
template <class Value>
bool take(const std::vector<std::string>& texts, Value* value) {
  return take(texts[0], value);
}

// What is wrong with a text that no rule is for; empty if nothing is.
std::string fault_of(const std::string& text) {
  if (text.empty()) return "its value is empty. Give it one, or leave it out.";
  if (text.starts_with("--"))
    return in_quotes(text) + " is an option, so the value is missing. A file of that name is \"./" + text + "\".";
  return "";
}

void declare(const CommandOption& option, CLI::App* command) {
  const auto to_target = [&](auto* value) {
    using Value = std::decay_t<decltype(*value)>;
    if constexpr (std::is_same_v<Value, bool>) {
      return command->add_flag(option.names, *value, option.help);
    } else {
      const auto taken = [value](const std::vector<std::string>& texts) { return take(texts, value); };
      return command->add_option(option.names, taken, option.help)
          ->default_str(CLI::detail::checked_to_string<Value, Value>(*value))
          ->expected(CLI::detail::expected_count<Value>::value);
    }
  };
  CLI::Option* declared = std::visit(to_target, option.target);
  if (*option.type != '\0') declared->type_name(option.type);
  if (option.by_commas) declared->delimiter(',');
  if (const ValueRule& rule = option.rule; rule.holds != nullptr)
    declared->check(CLI::Validator(
        [rule](const std::string& text) {
          if (rule.holds(text)) return std::string();
          return in_quotes(text) + " is not " + rule.wanted + ".";
        },
        rule.range));
  else if (std::holds_alternative<std::string*>(option.target) ||
           std::holds_alternative<std::vector<std::string>*>(option.target))
    declared->check(CLI::Validator([](const std::string& text) { return fault_of(text); }, ""));
  if (option.standard != nullptr) declared->default_str(option.standard);
  declared->required(option.required);
}

// Whether two names are of one file, or will be.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) return fs::equivalent(a, b, error);
  return fs::weakly_canonical(fs::absolute(a), error) == fs::weakly_canonical(fs::absolute(b), error);
}

// Throws a Failure where an output cannot be written, or has the name of what the command reads or writes besides.
void check_outputs(const Command& command) {
  using Output = CommandOption::Output;
  const auto paths_of = [](const CommandOption& option) {
    std::vector<std::string> paths;
    if (option.rule.holds != nullptr) return paths;
    if (const auto* path = std::get_if<std::string*>(&option.target)) paths = {**path};
    if (const auto* several = std::get_if<std::vector<std::string>*>(&option.target)) paths = **several;
    std::erase(paths, "");
    return paths;
  };
  for (const CommandOption& written : command.options) {
    if (written.output == Output::none) continue;
    for (const std::string& path : paths_of(written)) {
      if (written.output == Output::file) require_writable(path);
      require_space(path);
      for (const CommandOption& other : command.options)
        for (const std::string& named : paths_of(other))
          if (&other == &written || !same_file(path, named)) continue;
          else if (other.output == Output::none)
            throw cannot("write", path, "the same command reads it", "Write somewhere else");
          else throw cannot("write", path, "two outputs of the command have this name", "Give each a name of its own");
    }
  }
}

// Runs the command. Its folder of outputs appears whole.
int run_checked(const Command& command) {
  check_outputs(command);
  std::optional<OutputFolder> folder;
  std::string wanted;
  bool partly = false;
  for (const CommandOption& option : command.options) {
    const auto* path = std::get_if<std::string*>(&option.target);
    if (path == nullptr || (*path)->empty()) continue;
    if (option.output != CommandOption::Output::folder && option.output != CommandOption::Output::partly) continue;
    wanted = **path;
    partly = option.output == CommandOption::Output::partly;
    folder.emplace(wanted);
    **path = folder->path();
  }
  const int exit_code = command.run();
  if (!folder) return exit_code;
  if (exit_code == k_exit_interrupted && !partly) return exit_code;
  folder->keep();
  std::fprintf(stderr, "written to %s\n", wanted.c_str());
  return exit_code;
}

void declare(const Command& command, const char* group, CLI::App* above, int* exit_code) {
  const std::string& why = command.left_out;
  const std::string help = command.help + std::string(why.empty() ? "" : " (not in this build)");
  CLI::App* declared = above->add_subcommand(command.name, help)->group(group);
  for (const CommandOption& option : command.options) declare(option, declared);
  for (const CommandOption& option : command.options) {
    CLI::Option* added = declared->get_option(CLI::detail::split(option.names, ',')[0]);
    if (option.needs != nullptr) added->needs(declared->get_option(option.needs));
    if (option.excludes != nullptr) added->excludes(declared->get_option(option.excludes));
  }
  for (const Command& suite : command.suites) declare(suite, "Suites", declared, exit_code);
  if (!command.suites.empty()) declared->require_subcommand(1);
  declared->allow_extras(!why.empty())->callback([=] {
    if (!why.empty()) throw Failure("cannot run " + named(*declared) + ": " + why);
    if (!command.run) return;
    *exit_code = run_checked(command);
  });
}

// ------------------------------------------------------------------------------------------------------------ help

constexpr size_t k_text_width = 82;  // the width of the right column

// Breaks the text into lines, between words.
std::string in_lines(const std::string& text) {
  std::string lines;
  size_t length = 0;
  for (const std::string& word : CLI::detail::split(text, ' ')) {
    if (length > 0 && length + 1 + word.size() > k_text_width) {
      lines += '\n';
      length = 0;
    } else if (length > 0) {
      lines += ' ';
      ++length;
    }
    lines += word;
    length += word.size();
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

void format_help(const char* begin_with, CLI::App* program) {
  const std::string name = program->get_name();
  program->formatter(std::make_shared<Formatter>("COMMAND", 18));
  program->get_help_ptr()->group("");
  program->get_option("--version")->group("");
  program->footer("The options of each: " + name + " COMMAND --help\nVersion: " + name +
                  " --version. Exit codes: 0 done, 1 a check failed, 2 bad input or usage, 130 interrupted.\n" +
                  "Begin with: " + name + " " + begin_with);
  for (CLI::App* command : program->get_subcommands({})) {
    const bool has_suites = !command->get_subcommands({}).empty();
    command->formatter(std::make_shared<Formatter>("SUITE", has_suites ? 12 : 28));
    command->footer("");
    for (CLI::App* suite : command->get_subcommands({})) suite->formatter(std::make_shared<Formatter>("", 28));
    if (!has_suites) continue;
    command->get_help_ptr()->group("");
    command->footer("The options of each: " + name + " " + command->get_name() + " SUITE --help");
  }
}

void parse(CLI::App& program, int argc, char** argv) {
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::ParseError& error) {
    const CLI::App* at = &program;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().back();
    const std::string text = error.what(), see = " See: " + name_of(*at) + " " + path(*at) + "--help.";
    const size_t colon = text.find(": ");
    if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr)  // "--frames: why"
      throw Failure("cannot use " + in_quotes(text.substr(0, colon)) + of(*at) + text.substr(colon) + see);
    throw Failure("cannot start " + (at == &program ? in_quotes(at->get_name()) : named(*at)) + ": " + text + "." +
                  see);
  }
}

// Runs the command that is asked for and returns its exit code. A wrong command line is a Failure, and then nothing
// runs.
int run_command(const Program& what, int argc, char** argv) {
  CLI::App program(what.help, what.name);
  program.set_version_flag("--version", std::string(what.name) + " " + std::to_string(SANDGLASS_VERSION_MAJOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_MINOR) + "." +
                                            std::to_string(SANDGLASS_VERSION_PATCH));
  program.set_help_flag("-h,--help", "Print this help");
  program.option_defaults()->always_capture_default()->disable_flag_override();
  program.require_subcommand(0, 1);
  int exit_code = 0;
  for (const CommandGroup& group : what.groups)
    for (const Command& command : group.commands) declare(command, group.name, &program, &exit_code);
  format_help(what.begin_with, &program);
  try {
    parse(program, argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  }
  if (program.get_subcommands().empty()) std::fputs(program.help().c_str(), stdout);
  return exit_code;
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  const auto say = [&](const std::string& sentence) {
    std::fprintf(stderr, "%s: %s\n", program.name, sentence.c_str());
  };
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // what was said before Ctrl-C is not lost
    listen_for_interrupt();
    const int exit_code = run_command(program, argc, argv);
    // What a command says is a result too, and a full disk may be behind it.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw cannot("write", "standard output", "the disk is full or failing", "Send it elsewhere");
    if (exit_code == k_exit_interrupted) say("interrupted.");
    return exit_code;
  } catch (const std::bad_alloc&) {
    say("cannot go on: this machine has too little memory for what was asked. Ask for less.");
  } catch (const std::filesystem::filesystem_error& error) {
    say(message("read", error.path1().string(), error.code().message(), "Check its permissions and the disk"));
  } catch (const std::exception& error) {
    say(error.what());
  }
  return k_exit_bad_input;
}

}  // namespace sandglass::host

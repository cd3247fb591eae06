#include "models/program/command_mistakes.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>

#include "models/files/failure.h"
#include "models/program/nearest_name.h"

namespace sandglass::host {

namespace {

using Names = std::vector<std::string>;

// The words up to a command, each followed by a space, such as "bench granular ".
std::string path(const CLI::App& at) {
  return at.get_parent() == nullptr ? "" : path(*at.get_parent()) + at.get_name() + " ";
}
std::string named(const CLI::App& at) { return in_quotes(path(at).substr(0, path(at).size() - 1)); }
std::string of(const CLI::App& at) { return at.get_parent() == nullptr ? "" : " of " + named(at); }

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

}  // namespace

void parse_command_line(CLI::App& program, int argc, char** argv) {
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

}  // namespace sandglass::host

#include "models/program/command_mistakes.h"

#include <algorithm>
#include <cctype>

namespace sandglass::host {

namespace {

std::string quoted(const std::string& text) { return '"' + text + '"'; }

// " See: sandglass bench granular --help."
std::string see(const Command& at) {
  return " See: sandglass " + (at.parent() == nullptr ? "" : at.path() + " ") + "--help.";
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? "" : " Did you mean " + quoted(nearest) + "?";
}

std::string of(const Command& at) { return at.parent() == nullptr ? "" : " of " + quoted(at.path()); }

// Below the program stand commands, below a command its suites.
const char* kind_below(const Command& at) { return at.parent() == nullptr ? "command" : "suite"; }

std::vector<std::string> names_below(const Command& at) {
  std::vector<std::string> names;
  for (const auto& command : at.commands()) names.push_back(command->name());
  return names;
}

// Letters that are wrong, missing, too many or swapped with their neighbour.
size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i)
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

// The suites beside `at` and below it that have the option.
std::vector<std::string> suites_with(const Command& at, const std::string& option) {
  std::vector<std::string> suites;
  const bool is_suite = at.parent() != nullptr && at.parent()->parent() != nullptr;
  for (const Command* above : {&at, is_suite ? at.parent() : nullptr})
    for (size_t i = 0; above != nullptr && above->parent() != nullptr && i < above->commands().size(); ++i)
      if (above->commands()[i]->find_option(option) != nullptr) suites.push_back(quoted(above->commands()[i]->path()));
  return suites;
}

// "--output FILE", or the word of an argument.
std::string written(const Option& option) {
  return option.is_argument() ? option.name() : quoted(option.name() + " " + option.value_word);
}

}  // namespace

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
  constexpr size_t k_prefix = 3;  // letters that tell names apart
  std::string nearest;
  size_t least = 2 + word.size() / 4;  // one more than may be wrong
  for (const std::string& name : names) {
    const bool begins = name.starts_with(word) && word.size() >= k_prefix + name.find_first_not_of('-');
    const size_t wrong = begins ? 1 : distance(word, name);
    if (wrong < least) least = wrong, nearest = name;
  }
  return nearest;
}

std::string list_of(const std::vector<std::string>& names, const std::string& last) {
  std::string list;
  for (size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " " + last + " ") + names[i];
  return list;
}

Failure unknown_command(const Command& at, const std::string& word) {
  return Failure(std::string("unknown ") + kind_below(at) + " " + quoted(word) + of(at) + "." +
                 suggestion(word, names_below(at)) + see(at));
}

Failure unknown_option(const Command& at, const std::string& word) {
  const std::string what = "unknown option " + quoted(word) + of(at);
  const std::vector<std::string> suites = suites_with(at, word);
  if (!suites.empty()) return Failure(what + ": it belongs to " + list_of(suites, "and") + ". Leave it out." + see(at));
  std::vector<std::string> names = {"--help"};
  if (at.parent() == nullptr) names.emplace_back("--version");
  for (const auto& option : at.options())
    if (!option->is_argument()) names.insert(names.end(), option->names.begin(), option->names.end());
  return Failure(what + "." + suggestion(word, names) + see(at));
}

Failure unknown_argument(const Command& at, const std::string& word) {
  return Failure("unknown argument " + quoted(word) + of(at) + ". Leave it out." + see(at));
}

Failure wrong_value(const Command& at, const Option& option, const std::string& value) {
  return Failure("cannot take " + quoted(value) + " as " + quoted(option.name()) + of(at) + ": it is not " +
                 option.check.wanted + "." + suggestion(value, option.check.names) + see(at));
}

Failure value_missing(const Command& at, const Option& option) {
  return Failure(quoted(option.name()) + of(at) + " needs a value: write " + written(option) + "." + see(at));
}

Failure no_value_wanted(const Command& at, const Option& option) {
  return Failure(quoted(option.name()) + of(at) + " takes no value: write it alone." + see(at));
}

Failure given_twice(const Command& at, const Option& option) {
  return Failure(quoted(option.name()) + of(at) + " is given twice. Give it once." + see(at));
}

void expect_complete(const Command& chosen) {
  if (!chosen.commands().empty())
    throw Failure(quoted(chosen.path()) + " needs a " + kind_below(chosen) + ": " + list_of(names_below(chosen), "or") +
                  "." + see(chosen));
  for (const auto& option : chosen.options()) {
    if (option->is_required && option->taken == 0) {
      std::string help = option->help;
      help[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(help[0])));
      throw Failure(quoted(chosen.path()) + " needs " + written(*option) + ": " + help + "." + see(chosen));
    }
    if (option->taken == 0) continue;
    for (const Option* other : option->excluded)
      if (other->taken > 0)
        throw Failure("cannot use " + quoted(option->name()) + " and " + quoted(other->name()) + of(chosen) +
                      " together. Leave one out." + see(chosen));
    for (const Option* other : option->needed)
      if (other->taken == 0)
        throw Failure("cannot use " + quoted(option->name()) + of(chosen) + " without " + quoted(other->name()) +
                      ". Add it, or leave both out." + see(chosen));
  }
}

}  // namespace sandglass::host

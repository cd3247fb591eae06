#include "models/program/command_line.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "models/files/failure.h"
#include "models/program/command_help.h"
#include "models/program/command_mistakes.h"

namespace sandglass::host {

namespace {

// Decimal digits alone: strtoull takes signs, spaces, octal and hexadecimal numbers.
bool read_whole(const std::string& text, uint64_t* value) {
  const bool digits = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
  errno = 0;
  *value = std::strtoull(text.c_str(), nullptr, 10);
  return digits && errno == 0;
}

bool read_number(const std::string& text, double* value) {
  char* end = nullptr;
  *value = std::strtod(text.c_str(), &end);
  const bool starts = !text.empty() && (std::isdigit(static_cast<unsigned char>(text[0])) != 0 || text[0] == '-' ||
                                        text[0] == '+' || text[0] == '.');
  return starts && *end == '\0' && std::isfinite(*value);
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

void store(const std::string& text, std::string* value) { *value = text; }
void store(const std::string& text, double* value) { read_number(text, value); }
template <class Whole>
requires std::is_integral_v<Whole>
void store(const std::string& text, Whole* value) {
  uint64_t whole = 0;
  read_whole(text, &whole);
  *value = static_cast<Whole>(whole);
}

template <class Value>
Check check_of() {
  if constexpr (std::is_integral_v<Value>)
    return whole_number(0, static_cast<uint64_t>(std::numeric_limits<Value>::max()));
  else if constexpr (std::is_floating_point_v<Value>)
    return {"",
            "a number",
            [](const std::string& text) {
              double value;
              return read_number(text, &value);
            },
            {}};
  else return {};
}

std::string default_of(const std::string& value) { return value; }
template <class Number>
requires std::is_arithmetic_v<Number> std::string default_of(Number value) {
  return text_of(static_cast<double>(value));
}

template <class Value>
struct Several {
  using Each = Value;
  static constexpr bool k_is = false;
};
template <class Value>
struct Several<std::vector<Value>> {
  using Each = Value;
  static constexpr bool k_is = true;
};

}  // namespace

Check whole_number(uint64_t low, uint64_t high) {
  const bool open = high == std::numeric_limits<uint64_t>::max();
  const std::string range = std::to_string(low) + " to " + (open ? "2^64 - 1" : std::to_string(high));
  return {open ? "" : range,
          "a whole number from " + range,
          [low, high](const std::string& text) {
            uint64_t value = 0;
            return read_whole(text, &value) && value >= low && value <= high;
          },
          {}};
}

Check number(double low, double high) {
  const std::string range = text_of(low) + " to " + text_of(high);
  return {range,
          "a number from " + range,
          [low, high](const std::string& text) {
            double value = 0.0;
            return read_number(text, &value) && value >= low && value <= high;
          },
          {}};
}

Check number_above_zero() {
  return {"above 0",
          "a number above 0",
          [](const std::string& text) {
            double value = 0.0;
            return read_number(text, &value) && value > 0.0;
          },
          {}};
}

Check one_of(std::vector<std::string> names) {
  const std::string all = list_of(names, "or");
  return {all, all,
          [names](const std::string& text) { return std::find(names.begin(), names.end(), text) != names.end(); },
          names};
}

Option& Option::required() { return is_required = true, *this; }
Option& Option::checked(const Check& c) { return check = c, *this; }
Option& Option::by_default(const std::string& text) { return default_text = text, *this; }
Option& Option::separated_by(char c) { return separator = c, *this; }
Option& Option::values(uint32_t count) { return least_values = most_values = count, *this; }
Option& Option::excludes(Option& other) {
  excluded.push_back(&other), other.excluded.push_back(this);
  return *this;
}
Option& Option::needs(Option& other) { return needed.push_back(&other), *this; }

Command::Command(const Command* parent, const std::string& name, const std::string& help)
    : parent_(parent), name_(name), help_(help) {}

Command& Command::add_command(const std::string& name, const std::string& help, const std::string& group) {
  commands_.push_back(std::make_unique<Command>(this, name, help));
  commands_.back()->group_ = group;
  return *commands_.back();
}

Option& Command::add_option(const std::string& words, const std::string& help) {
  options_.push_back(std::make_unique<Option>());
  Option& option = *options_.back();
  const size_t space = words.find(' ');
  for (size_t at = 0, end = 0; at < std::min(space, words.size()); at = end + 1) {
    end = std::min({words.find(',', at), space, words.size()});
    option.names.push_back(words.substr(at, end - at));
  }
  if (space != std::string::npos) option.value_word = words.substr(space + 1);
  option.help = help;
  return option;
}

template <class Value>
Option& Command::add(const std::string& words, Value& value, const std::string& help) {
  using Each = typename Several<Value>::Each;
  Option& option = add_option(words, help);
  option.check = check_of<Each>();
  if constexpr (Several<Value>::k_is) {
    for (const Each& each : value) option.default_text += (option.default_text.empty() ? "" : ",") + default_of(each);
    option.most_values = std::numeric_limits<uint32_t>::max();
    option.take = [&option, &value](const std::string& text) {
      if (option.taken == 0) value.clear();
      value.emplace_back();
      store(text, &value.back());
    };
  } else {
    option.default_text = default_of(value);
    option.take = [&value](const std::string& text) { store(text, &value); };
  }
  return option;
}
template Option& Command::add(const std::string&, std::string&, const std::string&);
template Option& Command::add(const std::string&, uint32_t&, const std::string&);
template Option& Command::add(const std::string&, uint64_t&, const std::string&);
template Option& Command::add(const std::string&, int&, const std::string&);
template Option& Command::add(const std::string&, double&, const std::string&);
template Option& Command::add(const std::string&, std::vector<std::string>&, const std::string&);
template Option& Command::add(const std::string&, std::vector<uint32_t>&, const std::string&);
template Option& Command::add(const std::string&, std::vector<double>&, const std::string&);

Option& Command::add_flag(const std::string& name, bool& value, const std::string& help) {
  Option& option = add_option(name, help);
  option.least_values = option.most_values = 0;
  option.take = [&value](const std::string&) { value = true; };
  return option;
}

void Command::is_left_out(const std::string& why, const std::string& remedy) {
  is_left_out_ = true;
  help_ += " (not in this build)";
  runs([this, why, remedy]() -> int { throw Failure("cannot run \"" + path() + "\": " + why + ". " + remedy); });
}

std::string Command::path() const {
  return parent_ == nullptr || parent_->parent_ == nullptr ? name_ : parent_->path() + " " + name_;
}

Option* Command::find_option(const std::string& name) const {
  for (const auto& option : options_)
    if (std::find(option->names.begin(), option->names.end(), name) != option->names.end()) return option.get();
  return nullptr;
}

// Words are read from left to right; each is the name of a command, an option, a value of an option, or an argument.
class CommandLineReader {
 public:
  CommandLineReader(Command& program, std::vector<std::string> words) : at_(&program), words_(std::move(words)) {}

  enum class Asked { run, help, version };

  Asked read() {
    for (bool options_end = false; next_ < words_.size();) {
      const std::string& word = words_[next_++];
      if (!options_end && (word == "-h" || word == "--help")) return Asked::help;
      if (at_->is_left_out_) return Asked::run;
      if (!options_end && word == "--version" && at_->parent() == nullptr) return Asked::version;
      if (!options_end && word == "--") options_end = true;
      else if (!options_end && is_option(word)) read_option(word);
      else if (!at_->commands().empty()) descend(word);
      else read_argument(word);
    }
    if (at_->parent() == nullptr) return Asked::help;
    if (!at_->is_left_out_) expect_complete(*at_);
    return Asked::run;
  }

  const Command& chosen() const { return *at_; }
  int run() const { return at_->action_(); }

 private:
  // A minus before a digit begins a number.
  static bool is_option(const std::string& word) {
    return word.size() > 1 && word[0] == '-' && std::isdigit(static_cast<unsigned char>(word[1])) == 0;
  }

  void descend(const std::string& word) {
    for (const auto& command : at_->commands())
      if (command->name() == word) {
        at_ = command.get();
        return;
      }
    throw unknown_command(*at_, word);
  }

  void read_option(const std::string& word) {
    const bool is_long = word.starts_with("--");
    const size_t equals = is_long ? word.find('=') : std::string::npos;
    const std::string name = is_long ? word.substr(0, equals) : word.substr(0, 2);
    Option* option = at_->find_option(name);
    if (option == nullptr) throw unknown_option(*at_, is_long ? name : word);
    const bool attached = is_long ? equals != std::string::npos : word.size() > 2;
    if (option->most_values == 0) {
      if (attached) throw no_value_wanted(*at_, *option);
      option->take(""), ++option->taken;
      return;
    }
    if (option->taken > 0 && option->most_values == 1) throw given_twice(*at_, *option);
    uint32_t count = 0;
    if (attached) take(option, is_long ? word.substr(equals + 1) : word.substr(2)), ++count;
    while (count < option->most_values && next_ < words_.size() && !is_option(words_[next_]) &&
           (count < option->least_values || words_left() > arguments_wanted()))
      take(option, words_[next_++]), ++count;
    if (count < option->least_values) throw value_missing(*at_, *option);
  }

  void read_argument(const std::string& word) {
    for (const auto& option : at_->options())
      if (option->is_argument() && option->taken < option->most_values) return take(option.get(), word);
    throw unknown_argument(*at_, word);
  }

  void take(Option* option, const std::string& word) {
    for (size_t from = 0, end = 0; from <= word.size(); from = end + 1) {
      end = option->separator == '\0' ? word.size() : std::min(word.find(option->separator, from), word.size());
      const std::string value = word.substr(from, end - from);
      if (option->check.holds && !option->check.holds(value)) throw wrong_value(*at_, *option, value);
      option->take(value), ++option->taken;
    }
  }

  size_t words_left() const { return words_.size() - next_; }
  size_t arguments_wanted() const {
    return static_cast<size_t>(std::count_if(at_->options().begin(), at_->options().end(), [](const auto& option) {
      return option->is_argument() && option->is_required && option->taken == 0;
    }));
  }

  Command* at_;
  std::vector<std::string> words_;
  size_t next_ = 0;
};

int run_command_line(Command& program, const std::string& version, int argc, char** argv) {
  CommandLineReader reader(program, {argv + 1, argv + argc});
  switch (reader.read()) {
    case CommandLineReader::Asked::help:
      std::fputs(help_of(reader.chosen()).c_str(), stdout);
      return 0;
    case CommandLineReader::Asked::version:
      std::printf("%s\n", version.c_str());
      return 0;
    case CommandLineReader::Asked::run:
      break;
  }
  return reader.run();
}

}  // namespace sandglass::host

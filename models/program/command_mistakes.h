// What is wrong with a command line, in a sentence each: the wrong word, the nearest right one, and where to read on.
#pragma once

#include <string>
#include <vector>

#include "models/files/failure.h"
#include "models/program/command_line.h"

namespace sandglass::host {

Failure unknown_command(const Command& at, const std::string& word);
Failure unknown_option(const Command& at, const std::string& word);
Failure unknown_argument(const Command& at, const std::string& word);
Failure wrong_value(const Command& at, const Option& option, const std::string& value);
Failure value_missing(const Command& at, const Option& option);
Failure no_value_wanted(const Command& at, const Option& option);
Failure given_twice(const Command& at, const Option& option);

// A Failure where a required option is missing, two options exclude each other or one needs another.
void expect_complete(const Command& chosen);

// The name that `word` was probably meant to be; empty where none is near. Near means: few letters are wrong, missing,
// too many or swapped, or `word` begins the name.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

// "a, b or c"
std::string list_of(const std::vector<std::string>& names, const std::string& last);

}  // namespace sandglass::host

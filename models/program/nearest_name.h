// Names for messages: the nearest one to a mistyped word, and lists of them.
#pragma once

#include <string>
#include <vector>

namespace sandglass::host {

// The name that `word` was probably meant to be; empty where none is near. Near means: few letters are wrong, missing,
// too many or swapped, or `word` begins the name.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

// " Did you mean "threads"?", or nothing.
std::string suggestion(const std::string& word, const std::vector<std::string>& names);

// "a, b or c"
std::string list_of(const std::vector<std::string>& names, const std::string& last);

inline std::string in_quotes(const std::string& text) { return '"' + text + '"'; }

}  // namespace sandglass::host

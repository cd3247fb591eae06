// Text of numbers and words, as mesh files hold it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

namespace sandglass::host {

struct Words {
  std::string_view text;
  size_t at = 0;

  // The next word, or nothing at the end.
  std::string_view next() {
    constexpr std::string_view k_space = " \t\r\n\f\v";
    const size_t first = text.find_first_not_of(k_space, at);
    if (first == std::string_view::npos) return {};
    at = text.find_first_of(k_space, first);
    if (at == std::string_view::npos) at = text.size();
    return text.substr(first, at - first);
  }
  // The next line without its end; `\` at an end goes on in the next one, and what stands behind # is no part of it.
  bool line(std::string* out) {
    out->clear();
    if (at >= text.size()) return false;
    for (bool goes_on = true; goes_on && at < text.size();) {
      const size_t end = std::min(text.find_first_of("\r\n", at), text.size());  // old programs write returns alone
      std::string_view part = text.substr(at, end - at);
      at = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
      size_t comment = part.find('#');  // "-1.#IND" is none: it is how some programs write what is no number
      while (comment != std::string_view::npos && comment > 0 && part[comment - 1] != ' ' && part[comment - 1] != '\t')
        comment = part.find('#', comment + 1);
      part = part.substr(0, comment);
      goes_on = part.ends_with('\\');
      if (goes_on) part.remove_suffix(1);
      *out += part;
      if (goes_on) *out += ' ';
    }
    return true;
  }
};

// All of the word must be the number; words for what is not finite are none. (Only strtod is in every C++ library.)
inline bool number_of(std::string_view word, double* number) {
  const size_t sign = !word.empty() && (word[0] == '-' || word[0] == '+');
  if (word.size() <= sign || word.size() > 300 || !(word[sign] == '.' || (word[sign] >= '0' && word[sign] <= '9')))
    return false;
  const std::string text(word);
  char* end = nullptr;
  *number = std::strtod(text.c_str(), &end);
  return end == text.c_str() + text.size() && std::isfinite(*number);
}

// "has "-1.#IND" in line 12 where a number must stand. Export it again."
inline std::string no_number(std::string_view word, size_t line) {
  const std::string what = word.empty() ? "nothing" : "\"" + std::string(word.substr(0, 20)) + "\"";
  return "has " + what + " in line " + std::to_string(line) + " where a number must stand. Export it again.";
}

}  // namespace sandglass::host

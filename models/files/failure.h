// How the program reports that it cannot go on: one message that says what it cannot do, with which file or part, why,
// and what to do about it. The program prints it and exits with code 2.
#pragma once

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>
#include <vector>

namespace sandglass::host {

struct Failure : std::runtime_error {
  explicit Failure(const std::string& message) : std::runtime_error(message) {}
};

// For example: cannot read "x.obj": the file ends in a face (line 12). Export it again.
inline std::string message(const std::string& verb, const std::string& which, const std::string& why,
                           const std::string& remedy) {
  return "cannot " + verb + " \"" + which + "\": " + why + ". " + remedy + ".";
}

// The library's reasons have the form "why: what to do." or "why; what to do." Such a reason ends the message as "why. What to
// do."
inline std::string message(const std::string& verb, const std::string& which, std::string reason) {
  const size_t end = std::max(reason.rfind(": ") + 1, reason.rfind("; ") + 1);  // 0: neither
  if (end > 0 && end + 1 < reason.size()) {
    reason[end - 1] = '.';
    reason[end + 1] = static_cast<char>(std::toupper(static_cast<unsigned char>(reason[end + 1])));
  }
  return "cannot " + verb + " \"" + which + "\": " + reason + (reason.ends_with('.') ? "" : ".");
}

inline std::string in_quotes(const std::string& text) { return '"' + text + '"'; }

// "a, b or c", where `last` is "or".
inline std::string list_of(const std::vector<std::string>& names, const std::string& last) {
  std::string list;
  for (size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " " + last + " ") + names[i];
  return list;
}

inline Failure cannot(const std::string& verb, const std::string& which, const std::string& why,
                      const std::string& remedy) {
  return Failure(message(verb, which, why, remedy));
}
inline Failure cannot(const std::string& verb, const std::string& which, const std::string& reason) {
  return Failure(message(verb, which, reason));
}
inline Failure cannot(const std::string& verb, const std::string& which, const char* reason) {
  return Failure(message(verb, which, reason == nullptr ? "the library gives no reason" : reason));
}

}  // namespace sandglass::host

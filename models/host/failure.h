// How the host side reports that it cannot go on: one message that says what it cannot do, with which file or part, why,
// and what to do about it. The program prints it and exits with code 2.
#pragma once

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>

namespace sandglass::host {

struct Failure : std::runtime_error {
  explicit Failure(const std::string& message) : std::runtime_error(message) {}
};

// cannot read "x.obj": the file ends in a face (line 12). Export it again.
inline std::string message(const std::string& verb, const std::string& which, const std::string& why,
                           const std::string& remedy) {
  return "cannot " + verb + " \"" + which + "\": " + why + ". " + remedy + ".";
}
inline Failure cannot(const std::string& verb, const std::string& which, const std::string& why,
                      const std::string& remedy) {
  return Failure(message(verb, which, why, remedy));
}

// The library says "why: what to do" or "why; what to do", or why alone; a message ends in "why. What to do."
inline std::string reason_text(const char* reason) {
  std::string text = reason == nullptr ? "the library gives no reason" : reason;
  const size_t end = std::max(text.rfind(": ") + 1, text.rfind("; ") + 1);  // 0: neither
  if (end > 0 && end + 1 < text.size()) {
    text[end - 1] = '.';
    text[end + 1] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[end + 1])));
  }
  return text.ends_with('.') ? text : text + ".";
}

// The library refuses: cannot read "room.light": the file is cut off. Copy it again.
inline Failure cannot(const std::string& verb, const std::string& which, const char* reason) {
  return Failure("cannot " + verb + " \"" + which + "\": " + reason_text(reason));
}

}  // namespace sandglass::host

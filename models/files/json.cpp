// See json.h.
#include "models/files/json.h"

#include <charconv>
#include <cmath>
#include <cstdint>

namespace sandglass::host {

namespace {

// The length of the UTF-8 character that `text` begins with; 0 where it begins with none (RFC 3629).
size_t character_length(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<uint8_t>(text[i]) : uint8_t{0}; };
  const uint8_t first = byte(0);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xC2 && first < 0xE0 ? 2 : first >= 0xE0 && first < 0xF0 ? 3 : 4;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t i = 1; i < length; ++i)
    if (byte(i) >> 6 != 2) return 0;
  const uint8_t second = byte(1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool no_character = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || no_character ? 0 : length;
}

// The parts between two brackets, each on a line of its own. No string holds a line break, so every one is indented.
std::string in_brackets(char open, char close, const std::vector<std::string>& parts) {
  std::string text(1, open);
  for (const std::string& part : parts) {
    text += text.size() == 1 ? "\n " : ",\n ";
    for (const char c : part) {
      text += c;
      if (c == '\n') text += ' ';
    }
  }
  if (!parts.empty()) text += '\n';
  return text + close;
}

}  // namespace

Json::Json(std::string_view value) : text_("\"") {
  while (!value.empty()) {
    const size_t length = character_length(value);
    const auto first = static_cast<uint8_t>(value[0]);
    constexpr char k_digits[] = "0123456789abcdef";
    if (length == 0) text_ += "\\ufffd";
    else if (first < 0x20) text_ += {'\\', 'u', '0', '0', k_digits[first >> 4], k_digits[first & 15]};
    else if (first == '"' || first == '\\') text_ += {'\\', value[0]};
    else text_ += value.substr(0, length);
    value.remove_prefix(length == 0 ? 1 : length);
  }
  text_ += '"';
}

Json::Json(double value) : text_("null") {
  char digits[32];
  if (std::isfinite(value)) text_.assign(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

Json Json::list(const std::vector<Json>& values) {
  std::vector<std::string> parts;
  for (const Json& value : values) parts.push_back(value.text_);
  Json list;
  list.text_ = in_brackets('[', ']', parts);
  return list;
}

Json Json::object(const std::vector<Member>& members) {
  std::vector<std::string> parts;
  for (const auto& [name, value] : members) parts.push_back(Json(name).text_ + ": " + value.text_);
  Json object;
  object.text_ = in_brackets('{', '}', parts);
  return object;
}

}  // namespace sandglass::host

// JSON as text that is put together from its parts. Strings are escaped; bytes that are not UTF-8, as a file's name may
// have, become U+FFFD. Members keep the order in which they were added.
#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sandglass::host {

class Json {
 public:
  Json() : text_("null") {}
  Json(std::string_view value);
  Json(const std::string& value) : Json(std::string_view(value)) {}
  Json(const char* value) : Json(std::string_view(value)) {}
  // The shortest text that reads back as the same number. What is not finite becomes null.
  Json(double value);
  Json(float value) : Json(static_cast<double>(value)) {}
  // A template, so that no pointer becomes a bool.
  template <std::integral Whole>
  Json(Whole value) : text_(std::to_string(value)) {
    if (std::same_as<Whole, bool>) text_ = value ? "true" : "false";
  }
  template <size_t count>
  Json(const float (&values)[count]) : Json(list(std::vector<Json>(values, values + count))) {}

  static Json list(const std::vector<Json>& values);
  using Member = std::pair<std::string, Json>;
  static Json object(const std::vector<Member>& members);

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace sandglass::host

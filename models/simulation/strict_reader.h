// Reads JSON strictly: the reader remembers which keys were asked for, and refuses every other key.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "models/files/failure.h"
#include "models/geometry/vec3.h"
#include "models/mesh/generated.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

constexpr double k_length_limit = SANDGLASS_COORDINATE_LIMIT;

// Whole numbers with all their digits: a limit that prints as the number that breaks it helps nobody.
inline std::string number_text(double value) {
  char text[40];
  const bool whole = value == std::floor(value) && std::fabs(value) < 1e9;
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%g", value);
  return text;
}

// Reads one JSON object. `where` is "" for the file itself, "bodies[0]." for a body in it.
class StrictReader {
 public:
  StrictReader(const nlohmann::json& object, const std::string& source, const std::string& where)
      : object_(object), source_(source), where_(where) {
    if (!object.is_object())
      fail(where.empty() ? "the file" : "\"" + where.substr(0, where.size() - 1) + "\"", "must be an object { }");
  }

  [[noreturn]] void fail(const std::string& what, const std::string& problem) const {
    throw cannot("read", source_, what + " " + problem);
  }
  [[noreturn]] void refuse(const std::string& key, const std::string& problem) const { fail(quoted(key), problem); }

  bool is_array(const std::string& key) const { return object_.contains(key) && object_[key].is_array(); }
  bool has(const std::string& key) {
    known_.insert(key);
    return object_.contains(key);
  }

  double number(const std::string& key, double otherwise, double low, double high) {
    return has(key) ? checked(key, object_[key], low, high) : otherwise;
  }
  uint32_t integer(const std::string& key, uint32_t otherwise, uint32_t low, uint32_t high) {
    return has(key) ? checked_integer(key, object_[key], low, high) : otherwise;
  }
  float real(const std::string& key, float otherwise, double low, double high) {
    return has(key) ? static_cast<float>(checked(key, object_[key], low, high)) : otherwise;
  }

  std::string text(const std::string& key, const std::string& otherwise) {
    if (!has(key)) return otherwise;
    if (!object_[key].is_string()) refuse(key, "must be a text in quotes");
    return object_[key].get<std::string>();
  }

  // The index of the key's text among `choices`. A missing key gives `otherwise`, or is refused when that is negative.
  int choice(const std::string& key, const std::vector<std::string>& choices, int otherwise) {
    std::string list;
    for (const std::string& name : choices) list += (list.empty() ? "\"" : ", \"") + name + "\"";
    if (!has(key)) {
      if (otherwise < 0) refuse(key, "is missing; give one of " + list);
      return otherwise;
    }
    const std::string value = text(key, "");
    const auto found = std::find(choices.begin(), choices.end(), value);
    if (found == choices.end()) refuse(key, "is \"" + value + "\"; it must be one of " + list);
    return static_cast<int>(found - choices.begin());
  }

  std::vector<double> numbers(const std::string& key, size_t count, double low, double high) {
    const nlohmann::json& list = object_[key];
    if (!list.is_array() || list.size() != count)
      refuse(key, "must be a list of " + std::to_string(count) + " numbers");
    std::vector<double> values;
    for (size_t i = 0; i < count; ++i)
      values.push_back(checked(key + "[" + std::to_string(i) + "]", list[i], low, high));
    return values;
  }
  Profile outline(const std::string& key) {
    const nlohmann::json& list = object_[key];
    if (!list.is_array() || list.size() < 3 || list.size() > 1000)
      refuse(key, "must be a list of 3 to 1000 points [r, y]");
    Profile profile;
    for (size_t i = 0; i < list.size(); ++i) {
      const std::string at = key + "[" + std::to_string(i) + "]";
      if (!list[i].is_array() || list[i].size() != 2) refuse(at, "must be a point [r, y]");
      profile.push_back({checked(at + "[0]", list[i][0], 0.0, k_length_limit),
                         checked(at + "[1]", list[i][1], -k_length_limit, k_length_limit)});
    }
    return profile;
  }
  Vec3 vector(const std::string& key, Vec3 otherwise, double low, double high) {
    if (!has(key)) return otherwise;
    const std::vector<double> v = numbers(key, 3, low, high);
    return {v[0], v[1], v[2]};
  }

  Quaternion rotation(const std::string& key) {
    if (!has(key)) return k_no_rotation;
    if (object_[key].is_array()) {
      const std::vector<double> v = numbers(key, 4, -1e6, 1e6);
      if (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3] < 1e-12)
        refuse(key, "is a quaternion of length 0; use [0, 0, 0, 1]");
      return normalised(Quaternion{v[0], v[1], v[2], v[3]});
    }
    StrictReader turn = child(key);
    const Vec3 axis = turn.vector("axis", {0, 1, 0}, -1e6, 1e6);
    if (length(axis) < 1e-6) turn.refuse("axis", "has length 0; give a direction");
    constexpr double k_radians_per_degree = 0.017453292519943295;
    const double radians = turn.number("degrees", 0.0, -360.0, 360.0) * k_radians_per_degree;
    turn.finish();
    return rotation_by(normalised(axis) * radians);
  }

  StrictReader child(const std::string& key) const { return StrictReader(object_[key], source_, where_ + key + "."); }

  template <class Read>
  void each(const std::string& key, size_t limit, Read read) {
    if (!has(key)) return;
    const nlohmann::json& list = object_[key];
    if (!list.is_array()) refuse(key, "must be a list [ ]");
    if (list.size() > limit)
      refuse(key, "has " + std::to_string(list.size()) + " entries; at most " + std::to_string(limit) + " are taken");
    for (size_t i = 0; i < list.size(); ++i) {
      StrictReader entry(list[i], source_, where_ + key + "[" + std::to_string(i) + "].");
      read(entry);
      entry.finish();
    }
  }

  // Refuses the first key that nobody asked for.
  void finish() const {
    for (const auto& [key, value] : object_.items())
      if (!known_.contains(key)) {
        std::string list;
        for (const std::string& name : known_) list += (list.empty() ? "" : ", ") + name;
        refuse(key, "is not a known key; known here are " + list);
      }
  }

  std::string quoted(const std::string& key) const { return "\"" + where_ + key + "\""; }

 private:
  double checked(const std::string& key, const nlohmann::json& value, double low, double high) const {
    if (!value.is_number()) refuse(key, "must be a number");
    const double number = value.get<double>();
    if (!std::isfinite(number)) refuse(key, "is not a finite number");
    if (number < low || number > high)
      refuse(key,
             "is " + number_text(number) + "; it must lie between " + number_text(low) + " and " + number_text(high));
    return number;
  }
  uint32_t checked_integer(const std::string& key, const nlohmann::json& value, uint32_t low, uint32_t high) const {
    const double number = checked(key, value, low, high);
    if (number != std::floor(number)) refuse(key, "is " + number_text(number) + "; it must be a whole number");
    return static_cast<uint32_t>(number);
  }

  const nlohmann::json& object_;
  const std::string& source_;
  std::string where_;
  std::set<std::string> known_;
};

}  // namespace sandglass::host

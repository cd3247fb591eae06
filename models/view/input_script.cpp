// See input_script.h.
#include "models/view/input_script.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "models/files/failure.h"

namespace sandglass::host {

namespace {

bool is_key(const std::string& name) {
  constexpr const char* k_long[] = {"Left", "Right", "Up", "Down", "Space"};
  if (std::any_of(std::begin(k_long), std::end(k_long), [&](const char* key) { return name == key; })) return true;
  if (name.size() != 1) return false;
  const unsigned char c = static_cast<unsigned char>(name[0]);
  return (c >= 'A' && c <= 'Z') || std::isdigit(c) != 0 || c == '-' || c == '=';
}

// Returns true when the words after the frame's number make an event.
bool parse_action(std::istringstream* words, InputEvent* event) {
  std::string action, word, rest;
  *words >> action;
  if (action == "cursor") {
    event->kind = InputKind::cursor;
    if (!(*words >> event->x >> event->y)) return false;
  } else if (action == "scroll") {
    event->kind = InputKind::scroll;
    if (!(*words >> event->y)) return false;
  } else if (action == "press" || action == "release") {
    event->kind = action == "press" ? InputKind::press : InputKind::release;
    if (!(*words >> word) || (word != "left" && word != "right")) return false;
    event->right_button = word == "right";
  } else if (action == "down" || action == "up") {
    event->kind = action == "down" ? InputKind::key_down : InputKind::key_up;
    if (!(*words >> event->key) || !is_key(event->key)) return false;
  } else {
    return false;
  }
  return !(*words >> rest) && std::isfinite(event->x) && std::isfinite(event->y);
}

}  // namespace

std::vector<InputEvent> parse_input_script(const std::string& text) {
  std::vector<InputEvent> events;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    if (part.find_first_not_of(" \t\n\r") == std::string::npos) continue;
    std::istringstream words(part);
    InputEvent event;
    int64_t frame = -1;
    if (!(words >> frame) || frame < 0 || frame > UINT32_MAX || !parse_action(&words, &event))
      throw cannot("take as --script", part, "it is no event",
                   "Write FRAME cursor X Y, FRAME press left, FRAME release right, FRAME scroll N, FRAME down KEY or "
                   "FRAME up KEY, with semicolons between events");
    event.frame = static_cast<uint32_t>(frame);
    events.push_back(std::move(event));
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const InputEvent& a, const InputEvent& b) { return a.frame < b.frame; });
  return events;
}

}  // namespace sandglass::host

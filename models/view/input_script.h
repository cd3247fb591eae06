// What a user does to the viewer, as events. Tests and films give them as text: "FRAME ACTION ...; FRAME ACTION ...".
//
//   12 cursor 400 300      the cursor goes there, pixels from the upper left corner
//   12 press left          a mouse button goes down: left turns the camera, right pushes the sand
//   30 release left
//   40 scroll 2            notches; above 0 comes nearer
//   50 down P              a key goes down: a letter, a digit, - =, or Left Right Up Down Space
//   60 up P
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

enum class InputKind { cursor, press, release, scroll, key_down, key_up };

struct InputEvent {
  uint32_t frame = 0;
  InputKind kind = InputKind::cursor;
  double x = 0.0, y = 0.0;  // the cursor's place; a scroll uses y
  bool right_button = false;
  std::string key = {};  // for example "P", "-", "Left"
};

// The events, sorted by frame. Events of one frame keep the order of the text. A Failure names what cannot be
// understood.
std::vector<InputEvent> parse_input_script(const std::string& text);

}  // namespace sandglass::host

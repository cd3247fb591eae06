// A day with a phone in rooms that nobody has tuned to: light that changes, what covers the lens, lamps of every size,
// doors, two lamps, the open. Each row is the worst of many sessions, in four directions, that a seed has drawn.
#pragma once

#include <functional>

#include "models/rooms/panorama.h"
#include "tests/laboratory/room/day_phone.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct DayChoice {
  std::vector<std::string> cases;  // empty: all
  std::vector<RadianceMap> rooms;  // captured ones; may be empty
  uint64_t seed = 0;
  uint32_t threads = 1;
  bool quick = false;  // one seed instead of three
};

std::vector<std::string> day_cases();
std::vector<Verdict> day_verdicts(const DayChoice& choice, const std::function<bool(uint64_t, uint64_t)>& progress);

}  // namespace sandglass::host

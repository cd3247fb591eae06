// Whether drawn sand looks like sand: the kit's picture of a pile beside a path tracing of balls of 0.6 mm on the same
// surface, in three lights, from three distances and from the dark side; how its grains move; and controls.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/files/image.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct LookOptions {
  bool quick = false;   // one light, one distance
  std::string picture;  // PNG of every view, the kit's left and the truth right; empty: none
  uint32_t threads = 1;
};

// `progress` gets the number of views done, and of all; it returns false to stop. Needs Embree, else a Failure.
std::vector<Verdict> verify_look(const LookOptions& options,
                                 const std::function<bool(size_t done, size_t all)>& progress);

// The whole pile in the first light: by the kit on the left, by plain.frag on the right.
Picture plain_picture(uint32_t threads);

// What a renderer gets of a poured pile and of one asleep: draw calls, vertices, bytes. 16.5 grains would be drawn for each
// particle otherwise.
std::vector<Verdict> handed_over(uint32_t particles);

}  // namespace sandglass::host
